import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { text } from '../text.js';

/** What a key turns: azimuth and polar angle in radians, a factor of the distance. */
/** @type {Record<string, [number, number, number?]>} */
const TURNS = {
  ArrowLeft: [-0.12, 0],
  ArrowRight: [0.12, 0],
  ArrowUp: [0, -0.08],
  ArrowDown: [0, 0.08],
  '+': [0, 0, 0.9],
  '=': [0, 0, 0.9],
  '-': [0, 0, 1.1],
};

/**
 * The keys on a canvas that turn, move and zoom what it shows.
 * @param {HTMLCanvasElement} canvas
 * @param {ReturnType<typeof import('./scene.js').createScene>} scene
 * @param {AddEventListenerOptions} [options]
 */
export function listenToKeys(canvas, scene, options) {
  /** @param {KeyboardEvent} event */
  function press(event) {
    const turn = TURNS[event.key];
    if (!turn || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const [theta, phi, closer] = turn;
    // A plus may take Shift.
    if (event.shiftKey && !closer) scene.pan(-300 * theta, -300 * phi);
    else scene.turn(...turn);
  }
  canvas.addEventListener('keydown', press, options);
}

/**
 * From where the head is seen: buttons, and keys on the canvas.
 * @param {HTMLCanvasElement} canvas
 * @param {ReturnType<typeof import('./scene.js').createScene>} scene
 * @param {HTMLElement[]} more buttons beside them
 */
export function createViewpoint(canvas, scene, ...more) {
  listenToKeys(canvas, scene);
  canvas.addEventListener('dblclick', () => scene.view('front'));
  return element(
    'div',
    { class: 'views', role: 'group', 'aria-label': text.views },
    ...(/** @type {const} */ (['front', 'quarter', 'profile'])).map((name) =>
      element('button', { type: 'button', class: 'chip', onclick: () => scene.view(name) }, text.view[name]),
    ),
    element(
      'button',
      { type: 'button', class: 'tool', 'aria-label': text.resetView, title: text.resetView, onclick: () => scene.view('front') },
      icon('home'),
    ),
    ...more,
  );
}
