import { element } from '../frame/element.js';
import { tapping, text } from '../text.js';

/**
 * Where both eyes look as a place: right and up on the screen are positive.
 * @param {Record<string, number>} expression
 * @returns {[number, number]}
 */
function placeOf(expression) {
  const sum = (/** @type {string[]} */ ...names) => names.reduce((total, name) => total + (expression[`eyeLook${name}`] ?? 0) / 2, 0);
  return [
    sum('OutLeft', 'InRight') - sum('InLeft', 'OutRight'),
    sum('UpLeft', 'UpRight') - sum('DownLeft', 'DownRight'),
  ];
}

/**
 * What the eyes do to look there: the subject's left is on the right of the screen.
 * @param {number} x @param {number} y -1 to 1
 */
function looks(x, y) {
  const [right, left, up, down] = [x, -x, y, -y].map((amount) => Math.min(1, Math.max(0, amount)));
  return {
    eyeLookOutLeft: right,
    eyeLookInRight: right,
    eyeLookInLeft: left,
    eyeLookOutRight: left,
    eyeLookUpLeft: up,
    eyeLookUpRight: up,
    eyeLookDownLeft: down,
    eyeLookDownRight: down,
  };
}

/**
 * A field with a dot: the eyes look where it is.
 * @param {{ move: (weights: Record<string, number>) => void, cancel: () => void, finish: () => void }} on
 */
export function createGaze({ move, cancel, finish }) {
  /** @type {[number, number]} */
  let at = [0, 0];
  /** @param {number} x @param {number} y */
  function moveTo(x, y) {
    const [across, up] = [x, y].map((value) => Math.min(1, Math.max(-1, Math.round(100 * value) / 100)));
    move(looks(across, up));
  }
  const dot = element('div', {
    class: 'gaze-dot',
    role: 'slider',
    tabindex: 0,
    'aria-label': text.gaze,
    'aria-valuemin': -100,
    'aria-valuemax': 100,
    'aria-describedby': 'gaze-about',
    onkeydown: (/** @type {KeyboardEvent} */ event) => {
      const step = event.shiftKey ? 0.25 : 0.05;
      /** @type {Record<string, [number, number]>} */
      const to = {
        ArrowLeft: [at[0] - step, at[1]],
        ArrowRight: [at[0] + step, at[1]],
        ArrowUp: [at[0], at[1] + step],
        ArrowDown: [at[0], at[1] - step],
        Home: [0, 0],
        Delete: [0, 0],
      };
      if (event.key === 'Escape' && held !== null) {
        event.stopPropagation();
        held = null;
        cancel();
      }
      if (!(event.key in to)) return;
      event.preventDefault();
      moveTo(...to[event.key]);
      finish();
    },
  });
  const field = element('div', { class: 'gaze', title: tapping(text.gazeAbout) }, dot);
  /** The pointer that has it. @type {number | null} */
  let held = null;
  /** @param {PointerEvent} event */
  function follow(event) {
    const box = field.getBoundingClientRect();
    const reach = (/** @type {number} */ size) => 0.5 * (size - dot.offsetWidth);
    moveTo(
      (event.clientX - box.left - box.width / 2) / reach(box.width),
      (box.top + box.height / 2 - event.clientY) / reach(box.height),
    );
  }
  field.addEventListener('pointerdown', (event) => {
    if (event.button !== 0 || held !== null) return;
    event.preventDefault();
    dot.focus({ preventScroll: true });
    field.setPointerCapture(event.pointerId);
    held = event.pointerId;
    follow(event);
  });
  field.addEventListener('pointermove', (event) => held === event.pointerId && follow(event));
  for (const [type, end] of /** @type {const} */ ([['pointerup', finish], ['pointercancel', cancel]])) {
    field.addEventListener(type, (event) => {
      if (held !== event.pointerId) return;
      held = null;
      end();
    });
  }
  field.addEventListener('dblclick', () => {
    moveTo(0, 0);
    finish();
  });

  return {
    root: element('div', { class: 'gaze-row' }, field, element('p', { class: 'note', id: 'gaze-about' }, tapping(text.gazeAbout))),
    /** @param {Record<string, number>} expression */
    show(expression) {
      at = placeOf(expression);
      dot.style.setProperty('--x', String(at[0]));
      dot.style.setProperty('--y', String(at[1]));
      dot.setAttribute('aria-valuenow', String(Math.round(100 * at[0])));
      dot.setAttribute('aria-valuetext', text.gazeAt(at[0], at[1]));
    },
  };
}
