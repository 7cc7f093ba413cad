import './pins.css';
import { element } from '../frame/element.js';
import { nudgeOf } from '../frame/keys.js';
import { text } from '../text.js';

/** CSS px that an arrow key moves a pin. */
const NUDGE = 1;
/** As many mm is the farthest place from the middle of a head. */
const FARTHEST = 120;

/**
 * A place that is shown over the skin: `id` is its own while it is there, `across` how large what is there is, mm. One that is `still` is
 * there to be seen.
 * @typedef {{ id: string, label: string, place: import('../head/marks.js').Place, across: number, isChosen: boolean, still?: boolean }} Pin
 */

/**
 * Pins over the skin, which are dragged, or reached with Tab and moved with the arrow keys; and one that is still to be put somewhere.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {import('./spotting.js').Spotting} spotting
 * @param {{
 *   choose: (id: string) => void,
 *   move: (id: string, to: import('../head/marks.js').Place) => void,
 *   drop: (id: string) => void,
 *   cancel: () => void,
 *   grow: (id: string, steps: number) => void,
 *   remove: (id: string) => void,
 *   leave: () => void,
 *   put: (place: import('../head/marks.js').Place | null) => void,
 * }} on `drop` and `cancel` end what `move` began; `leave`: Escape; `put`: the pin that was to be put somewhere, null beside the skin
 */
export function createPins(canvas, spotting, on) {
  /** @type {readonly Pin[]} */
  let pins = [];
  /** @type {Map<string, HTMLElement>} */
  const handles = new Map();
  /** @type {{ id: string, pointer: number, grip: readonly [number, number], isMoved: boolean } | null} */
  let held = null;
  /** Where the pin is that is to be put somewhere, CSS px of the canvas. @type {[number, number] | null} */
  let aim = null;

  const find = (/** @type {string} */ id) => pins.find((pin) => pin.id === id);
  /** @param {number} x @param {number} y CSS px of the canvas */
  function under(x, y) {
    const box = canvas.getBoundingClientRect();
    return spotting.under(box.left + x, box.top + y);
  }
  /** What is told of a place to who does not see it. @param {HTMLElement} handle @param {import('../head/marks.js').Place | null} place */
  function tell(handle, place) {
    const where = place && spotting.whereabouts(place);
    handle.setAttribute('aria-valuetext', where ? text.marks.where(where) : text.marks.nowhere);
    handle.setAttribute('aria-valuenow', String(where ? Math.round(where.left) : 0));
  }
  const slider = (/** @type {string} */ name) =>
    element('div', { class: name, role: 'slider', tabindex: 0, 'aria-valuemin': -FARTHEST, 'aria-valuemax': FARTHEST, 'aria-valuenow': 0 });

  /** @param {string} id */
  function handleOf(id) {
    const handle = slider('pin');
    handle.addEventListener('focus', () => {
      const pin = find(id);
      if (!pin) return;
      on.choose(id);
      if (!held) spotting.turnTo(pin.place);
    });
    handle.addEventListener('keydown', (event) => {
      const pin = find(id);
      if (!pin) return;
      const nudge = nudgeOf(event, NUDGE);
      if (event.key === 'Escape') {
        event.stopPropagation();
        if (held) return giveUp();
        return on.leave();
      }
      if (held || event.ctrlKey || event.metaKey || event.altKey) return;
      if (nudge) {
        const { x, y } = spotting.onScreen(pin.place);
        const place = under(x + nudge[0], y + nudge[1]);
        if (place) {
          on.move(id, place);
          on.drop(id);
        }
      } else if (event.key === 'Delete' || event.key === 'Backspace') on.remove(id);
      else if (event.key === '+' || event.key === '=' || event.key === '-') on.grow(id, event.key === '-' ? -1 : 1);
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
    handle.addEventListener('pointerdown', (event) => {
      const pin = find(id);
      if (event.button !== 0 || held || !pin) return;
      event.preventDefault();
      event.stopPropagation();
      const { x, y } = spotting.onScreen(pin.place);
      const box = canvas.getBoundingClientRect();
      held = { id, pointer: event.pointerId, grip: [x - (event.clientX - box.left), y - (event.clientY - box.top)], isMoved: false };
      handle.focus({ preventScroll: true });
      handle.setPointerCapture(event.pointerId);
    });
    handle.addEventListener('pointermove', (event) => {
      if (held?.id !== id || held.pointer !== event.pointerId) return;
      const box = canvas.getBoundingClientRect();
      const place = under(event.clientX - box.left + held.grip[0], event.clientY - box.top + held.grip[1]);
      // Beside the head it stays where it was last.
      if (!place) return;
      held.isMoved = true;
      on.move(id, place);
    });
    handle.addEventListener('pointerup', (event) => held?.pointer === event.pointerId && letGo());
    handle.addEventListener('pointercancel', (event) => held?.pointer === event.pointerId && giveUp());
    return handle;
  }
  function letGo() {
    const before = held;
    held = null;
    if (before?.isMoved) on.drop(before.id);
  }
  function giveUp() {
    const before = held;
    held = null;
    if (before) handles.get(before.id)?.releasePointerCapture(before.pointer);
    if (before?.isMoved) on.cancel();
  }

  const cursor = slider('pin-aim');
  cursor.hidden = true;
  cursor.addEventListener('keydown', (event) => {
    if (!aim) return;
    const nudge = nudgeOf(event, NUDGE);
    if (nudge) {
      aim = [Math.min(canvas.clientWidth, Math.max(0, aim[0] + nudge[0])), Math.min(canvas.clientHeight, Math.max(0, aim[1] + nudge[1]))];
      draw();
      tell(cursor, under(...aim));
    } else if (event.key === 'Enter' || event.key === ' ') on.put(under(...aim));
    else if (event.key === 'Escape') on.leave();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  // What a mouse points at; keys go on from there.
  canvas.addEventListener('pointermove', (event) => {
    if (!aim || event.pointerType === 'touch' || event.buttons) return;
    const box = canvas.getBoundingClientRect();
    aim = [event.clientX - box.left, event.clientY - box.top];
    draw();
  });
  const root = element('div', { class: 'pins', role: 'group', 'aria-label': text.marks.onFace, hidden: true }, cursor);

  function draw() {
    if (root.hidden) return;
    for (const { id, place, across } of pins) {
      const handle = handles.get(id);
      if (!handle) continue;
      const { x, y, isSeen } = spotting.onScreen(place);
      handle.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      handle.style.setProperty('--across', `${(across * spotting.scale(place)).toFixed(1)}px`);
      handle.classList.toggle('is-away', !isSeen);
    }
    if (aim) cursor.style.transform = `translate(${aim[0].toFixed(1)}px, ${aim[1].toFixed(1)}px)`;
  }

  return {
    root,
    draw,
    /** @param {readonly Pin[]} now none where none are to be seen */
    show(now) {
      pins = now;
      for (const [id, handle] of handles) {
        if (find(id)) continue;
        handle.remove();
        handles.delete(id);
      }
      for (const { id, label, place, isChosen, still } of pins) {
        const handle = handles.get(id) ?? (still ? element('div', { class: 'pin', 'aria-hidden': 'true' }) : handleOf(id));
        if (!handles.has(id)) {
          handles.set(id, handle);
          cursor.before(handle);
        }
        handle.classList.toggle('is-chosen', isChosen);
        if (still) continue;
        handle.setAttribute('aria-label', label);
        tell(handle, place);
      }
      root.hidden = pins.length === 0 && !aim;
      draw();
    },
    /** @param {string} id */
    focus: (id) => handles.get(id)?.focus({ preventScroll: true }),
    /** A pin is to be put somewhere, which is reached by keys from where it was last, or from the middle of what is seen. @param {string} label */
    aim(label) {
      aim ??= [canvas.clientWidth / 2, canvas.clientHeight / 2];
      root.hidden = false;
      root.classList.add('is-aiming');
      cursor.hidden = false;
      cursor.setAttribute('aria-label', label);
      tell(cursor, under(...aim));
      draw();
      cursor.focus({ preventScroll: true });
    },
    /** It is no longer. @returns {boolean} whether it had the focus */
    rest() {
      const had = document.activeElement === cursor;
      aim = null;
      cursor.hidden = true;
      root.classList.remove('is-aiming');
      root.hidden = pins.length === 0;
      return had;
    },
  };
}
