import { element } from '../frame/element.js';
import { text } from '../text.js';
import { ETHNICITY } from './wishes.js';

// Faces around the present one, side by side, to choose from: what it is with a part of a random person on top.

const FACES = 6;
/** How much of somebody else: it moves the skin by some 2 mm. */
const PART = 0.4;
/** Where people end, standard deviations. */
const END = 3;

/**
 * Codes of faces that are like one, as old and as much of a man's; what is locked stays.
 * @param {import('phiz').Face} face @param {number} spread of what is added
 */
function around(face, spread) {
  const { model } = face;
  const own = face.coefficients;
  const within = model.attributes.filter(({ name, limits: [least, most] }) => {
    const read = face.attribute(name);
    return !ETHNICITY.includes(name) && read >= least && read <= most;
  });
  const reads = Object.fromEntries(within.map(({ name }) => [name, face.attribute(name)]));
  const other = model.face();
  // What is locked would be moved by coefficients, and is not by another face.
  const free = face.clone();
  for (const region of free.locked) free.unlock(region);
  for (const measure of free.lockedMeasures) free.unlockMeasure(measure);
  const near = face.clone();
  try {
    return Array.from({ length: FACES }, () => {
      other.randomize({ spread });
      const { coefficients } = other;
      free.coefficients = own.map((value, i) => {
        // A face that is beyond people may stay as far.
        const end = Math.max(END, Math.abs(value));
        return Math.min(end, Math.max(-end, value + PART * coefficients[i]));
      });
      near.code = face.code;
      near.blend(free, 1);
      if (within.length > 0) near.setAttributes(reads);
      return near.code;
    });
  } finally {
    for (const made of [other, free, near]) made.free();
  }
}

/**
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   library: import('../keep/library.js').Library,
 *   portraits: import('../stage/portraits.js').Portraits,
 *   say: (sentence: string) => void,
 *   spread: () => number,
 * }} parts
 */
export function createAlike(editor, { library, portraits, say, spread }) {
  /** @type {import('../keep/library.js').Likeness[]} */
  let faces = [];
  let of = '';
  const row = element('div', { class: 'alike' });
  const keep = element('button', { type: 'button', class: 'link', onclick: keepAll }, text.alike.keep(FACES));
  const root = element('div', { role: 'group', 'aria-label': text.alike.group, hidden: true }, row, element('p', { class: 'note' }, text.alike.about, ' ', keep));

  function draw() {
    const { expression, colouring } = editor.likeness;
    of = library.nameOf(editor.likeness);
    try {
      faces = around(editor.face, spread()).map((code) => ({ code, expression, colouring }));
    } catch (error) {
      // What is held may allow no other.
      return say(text.refused(error instanceof Error ? error.message : String(error)));
    }
    row.replaceChildren(
      ...faces.map((face, i) =>
        element(
          'button',
          {
            type: 'button',
            class: 'tray-face',
            'aria-label': text.alike.take(i + 1),
            title: text.alike.take(i + 1),
            'data-face': face.code,
            // It looks as it does now, and wears the photo if it does.
            onclick: () => editor.take({ code: face.code }, editor.photo),
          },
          portraits.of(face),
        ),
      ),
    );
    keep.disabled = false;
    root.hidden = false;
    // The button is at the end of what there was.
    root.scrollIntoView({ block: 'nearest' });
    mark();
    say(text.alike.drawn(FACES));
  }
  function mark() {
    for (const button of row.querySelectorAll('button')) button.setAttribute('aria-pressed', String(button.dataset.face === editor.face.code));
  }
  function keepAll() {
    // Another line-up goes on where the last one ended.
    const taken = new Set(library.own.map(({ name }) => name));
    let n = 0;
    const kept = library.add(
      ...faces.map((face) => {
        do n += 1;
        while (taken.has(text.alike.name(of, n)));
        return { ...face, name: text.alike.name(of, n) };
      }),
    );
    keep.disabled = kept;
    say(kept ? text.alike.kept(FACES) : text.notKept);
  }
  editor.onStep(() => root.hidden || mark());

  return { root, button: element('button', { type: 'button', class: 'button', title: text.alike.title, onclick: draw }, text.alike.draw) };
}
