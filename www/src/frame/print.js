import { element } from './element.js';
import { spoken, text } from '../text.js';

/**
 * What a printed page has under the picture of the stage: the face's name and its lengths, and how far they are from those of
 * the face that the picture compares it with.
 * @param {import('phiz').Face} face
 * @param {{
 *   stage: HTMLElement, named: () => string, other: () => { name: string, lengthOf: (measure: string) => number } | null, draw: () => void,
 * }} parts `other` is compared with, if one is; `draw` brings the picture up to now
 */
export function createPrinted(face, { stage, named, other, draw }) {
  const root = element('section', { class: 'printed' });
  window.addEventListener('beforeprint', () => {
    const { clientWidth, clientHeight } = stage;
    // What lies over the picture lies where it does on the screen.
    if (clientWidth && clientHeight) document.documentElement.style.setProperty('--stage-shape', `${clientWidth} / ${clientHeight}`);
    const compared = other();
    /** @param {string} measure */
    function lengthOf(measure) {
      const mm = face.measure(measure);
      if (!compared) return [text.millimetres(mm)];
      const apart = mm - compared.lengthOf(measure);
      return [element('span', { class: 'change' }, Math.abs(apart) < 0.05 ? '0.0' : text.change(apart)), text.millimetres(mm)];
    }
    const name = named() || text.thisFace;
    root.replaceChildren(
      element('h2', {}, compared ? text.versus(name, compared.name) : name),
      ...(compared ? [element('p', { class: 'note' }, text.printedAgainst(compared.name))] : []),
      element(
        'dl',
        { class: 'measures' },
        ...face.model.measures.map(({ name }) => element('div', {}, element('dt', {}, spoken(name)), element('dd', {}, ...lengthOf(name)))),
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
