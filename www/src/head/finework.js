import { paintStrands } from '../hair/tile.js';
import { paintLines } from './lines.js';

/** A page that has come is at rest by then, ms. */
const REST = 1000;

/**
 * What is fine on a skin: lines and freckles, and hair that is cropped.
 * @typedef {{ lines: ReturnType<typeof paintLines>, strands: ReturnType<typeof paintStrands> }} Finework
 */

/**
 * Has the fine things of a skin painted beside the page when it is at rest, so that nobody waits for them who is the first to
 * draw a slider that shows some.
 * @param {import('../groundwork/paint.js').Points} landmarks
 * @param {(work: Partial<Finework>) => void} done called with each of them, once
 */
export function layFinework(landmarks, done) {
  /** @type {Set<keyof Finework>} */
  const missing = new Set(['lines', 'strands']);
  /** @param {keyof Finework} what */
  function paint(what) {
    if (missing.delete(what)) done(what === 'lines' ? { lines: paintLines(landmarks) } : { strands: paintStrands() });
  }
  /** Null where there is none. @type {Worker | null | undefined} */
  let worker;
  /** What cannot wait for a worker that does not work. @type {Set<keyof Finework>} */
  const wanted = new Set();
  function fail() {
    worker?.terminate();
    worker = null;
    for (const what of wanted) paint(what);
  }
  function begin() {
    if (worker !== undefined) return;
    try {
      worker = new Worker(new URL('./finework.worker.js', import.meta.url), { type: 'module' });
      worker.addEventListener('error', fail);
      worker.addEventListener('message', ({ data }) => {
        // One at a time; who could not wait has it already.
        if (missing.delete('lines' in data ? 'lines' : 'strands')) done(data);
        if (missing.size === 0) worker?.terminate();
      });
      worker.postMessage(landmarks);
    } catch {
      fail();
    }
  }
  const later = setTimeout(begin, REST);
  return {
    dispose() {
      clearTimeout(later);
      worker?.terminate();
    },
    /** Paints it at once. */
    now: paint,
    /** Does not wait for the page to rest. @param {keyof Finework} what */
    soon(what) {
      wanted.add(what);
      begin();
      if (!worker) paint(what);
    },
  };
}
