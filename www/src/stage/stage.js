import { element } from '../frame/element.js';
import { text } from '../text.js';
import { createTheme } from '../frame/theme.js';
import { createView } from './view.js';

/**
 * The hint at the top, and the views at the bottom with what the page says above them: hair and an open mouth go between.
 * @param {number} height of the canvas
 */
const covered = (height) => /** @type {const} */ ([Math.min(44, 0.09 * height), Math.min(72, 0.16 * height)]);

/**
 * The page's frame with the median face in it, which is there before the sliders are. Where they
 * will be, it says how far they have come.
 *
 * @param {import('phiz').FaceModel} model needed until the stage is complete
 * @param {import('../groundwork/lay.js').Laying} laying of the groundwork
 */
export function createStage(model, laying) {
  /** @type {ReturnType<ReturnType<typeof createView>['complete']> | null} */
  let head = null;

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
  const view = createView(model, canvas, laying, covered);
  const { scene } = view;
  const theme = createTheme();
  theme.follow(scene.setTheme);

  return {
    canvas,
    root,
    tools,
    get head() {
      if (!head) throw new Error('the stage is not complete');
      return head;
    },
    scene,
    theme,
    /** In place of the quick head the real one, with its skin, eyes and light, once the groundwork is laid. */
    async complete() {
      head = view.complete(await view.groundwork);
      document.documentElement.dataset.face = 'complete';
    },
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
