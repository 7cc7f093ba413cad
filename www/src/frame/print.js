import { element } from './element.js';
import { spoken, text } from '../text.js';

/**
 * What a printed page has under the picture of the stage: the face's name and its lengths.
 * @param {import('phiz').Face} face
 * @param {{ stage: HTMLElement, named: () => string, draw: () => void }} parts `draw` brings the picture up to now
 */
export function createPrinted(face, { stage, named, draw }) {
  const root = element('section', { class: 'printed' });
  window.addEventListener('beforeprint', () => {
    const { clientWidth, clientHeight } = stage;
    // What lies over the picture lies where it does on the screen.
    if (clientWidth && clientHeight) document.documentElement.style.setProperty('--stage-shape', `${clientWidth} / ${clientHeight}`);
    root.replaceChildren(
      element('h2', {}, named() || text.thisFace),
      element(
        'dl',
        { class: 'measures' },
        ...face.model.measures.map(({ name }) => element('div', {}, element('dt', {}, spoken(name)), element('dd', {}, text.millimetres(face.measure(name))))),
      ),
      element('p', { class: 'note' }, face.model.about.title),
    );
    try {
      draw();
    } catch {
      // Without a graphics card the lengths are printed alone.
    }
  });
  return root;
}
