import { paintLines } from './lines.js';

/** A page that has come is at rest by then, ms. */
const REST = 1000;

/**
 * Has the lines of a head painted beside the page, so that nobody waits for them who is the first to draw a slider that
 * shows some.
 * @param {import('../groundwork/paint.js').Points} landmarks
 * @param {(lines: ReturnType<typeof paintLines>) => void} done
 * @returns {() => ReturnType<typeof paintLines>} what paints them at once, for who cannot wait
 */
export function layLines(landmarks, done) {
  const later = setTimeout(() => {
    try {
      const worker = new Worker(new URL('./lines.worker.js', import.meta.url), { type: 'module' });
      worker.addEventListener('message', ({ data }) => {
        worker.terminate();
        done(data);
      });
      worker.postMessage(landmarks);
    } catch {
      // Where there can be no worker, the first slider waits.
    }
  }, REST);
  return () => {
    clearTimeout(later);
    return paintLines(landmarks);
  };
}
