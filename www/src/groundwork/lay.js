/**
 * Begins a head's groundwork beside the page, in a worker; where there can be none, the page does it.
 */
export function layGroundwork() {
  /** @type {Worker | null} */
  let worker = null;
  /** What the worker says, one answer after the other. @type {Promise<any>[]} */
  let answers = [];
  try {
    const beside = new Worker(new URL('./groundwork.worker.js', import.meta.url), { type: 'module' });
    worker = beside;
    /** @type {((answer: unknown) => void)[]} */
    const tell = [];
    answers = [0, 1].map(
      () =>
        new Promise((resolve, reject) => {
          tell.push(resolve);
          beside.addEventListener('error', reject);
        }),
    );
    // They are waited for later.
    for (const answer of answers) answer.catch(() => {});
    beside.addEventListener('message', ({ data }) => tell.shift()?.(data));
  } catch {
    // Done below.
  }
  return {
    /**
     * @param {import('./groundwork.js').Rest} rest
     * @returns {Promise<import('./groundwork.js').Groundwork>}
     */
    async of(rest) {
      try {
        if (!worker) throw new Error('no worker');
        worker.postMessage(rest);
        return Object.assign({}, ...(await Promise.all(answers)));
      } catch {
        const { headWork, studioWork } = await import('./groundwork.js');
        return { ...studioWork(), ...headWork(rest) };
      } finally {
        worker?.terminate();
      }
    },
  };
}
