// Undo and redo. What can be undone is the whole of a face: its code, what is locked, the expression on it
// and its colours. A step is two such states; one step a gesture, however many events it had. There
// is no limit: a step is half a kilobyte.

/** @typedef {import('../head/colouring.js').Colouring} Colouring */
/**
 * The expression of a link, whose file comes after its face: until then nobody knows more of it than its code. All states
 * that have it share it, and so it comes for all of them.
 * @typedef {{ code: string, weights: Record<string, number> | null }} Awaited
 */
/**
 * A face and how it is coloured, of which its module knows nothing, and the number of the photo that it is the face of; 0 of none.
 * @typedef {{ face: import('phiz').Face, colouring: Colouring, photo: number, awaited: Awaited | null }} Subject
 */
/**
 * @typedef {{
 *   code: string, locked: string[], held: string[], expression: Record<string, number>, awaited: Awaited | null, colouring: Colouring, photo: number,
 * }} State
 */
/** @typedef {{ before: State, after: State, what: string, at: number }} Step */

/** Presses of an arrow key closer than this (ms) are one gesture, unlike drags. */
export const TOGETHER = 700;

/** @param {Subject} subject @returns {State} */
export function stateOf({ face, colouring, photo, awaited }) {
  return {
    code: face.code,
    locked: [...face.locked],
    held: [...(face.lockedMeasures ?? [])],
    expression: face.expression,
    awaited,
    colouring,
    photo,
  };
}

/** @param {readonly string[]} a @param {readonly string[]} b */
function sameNames(a, b) {
  return a.length === b.length && a.every((name) => b.includes(name));
}

/** Of expressions or colourings. @param {Readonly<Record<string, unknown>>} a @param {Readonly<Record<string, unknown>>} b */
export function sameWeights(a, b) {
  return sameNames(Object.keys(a), Object.keys(b)) && Object.entries(a).every(([name, weight]) => b[name] === weight);
}

/** @param {State} state */
const expressionOf = ({ expression, awaited }) => awaited?.weights ?? expression;
/** @param {State} state */
const stillAwaited = ({ awaited }) => (awaited?.weights ? null : awaited);

/** @param {State} a @param {State} b */
export function sameState(a, b) {
  return (
    a.code === b.code &&
    sameNames(a.locked, b.locked) &&
    sameNames(a.held, b.held) &&
    sameWeights(expressionOf(a), expressionOf(b)) &&
    stillAwaited(a) === stillAwaited(b) &&
    sameWeights(a.colouring, b.colouring) &&
    a.photo === b.photo
  );
}

/** @param {Subject} subject @param {State} state */
export function restore(subject, state) {
  const { face } = subject;
  subject.colouring = state.colouring;
  subject.photo = state.photo;
  subject.awaited = stillAwaited(state);
  const expression = expressionOf(state);
  if (!sameWeights(face.expression, expression)) face.expression = expression;
  for (const region of face.locked) if (!state.locked.includes(region)) face.unlock(region);
  for (const region of state.locked) face.lock(region);
  for (const name of face.lockedMeasures ?? []) if (!state.held.includes(name)) face.unlockMeasure(name);
  // Measures are held at the lengths that the face then has.
  face.code = state.code;
  for (const name of state.held) face.lockMeasure(name);
}

/** @param {Subject} subject */
export function createHistory(subject) {
  /** @type {Step[]} */
  const done = [];
  /** @type {Step[]} */
  const undone = [];
  /** @type {State | null} */
  let before = null;

  return {
    get canUndo() {
      return done.length > 0;
    },
    get canRedo() {
      return undone.length > 0;
    },
    /** A gesture starts; later calls within the same gesture do nothing. */
    begin() {
      before ??= stateOf(subject);
    },
    /** What comes next is a step of its own, however soon. */
    part() {
      const last = done.at(-1);
      if (last) last.at = -Infinity;
    },
    /**
     * The gesture is over.
     * @param {string} what steps of the same name that follow each other quickly become one
     */
    commit(what) {
      if (!before) return;
      const step = { before, after: stateOf(subject), what, at: performance.now() };
      before = null;
      if (sameState(step.before, step.after)) return;
      undone.length = 0;
      const last = done.at(-1);
      if (last && last.what === what && step.at - last.at < TOGETHER) {
        last.after = step.after;
        last.at = step.at;
        // There and back again is nothing to undo.
        if (sameState(last.before, last.after)) done.pop();
        return;
      }
      done.push(step);
    },
    /** The gesture is given up: what it was made from is back. @returns {boolean} whether there was one */
    cancel() {
      if (!before) return false;
      restore(subject, before);
      before = null;
      return true;
    },
    /** @returns {boolean} whether there was something to undo */
    undo() {
      const step = done.pop();
      if (!step) return false;
      undone.push(step);
      restore(subject, step.before);
      return true;
    },
    /** @returns {boolean} whether there was something to redo */
    redo() {
      const step = undone.pop();
      if (!step) return false;
      done.push(step);
      restore(subject, step.after);
      return true;
    },
  };
}
