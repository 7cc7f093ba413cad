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

/** Who has a number only because others have the name. @param {string} name */
const unnumbered = (name) => name.replace(/ \(\d+\)$/, '');

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
  /** Whether the browser was asked to keep them when it is short of room: before it throws away the rest, it asks nobody. */
  let isAsked = false;
  const newId = () => `own-${Date.now().toString(36)}-${Math.random().toString(36).slice(2, 7)}`;
  /** @param {Likeness} face */
  const looksLike = ({ code, expression, colouring }) => (/** @type {Likeness} */ other) =>
    other.code === code && sameWeights(other.expression ?? {}, expression ?? {}) && sameWeights(other.colouring ?? {}, colouring ?? {});
  /**
   * That name, or with a number behind it what nobody of these is called.
   * @param {string} name @param {readonly { name: string }[]} faces
   */
  function nameAmong(name, faces) {
    const taken = new Set(faces.map((face) => face.name));
    let free = name;
    for (let n = 2; taken.has(free); n++) free = text.namesake(unnumbered(name), n);
    return free;
  }
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
    /** Those that are kept and cannot be read. */
    get unread() {
      return unread;
    },
    get all() {
      return [...own, ...presets];
    },
    presets,
    /** A name that none of them has. */
    get freeName() {
      let n = own.length + 1;
      while (own.some(({ name }) => name === text.ownFace(n))) n += 1;
      return text.ownFace(n);
    },
    /** A name that no other has: this one, or with a number. @param {string} name @param {string} [id] who is to have it */
    freeNameLike: (name, id) => nameAmong(name, own.filter((entry) => entry.id !== id)),
    /** What a face was saved as, with these looks if it was with several; '' when it was not, or has changed since. @param {Likeness} face */
    nameOf: (face) => (own.find(looksLike({ ...face, expression: readExpression(face.expression) })) ?? own.find(({ code }) => code === face.code))?.name ?? '',
    /** @param {string} id */
    find: (id) => [...own, ...presets].find((entry) => entry.id === id),
    /**
     * @param {...({ name: string } & Likeness)} faces the first of them is first among all; whose name another has gets a number
     * @returns {boolean} whether the browser keeps them
     */
    add(...faces) {
      if (!isAsked) void navigator.storage?.persist?.().catch(() => {});
      isAsked = true;
      /** @type {Entry[]} */
      const added = [];
      for (const { name, code, expression, colouring } of faces) {
        added.push({ id: newId(), name: nameAmong(name, [...own, ...added]), code, expression: readExpression(expression), colouring, own: true });
      }
      return write([...added, ...own]);
    },
    /** Whether there is one like it under that name, with whatever number. @param {{ name: string } & Likeness} face */
    has: (face) => own.filter(({ name }) => unnumbered(name) === unnumbered(face.name)).some(looksLike(face)),
    /**
     * Adds a face that is not there yet; one of another model is kept unread.
     * @param {string} name @param {Likeness} face
     * @returns {'known' | 'added' | 'unread' | 'refused'} refused by the browser
     */
    adopt(name, { code, expression, colouring }) {
      const isRead = isFace(code);
      const there = isRead ? [...own, ...presets] : unread.map((other) => /** @type {Likeness} */ (Object(other)));
      if (there.some(looksLike({ code, expression, colouring }))) return 'known';
      const entry = { id: newId(), name: nameAmong(name, own), code, expression, colouring };
      if (!isRead) unread = [entry, ...unread];
      if (!write(isRead ? [{ ...entry, own: true }, ...own] : own)) return 'refused';
      return isRead ? 'added' : 'unread';
    },
    isFace,
    /** One that was removed, where it was: new ones come before all. @param {Entry} entry @param {number} after how many stood after it */
    putBack(entry, after) {
      const at = Math.max(0, own.length - after);
      return write([...own.slice(0, at), entry, ...own.slice(at)]);
    },
    /** @param {string} id @param {string} name */
    rename: (id, name) => write(own.map((entry) => (entry.id === id ? { ...entry, name } : entry))),
    /** @param {string} id */
    remove: (id) => write(own.filter((entry) => entry.id !== id)),
  };
}

/** @typedef {ReturnType<typeof createLibrary>} Library */
