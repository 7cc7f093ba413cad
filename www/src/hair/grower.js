import { plantOn } from './plant.js';

/** @typedef {import('./plant.js').Kind} Kind */
/** @typedef {NonNullable<ReturnType<ReturnType<typeof plantOn>>>} Grown */

/**
 * Has hair grown beside the page: nothing there waits for the hundreds of milliseconds of the first, or the tens of each style.
 * Where there can be no worker, the page does it.
 *
 * @param {import('./plant.js').Skin} skin
 * @param {import('./plant.js').Where} where
 */
export function createGrower(skin, where) {
  /** @type {ReturnType<typeof plantOn> | null} */
  let here = null;
  /** @template {Kind} K @param {K} kind @param {import('./plant.js').Styles[K]} style @returns {Grown | null} null where nothing grows */
  function now(kind, style) {
    here ??= plantOn(skin, where);
    return here(kind, style);
  }

  /** Null where there is none; made when it is first wanted. @type {Worker | null | undefined} */
  let worker;
  /** @type {Map<Kind, { style: any, done: (grown: Grown | null) => void }>} */
  const asked = new Map();
  /** What the worker has sent once. @type {Map<Kind, Grown['planting']>} */
  const plantings = new Map();

  /** @param {Kind} kind @param {Grown | null} grown */
  function settle(kind, grown) {
    const one = asked.get(kind);
    asked.delete(kind);
    one?.done(grown);
  }
  function begin() {
    try {
      worker = new Worker(new URL('./hair.worker.js', import.meta.url), { type: 'module' });
    } catch {
      worker = null;
      return;
    }
    worker.addEventListener('message', ({ data: { kind, planting, ribbons } }) => {
      if (planting) plantings.set(kind, planting);
      const known = plantings.get(kind);
      settle(kind, known && ribbons ? { planting: known, ribbons } : null);
    });
    worker.addEventListener('error', () => {
      worker?.terminate();
      worker = null;
      for (const [kind, { style }] of [...asked]) settle(kind, now(kind, style));
    });
    worker.postMessage({ skin, where });
  }

  return {
    now,
    dispose: () => worker?.terminate(),
    /**
     * One of a kind at a time.
     * @template {Kind} K
     * @param {K} kind
     * @param {import('./plant.js').Styles[K]} style
     * @param {(grown: Grown | null) => void} done called once: later, or at once where there is no worker
     */
    later(kind, style, done) {
      if (worker === undefined) begin();
      if (!worker) return done(now(kind, style));
      asked.set(kind, { style, done });
      worker.postMessage({ kind, style });
    },
  };
}

/** @typedef {ReturnType<typeof createGrower>} Grower */
