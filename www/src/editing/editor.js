import { readColouring } from '../head/colouring.js';
import { text } from '../text.js';
import { createHistory, restore, sameWeights, stateOf } from './history.js';

/**
 * Expressions are shown in whole per cents, which is what an address keeps of them.
 * @param {Record<string, number>} weights
 */
function wholePercents(weights) {
  return Object.fromEntries(Object.entries(weights).map(([name, weight]) => [name, Math.round(100 * Math.min(1, Math.max(0, weight))) / 100]));
}

/**
 * What can be done to the face. Whatever the way in (slider, key, button, link), a change ends
 * here: history is kept, and everybody who shows the face is told.
 *
 * @param {import('phiz').FaceModel} model
 * @param {import('phiz').Face} face
 * @param {import('../head/colouring.js').Colouring} colouring that it has
 */
export function createEditor(model, face, colouring) {
  /** @type {import('./history.js').Subject} */
  const subject = { face, colouring, photo: 0, awaited: null };
  const history = createHistory(subject);
  /** @type {Set<(range: readonly [number, number] | undefined) => void>} */
  const shapeListeners = new Set();
  /** @type {Set<(what: string) => void>} */
  const stepListeners = new Set();
  /** @type {Set<(why: string) => void>} */
  const refusalListeners = new Set();
  /** @type {Set<() => void>} */
  const colourListeners = new Set();
  let painted = subject.colouring;
  /** How often another face was asked for. */
  let asked = 0;

  function coloursChanged() {
    // A slider of the person makes a colouring with every event, and most are alike.
    if (sameWeights(painted, subject.colouring)) return;
    painted = subject.colouring;
    for (const listener of colourListeners) listener();
  }
  /** @param {readonly [number, number]} [range] */
  function shapeChanged(range) {
    coloursChanged();
    for (const listener of shapeListeners) listener(range);
  }
  /** @param {string} what */
  function finish(what) {
    history.commit(what);
    for (const listener of stepListeners) listener(what);
  }

  /**
   * One whole step, which is never one with the step before.
   * @template T
   * @param {string} what
   * @param {() => T} change
   */
  function step(what, change) {
    history.part();
    history.begin();
    try {
      return change();
    } finally {
      shapeChanged();
      finish(what);
    }
  }
  /**
   * A change that what is locked may make impossible: then the face stays, and everybody who asked
   * is told why.
   * @template T
   * @param {() => T} change
   * @returns {T | undefined}
   */
  function attempt(change) {
    try {
      return change();
    } catch (error) {
      const why = error instanceof Error ? error.message : String(error);
      for (const listener of refusalListeners) listener(why);
      return undefined;
    }
  }
  /** What is locked stays as it looks. @param {import('../head/colouring.js').Colouring} colours */
  function dress(colours) {
    if (face.locked.length === 0) subject.colouring = colours;
  }
  /** @param {Record<string, number>} weights */
  function express(weights) {
    face.expression = weights;
    subject.awaited = null;
  }
  /** All of it is somebody else's now, unless something is locked. */
  function leavePhoto() {
    if (face.locked.length === 0) subject.photo = 0;
  }

  return {
    model,
    face,
    /** @param {(range: readonly [number, number] | undefined) => void} listener */
    onShape: (listener) => void shapeListeners.add(listener),
    /** @param {() => void} listener called before those of the shape */
    onColours: (listener) => void colourListeners.add(listener),
    /** @param {(what: string) => void} listener told what the step was; '' of one back or forth, or of none */
    onStep: (listener) => void stepListeners.add(listener),
    /** @param {(why: string) => void} listener */
    onRefusal: (listener) => void refusalListeners.add(listener),
    /** How the face is coloured. */
    get colouring() {
      return subject.colouring;
    },
    /** The number of the photo that it is the face of, whatever was changed of it since; 0 of none. */
    get photo() {
      return subject.photo;
    },
    /** What is kept of a face. @returns {import('../keep/library.js').Likeness} */
    get likeness() {
      return { code: face.code, expression: face.expression, colouring: subject.colouring };
    },
    /** The code of an expression that is still to come; '' of none. */
    get awaited() {
      return subject.awaited?.code ?? '';
    },
    /**
     * The face has an expression that is still to come, whatever is done to it meanwhile, unless it gets another one. That is no
     * step: there is nothing before it to go back to.
     * @param {string} code
     * @returns {(weights: Record<string, number>) => void} for when it has come
     */
    awaitExpression(code) {
      /** @type {import('./history.js').Awaited} */
      const awaited = { code, weights: null };
      subject.awaited = awaited;
      return (weights) => {
        const before = face.expression;
        face.expression = weights;
        // With the digits that a face keeps.
        awaited.weights = face.expression;
        if (subject.awaited === awaited) subject.awaited = null;
        else face.expression = before;
        shapeChanged();
        // What was done meanwhile is kept with it.
        if (history.canUndo || history.canRedo) for (const listener of stepListeners) listener('');
      };
    },
    /**
     * Asks for another face that does not come at once.
     * @returns {() => boolean} whether no other was asked for since: the newest is the one that is wanted, whichever comes last
     */
    ask() {
      const own = (asked += 1);
      return () => own === asked;
    },
    get state() {
      return stateOf(subject);
    },
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
      attempt(() => face.set(control, value));
      shapeChanged(face.changed);
    },
    /**
     * Part of a gesture that the controls have no words for.
     * @param {(face: import('phiz').Face) => void} change
     * @param {import('../head/colouring.js').Colouring} [colours] that it then has, unless something is locked
     */
    moveBy(change, colours = subject.colouring) {
      history.begin();
      attempt(() => {
        change(face);
        dress(colours);
      });
      shapeChanged();
    },
    /**
     * Part of a gesture. It moves all borders of features, so nothing can be locked.
     * @param {number} mm
     */
    moveAlpha(mm) {
      history.begin();
      attempt(() => {
        if (face.locked.length + face.lockedMeasures.length > 0) throw new Error(text.alphaLocked);
        face.alpha = mm;
      });
      shapeChanged();
    },
    /**
     * Part of a gesture that counts from a state: an amount that goes up and down again ends
     * where it began.
     * @param {import('./history.js').State} state
     * @param {(face: import('phiz').Face) => void} change
     * @param {import('../head/colouring.js').Colouring} [colours] that it then has, unless something is locked
     */
    moveFrom(state, change, colours = state.colouring) {
      history.begin();
      restore(subject, state);
      attempt(() => {
        change(face);
        dress(colours);
      });
      shapeChanged();
    },
    finish,
    /** A gesture ends without a step: the face is the one of before. */
    cancel() {
      if (!history.cancel()) return;
      shapeChanged();
      finish('');
    },
    part: history.part,
    /** @param {string} control @param {number} value */
    set(control, value) {
      step(`set ${control}`, () => attempt(() => face.set(control, value)));
    },
    /** @param {string} measure @param {number} mm */
    setMeasure(measure, mm) {
      step(`set ${measure}`, () => attempt(() => face.setMeasure(measure, mm)));
    },
    /** @param {string} control of the meanings: what it changed is undone, the rest stays */
    clear(control) {
      step(`clear ${control}`, () => attempt(() => face.clear(control)));
    },
    /** @param {string} [region] all of the face, with its expression and, unless something is locked, its colours, when absent */
    reset(region) {
      if (region === undefined) asked += 1;
      step('reset', () =>
        attempt(() => {
          face.reset(region);
          if (region !== undefined) return;
          express({});
          dress({});
          leavePhoto();
        }),
      );
    },
    /**
     * Part of a gesture: some expressions change, the others stay.
     * @param {Record<string, number>} weights 0 to 1
     */
    moveExpression(weights) {
      history.begin();
      express(wholePercents({ ...face.expression, ...weights }));
      shapeChanged(face.changed);
    },
    /** One step: these expressions and no others. @param {Record<string, number>} weights 0 to 1 */
    express(weights) {
      step('express', () => express(wholePercents(weights)));
    },
    /** Part of a gesture: some colours change, the others stay. @param {import('../head/colouring.js').Colouring} colours */
    moveColours(colours) {
      history.begin();
      subject.colouring = readColouring({ ...subject.colouring, ...colours });
      coloursChanged();
    },
    /** One step: this colouring and no other. @param {import('../head/colouring.js').Colouring} colours */
    paint(colours) {
      history.part();
      history.begin();
      subject.colouring = readColouring(colours);
      coloursChanged();
      finish('paint');
    },
    /**
     * @param {Chance} options
     * @param {(seed: number) => import('../head/colouring.js').Colouring} [colours] that it then has, unless something is locked
     * @returns {number | undefined} the seed, unless the change was refused
     */
    randomise(options, colours) {
      if (!options.regions) asked += 1;
      return step('random', () =>
        attempt(() => {
          const seed = face.randomize(options);
          if (!options.regions) leavePhoto();
          if (colours) dress(colours(seed));
          return seed;
        }),
      );
    },
    /**
     * @param {import('phiz').Face} other
     * @param {{ regions?: string[], colours?: import('../head/colouring.js').Colouring }} options all regions when absent;
     *   the colours that it then has unless something is locked, its own when absent
     * @returns {boolean} whether it did; who asked is told why not
     */
    become(other, { regions, colours }) {
      if (!regions) asked += 1;
      const became = step('blend', () =>
        attempt(() => {
          face.blend(other, 1, regions && { regions });
          if (!regions) leavePhoto();
          if (colours) dress(colours);
          return true;
        }),
      );
      return became === true;
    },
    /**
     * Becomes another face; what is locked stays locked, and changes all the same: it was asked for
     * by name. What the likeness does not say stays as it is.
     * @param {import('../keep/library.js').Likeness} likeness @param {number} [photo] that it is the face of
     */
    take({ code, expression, colouring }, photo = 0) {
      asked += 1;
      step('take', () => {
        // First what may be no face of this model.
        face.code = code;
        subject.photo = photo;
        if (expression) express(expression);
        if (colouring) subject.colouring = colouring;
      });
    },
    undo() {
      asked += 1;
      // What is under way is the step that is meant.
      history.commit('');
      const did = history.undo();
      if (did) {
        shapeChanged();
        finish('');
      }
      return did;
    },
    redo() {
      asked += 1;
      history.commit('');
      const did = history.redo();
      if (did) {
        shapeChanged();
        finish('');
      }
      return did;
    },
    /** @param {string} region */
    toggleLock(region) {
      step('lock', () => {
        if (face.locked.includes(region)) face.unlock(region);
        else face.lock(region);
      });
    },
    /** @param {string} measure */
    toggleMeasureLock(measure) {
      step('lock', () => {
        if (face.lockedMeasures.includes(measure)) face.unlockMeasure(measure);
        else face.lockMeasure(measure);
      });
    },
  };
}

/** @typedef {ReturnType<typeof createEditor>} Editor */
/** @typedef {NonNullable<Parameters<import('phiz').Face['randomize']>[0]>} Chance */
