// Undo and redo. A face is its coefficients and the blending distance, so a step is two such
// states; one step a gesture, however many events it had.

/** @typedef {{ coefficients: Float32Array, alpha: number }} State */
/** @typedef {{ before: State, after: State, what: string, at: number }} Step */

const LIMIT = 300;
/** Presses of an arrow key closer than this (ms) are one gesture. */
const TOGETHER = 700;

/** @param {import('phiz').Face} face @returns {State} */
export function stateOf(face) {
  return { coefficients: face.coefficients.slice(), alpha: face.alpha };
}

/** @param {State} a @param {State} b */
function same(a, b) {
  return a.alpha === b.alpha && a.coefficients.every((value, i) => value === b.coefficients[i]);
}

/** @param {import('phiz').Face} face */
export function createHistory(face) {
  /** @type {Step[]} */
  const done = [];
  /** @type {Step[]} */
  const undone = [];
  /** @type {State | null} */
  let before = null;

  /** @param {State} state */
  function restore(state) {
    if (face.alpha !== state.alpha) face.alpha = state.alpha;
    face.coefficients = state.coefficients;
  }

  return {
    get canUndo() {
      return done.length > 0;
    },
    get canRedo() {
      return undone.length > 0;
    },
    /** A gesture starts; later calls within the same gesture do nothing. */
    begin() {
      before ??= stateOf(face);
    },
    /**
     * The gesture is over.
     * @param {string} what steps of the same name that follow each other quickly become one
     */
    commit(what) {
      if (!before) return;
      const step = { before, after: stateOf(face), what, at: performance.now() };
      before = null;
      if (same(step.before, step.after)) return;
      undone.length = 0;
      const last = done.at(-1);
      if (last && last.what === what && step.at - last.at < TOGETHER) {
        last.after = step.after;
        last.at = step.at;
        return;
      }
      done.push(step);
      if (done.length > LIMIT) done.shift();
    },
    /** @returns {boolean} whether there was something to undo */
    undo() {
      const step = done.pop();
      if (!step) return false;
      undone.push(step);
      restore(step.before);
      return true;
    },
    /** @returns {boolean} whether there was something to redo */
    redo() {
      const step = undone.pop();
      if (!step) return false;
      done.push(step);
      restore(step.after);
      return true;
    },
  };
}
