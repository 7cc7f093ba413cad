import { element } from '../frame/element.js';
import { text } from '../text.js';

/**
 * What the stage shows: the photo, or the head that it became.
 * @param {() => void} turn it is to show the other
 */
export function createSides(turn) {
  const side = (/** @type {string} */ value, /** @type {string} */ words, /** @type {boolean} */ checked) =>
    element('label', {}, element('input', { type: 'radio', name: 'photo-side', value, checked, onchange: turn }), element('span', {}, words));
  const sides = { photo: side('photo', text.photo.photoSide, true), head: side('head', text.photo.headSide, false) };
  const chosen = (/** @type {keyof typeof sides} */ name) => /** @type {HTMLInputElement} */ (sides[name].firstElementChild);

  return {
    root: element('div', { class: 'photo-sides', role: 'radiogroup', 'aria-label': text.photo.sides, hidden: true }, sides.photo, sides.head),
    get onPhoto() {
      return chosen('photo').checked;
    },
    /** @param {keyof typeof sides} name */
    turnTo(name) {
      chosen(name).checked = true;
      turn();
    },
  };
}
