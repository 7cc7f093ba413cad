import { element } from './element.js';
import { createHead } from './head.js';
import { createScene } from './scene.js';
import { text } from './text.js';
import { createTheme } from './theme.js';

/**
 * The page's frame with the median face in it, which is there before the sliders are. Where they
 * will be, it says how far they have come.
 *
 * @param {import('phiz').FaceModel} model needed no longer than this takes
 */
export function createStage(model) {
  // The head at rest is painted on the median face, whatever the link asks for.
  const median = model.face();
  const head = createHead(model, median);
  median.free();

  const canvas = element('canvas', { class: 'view', tabindex: 0, role: 'img', 'aria-label': text.stage });
  const root = element('main', { class: 'stage' }, canvas);
  const tools = element('div', { class: 'tools' });
  const bar = element(
    'header',
    { class: 'bar' },
    element('h1', { class: 'brand' }, text.name, ' ', element('span', {}, text.tagline)),
    tools,
  );
  const come = element('progress', { max: 1, value: 0, 'aria-label': text.loading });
  const waiting = element('aside', { class: 'panel waiting' }, element('p', {}, text.loadingSliders), come);
  const app = element('div', { class: 'app' }, bar, root, waiting);
  // The canvas has to be laid out before the scene measures it.
  document.body.replaceChildren(app);
  const scene = createScene(canvas, head.subject);
  scene.scene.add(head.group);
  const theme = createTheme();
  theme.follow(scene.setTheme);

  return {
    canvas,
    root,
    tools,
    head,
    scene,
    theme,
    /** @param {number} fraction of the model */
    progress(fraction) {
      come.value = fraction;
    },
    /** @param {HTMLElement} panel */
    furnish(panel) {
      waiting.replaceWith(panel);
    },
  };
}

/** @typedef {ReturnType<typeof createStage>} Stage */
