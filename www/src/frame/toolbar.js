import { element } from './element.js';
import { icon } from './icons.js';
import { stepOf } from './keys.js';
import { text } from '../text.js';

/** Inputs into which nobody writes. */
const UNWRITTEN = ['range', 'checkbox', 'radio'];

/**
 * @param {Parameters<typeof icon>[0]} name
 * @param {string} label
 * @param {() => void} onclick
 */
function tool(name, label, onclick) {
  return element('button', { type: 'button', class: 'tool', 'aria-label': label, title: label, onclick }, icon(name));
}

/**
 * The buttons of the bar over the page, and its keys: undo and redo.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {HTMLElement} tools where its buttons go
 * @param {{ reset: () => void, randomise: () => void, copyLink: () => void, take: () => void, theme: () => void, help: () => void }} on
 *   `take`: the face leaves the page, as a file or a picture.
 */
export function createToolbar(editor, tools, { reset, randomise, copyLink, take, theme, help }) {
  const undo = tool('undo', text.undo, () => editor.undo());
  const redo = tool('redo', text.redo, () => editor.redo());
  function refresh() {
    undo.disabled = !editor.canUndo;
    redo.disabled = !editor.canRedo;
  }
  editor.onStep(refresh);
  refresh();

  window.addEventListener('keydown', (event) => {
    const step = stepOf(event);
    if (!step || event.defaultPrevented) return;
    // Text fields have an undo of their own.
    if (event.target instanceof HTMLInputElement && !UNWRITTEN.includes(event.target.type)) return;
    // Who is in a dialog is not at the face behind it.
    if (document.querySelector('dialog[open]')) return;
    event.preventDefault();
    editor[step]();
  });

  tools.append(
    undo,
    redo,
    tool('reset', text.resetAll, reset),
    element(
      'button',
      { type: 'button', class: 'button', 'aria-label': text.randomise, title: text.randomise, onclick: randomise },
      icon('dice'),
      element('span', {}, text.randomise),
    ),
    element(
      'button',
      { type: 'button', class: 'button primary', 'aria-label': text.copyLink, title: text.copyLink, onclick: copyLink },
      icon('link'),
      element('span', {}, text.copyLink),
    ),
    tool('save', text.exportTitle, take),
    tool('theme', text.theme, theme),
    tool('help', text.about, help),
  );
}
