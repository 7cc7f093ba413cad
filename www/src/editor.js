import { createHistory } from './history.js';

/**
 * What can be done to the face. Whatever the way in (slider, key, button, link), a change ends
 * here: history is kept, and everybody who shows the face is told.
 *
 * @param {import('phiz').FaceModel} model
 * @param {import('phiz').Face} face
 */
export function createEditor(model, face) {
  const history = createHistory(face);
  /** @type {Set<(range: readonly [number, number] | undefined) => void>} */
  const shapeListeners = new Set();
  /** @type {Set<() => void>} */
  const stepListeners = new Set();

  /** @param {readonly [number, number]} [range] */
  function shapeChanged(range) {
    for (const listener of shapeListeners) listener(range);
  }
  function stepDone() {
    for (const listener of stepListeners) listener();
  }

  /**
   * One whole step.
   * @template T
   * @param {string} what
   * @param {() => T} change
   */
  function step(what, change) {
    history.begin();
    const result = change();
    shapeChanged();
    history.commit(what);
    stepDone();
    return result;
  }

  return {
    model,
    face,
    /** @param {(range: readonly [number, number] | undefined) => void} listener */
    onShape: (listener) => void shapeListeners.add(listener),
    /** @param {() => void} listener */
    onStep: (listener) => void stepListeners.add(listener),
    get canUndo() {
      return history.canUndo;
    },
    get canRedo() {
      return history.canRedo;
    },
    /**
     * Part of a gesture that `finish` ends.
     * @param {string} control @param {number} value
     */
    move(control, value) {
      history.begin();
      face.set(control, value);
      shapeChanged(face.changed);
    },
    /** @param {number} mm */
    moveAlpha(mm) {
      history.begin();
      face.alpha = mm;
      shapeChanged();
    },
    /** @param {string} what */
    finish(what) {
      history.commit(what);
      stepDone();
    },
    /** @param {string} control @param {number} value */
    set(control, value) {
      step(`set ${control}`, () => face.set(control, value));
    },
    /** @param {string} [region] */
    reset(region) {
      step('reset', () => face.reset(region));
    },
    /** @param {{ seed?: number, spread?: number, regions?: string[] }} options */
    randomise(options) {
      return step(`random ${Math.random()}`, () => face.randomize(options));
    },
    /** @param {string} code */
    take(code) {
      step('link', () => {
        face.code = code;
      });
    },
    undo() {
      const did = history.undo();
      if (did) {
        shapeChanged();
        stepDone();
      }
      return did;
    },
    redo() {
      const did = history.redo();
      if (did) {
        shapeChanged();
        stepDone();
      }
      return did;
    },
    /** @param {string} region */
    toggleLock(region) {
      if (face.locked.includes(region)) face.unlock(region);
      else face.lock(region);
      stepDone();
    },
  };
}

/** @typedef {ReturnType<typeof createEditor>} Editor */
