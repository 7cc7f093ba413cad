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
  /** @param {boolean} now */
  function set(now) {
    beyond = now;
    for (const box of boxes) box.checked = beyond;
    for (const listener of listeners) listener();
  }

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
    /**
     * That a slider ends, and how it goes on.
     * @param {string} end in words @param {string} id of the slider, which is made anew then
     */
    ended(end, id) {
      const said = document.createDocumentFragment();
      said.append(text.ended(end));
      if (beyond) return said;
      const go = () => {
        set(true);
        document.getElementById(id)?.focus();
      };
      said.append(' ', element('button', { type: 'button', class: 'link', title: text.beyondAbout, onclick: go }, text.beyond));
      return said;
    },
    box() {
      const box = element('input', {
        type: 'checkbox',
        onchange: () => set(box.checked),
      });
      boxes.push(box);
      return element('label', { class: 'check', title: text.beyondAbout }, box, text.beyond);
    },
  };
}

/** @typedef {ReturnType<typeof createLimits>} Limits */
