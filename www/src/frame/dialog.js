import { element } from './element.js';
import { icon } from './icons.js';
import { text } from '../text.js';

/**
 * A page over the page: it has a title, and is closed by its button, by Escape, and by a click beside it.
 * @param {string} id of its title @param {string} title
 * @param {...(Node | string)} children
 */
export function createDialog(id, title, ...children) {
  // A press that begins in a field and ends beside the page marks what is written there.
  let isBeside = false;
  const dialog = element(
    'dialog',
    {
      class: 'about-page',
      'aria-labelledby': id,
      onpointerdown: (/** @type {PointerEvent} */ event) => (isBeside = event.target === dialog),
      onclick: (/** @type {MouseEvent} */ event) => isBeside && event.target === dialog && dialog.close(),
    },
    element(
      'div',
      { class: 'about-text' },
      element(
        'header',
        {},
        element('h2', { id }, title),
        element('button', { type: 'button', class: 'tool', 'aria-label': text.close, onclick: () => dialog.close() }, icon('close')),
      ),
      ...children,
    ),
  );
  return dialog;
}
