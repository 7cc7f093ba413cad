/** @param {{ rest?: import('./groundwork.js').Rest }} wish @param {Worker} worker @returns {Promise<any>} */
function answer(worker, wish) {
  return new Promise((resolve, reject) => {
    worker.addEventListener('error', reject);
    worker.addEventListener('message', ({ data }) => resolve(data));
    worker.postMessage(wish);
  });
}

/**
 * Begins a head's groundwork beside the page, in two workers; where there can be none, the page does it. The
 * studio's is begun before there is a head.
 */
export function layGroundwork() {
  /** @type {Worker[]} */
  const workers = [];
  /** @type {Promise<any> | null} */
  let studio = null;
  try {
    for (let i = 0; i < 2; i++) workers.push(new Worker(new URL('./groundwork.worker.js', import.meta.url), { type: 'module' }));
    studio = answer(workers[0], {});
    // It is waited for later.
    studio.catch(() => {});
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
        if (!studio) throw new Error('no worker');
        const [shared, own] = await Promise.all([studio, answer(workers[1], { rest })]);
        return { ...shared, ...own };
      } catch {
        const { headWork, studioWork } = await import('./groundwork.js');
        return { ...studioWork(), ...headWork(rest) };
      } finally {
        for (const worker of workers) worker.terminate();
      }
    },
  };
}

/** @typedef {ReturnType<typeof layGroundwork>} Laying */
