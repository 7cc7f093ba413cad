import { GLASSES, valueIn } from '../head/colouring.js';
import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { letterOf } from '../frame/keys.js';
import { text } from '../text.js';

const BARE = { crop: 0, length: 0, beard: 0, beardLength: 0, glasses: 0 };
/** What else tells how hair grows, and what glasses are of. */
const TELLS = ['thin', 'hairline', 'beardThin', 'moustache', 'chinBeard', 'cheekBeard', ...GLASSES];
/** @param {import('../head/colouring.js').Colouring} colouring @param {readonly string[]} names */
const valuesOf = (colouring, names) => names.map((name) => valueIn(colouring, name));

/**
 * Hides hair, beard and glasses, to see the head below while it is shaped: a button, and a key on the stage. (Anywhere else,
 * a key alone would be in the way of who speaks to the page.) The face keeps
 * them, and who changes them sees them again.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {HTMLElement} stage
 * @param {() => void} repaint
 */
export function createBare(editor, stage, repaint) {
  let bare = false;
  let before = '';
  const button = element('button', { type: 'button', class: 'tool', 'aria-label': text.hideHair, title: text.hideHairAbout, onclick: toggle }, icon('hair'));

  /** @param {boolean} now */
  function show(now) {
    bare = now;
    button.setAttribute('aria-pressed', String(bare));
  }
  function refresh() {
    const hidden = valuesOf(editor.colouring, Object.keys(BARE));
    const now = [...hidden, ...valuesOf(editor.colouring, TELLS)].join();
    if (now === before) return;
    before = now;
    button.hidden = hidden.every((value) => value === 0);
    show(false);
  }
  function toggle() {
    if (button.hidden) return;
    show(!bare);
    repaint();
  }
  stage.addEventListener('keydown', (event) => {
    if (letterOf(event) !== 'h' || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    toggle();
  });
  editor.onColours(refresh);
  refresh();
  return {
    button,
    /** How colours are painted, the face's own unless others are given. */
    colouring: (of = editor.colouring) => (bare ? { ...of, ...BARE } : of),
  };
}
