import { readKept } from '../head/colouring.js';
import { sameWeights } from '../editing/history.js';
import { readExpression } from '../head/expression.js';
import { someone } from '../head/someone.js';
import { keep, recall } from '../store.js';
import { text } from '../text.js';

/** The seeds of the faces that everybody finds in the tray. */
const SEEDS = [3, 7, 12, 19, 24, 31, 42, 58, 63, 77, 85, 96];

/**
 * A face, with its expression and its colours unless it was saved before those were kept.
 * @typedef {{
 *   code: string,
 *   expression?: import('../head/expression.js').Shown,
 *   colouring?: import('../head/colouring.js').Colouring,
 * }} Likeness
 * @typedef {Likeness & { id: string, name: string, own: boolean }} Entry
 */

/**
 * The faces to choose from: a dozen sampled from the model, and the person's own, which the
 * browser keeps.
 *
 * @param {import('phiz').FaceModel} model
 * @param {string} modelName
 */
export function createLibrary(model, modelName) {
  const key = `phiz-faces-${modelName}`;
  const sampled = model.face();
  /** @type {Entry[]} */
  const presets = SEEDS.map((seed, i) => {
    sampled.reset();
    sampled.randomize({ seed });
    return { id: `preset-${i + 1}`, name: text.preset(i + 1), code: sampled.code, expression: {}, colouring: someone(sampled, seed), own: false };
  });
  sampled.free();

  /** @param {unknown} code */
  function isFace(code) {
    try {
      model.fromCode(String(code)).free();
      return true;
    } catch {
      return false;
    }
  }
  /** What is kept and cannot be read, such as faces of this model as it was before it was trained anew. @type {unknown[]} */
  let unread = [];
  /** @returns {Entry[]} what is kept and can be read */
  function read() {
    const recalled = recall(key);
    const kept = Array.isArray(recalled) ? recalled : [];
    const isRead = kept.map((entry) => entry && typeof entry.name === 'string' && isFace(entry.code));
    unread = kept.filter((_, i) => !isRead[i]);
    return kept
      .filter((_, i) => isRead[i])
      .map(({ id, name, code, expression, colouring }) => ({
        id: String(id),
        name,
        code,
        expression: readExpression(expression),
        colouring: readKept(colouring),
        own: true,
      }));
  }
  let own = read();
  /** @type {Set<() => void>} */
  const listeners = new Set();

  /** @param {Entry[]} entries @returns {boolean} whether the browser keeps them */
  function write(entries) {
    own = entries;
    // What cannot be read here is somebody's all the same: another version of the page may.
    const kept = keep(key, [...own.map(({ id, name, code, expression, colouring }) => ({ id, name, code, expression, colouring })), ...unread]);
    for (const listener of listeners) listener();
    return kept;
  }
  function readAgain() {
    own = read();
    for (const listener of listeners) listener();
  }
  // Another tab of the same page may save, too.
  window.addEventListener('storage', ({ key: of }) => of === key && readAgain());
  // And did, where nobody told a page that was put away.
  window.addEventListener('pageshow', ({ persisted }) => persisted && readAgain());

  return {
    /** @param {() => void} listener */
    onChange: (listener) => void listeners.add(listener),
    get own() {
      return own;
    },
    /** How many are kept that cannot be read. */
    get unread() {
      return unread.length;
    },
    get all() {
      return [...own, ...presets];
    },
    presets,
    /** What a face was saved as; '' when it was not, or has changed since. @param {string} code */
    nameOf: (code) => own.find((entry) => entry.code === code)?.name ?? '',
    /** @param {string} id */
    find: (id) => [...own, ...presets].find((entry) => entry.id === id),
    /**
     * @param {string} name @param {Likeness} face @param {string} [id] of one that was deleted
     * @returns {boolean} whether the browser keeps it
     */
    add: (name, { code, expression, colouring }, id = `own-${Date.now().toString(36)}-${Math.random().toString(36).slice(2, 7)}`) =>
      write([{ id, name, code, expression: readExpression(expression), colouring, own: true }, ...own]),
    /**
     * Adds a face that is not there yet, if it is one of this model.
     * @param {string} name @param {Likeness} face
     * @returns {boolean} whether it was added
     */
    adopt(name, { code, expression, colouring }) {
      const known = [...own, ...presets].some((entry) => entry.code === code && sameWeights(entry.colouring ?? {}, colouring ?? {}));
      if (known || !isFace(code)) return false;
      return write([{ id: `own-${Date.now().toString(36)}`, name, code, expression, colouring, own: true }, ...own]);
    },
    /** @param {string} id @param {string} name */
    rename: (id, name) => write(own.map((entry) => (entry.id === id ? { ...entry, name } : entry))),
    /** @param {string} id */
    remove: (id) => write(own.filter((entry) => entry.id !== id)),
  };
}

/** @typedef {ReturnType<typeof createLibrary>} Library */
