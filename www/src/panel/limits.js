import { BEYOND, PEOPLE } from './distribution.js';
import { element } from '../frame/element.js';
import { text } from '../text.js';

/**
 * Whether sliders end where people do. One answer for all of them; a box to tick wherever it is
 * wanted.
 */
export function createLimits() {
  let beyond = false;
  /** @type {Set<() => void>} */
  const listeners = new Set();
  /** @type {HTMLInputElement[]} */
  const boxes = [];

  return {
    get beyond() {
      return beyond;
    },
    /** How far a slider goes, as values. */
    get present() {
      return beyond ? BEYOND : PEOPLE;
    },
    /** @param {() => void} listener */
    onChange: (listener) => void listeners.add(listener),
    box() {
      const box = element('input', {
        type: 'checkbox',
        onchange: () => {
          beyond = box.checked;
          for (const other of boxes) other.checked = beyond;
          for (const listener of listeners) listener();
        },
      });
      boxes.push(box);
      return element('label', { class: 'check', title: text.beyondAbout }, box, text.beyond);
    },
  };
}

/** @typedef {ReturnType<typeof createLimits>} Limits */
