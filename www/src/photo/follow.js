import { Cancelled } from './fitter.js';

/**
 * Follows what changes faster than an answer comes: one question at a time, and the last state wins.
 * @template T
 * @param {{ ask: () => Promise<T>, take: (answer: T) => void, failed: (why: unknown) => void, wanted: () => boolean, turn: () => number }} on
 *   `wanted` is whether answers are; `turn` is another number once an answer is to a question that nobody has any more
 */
export function createFollowing({ ask, take, failed, wanted, turn }) {
  let asked = false;
  /** @type {Promise<void> | null} */
  let asking = null;
  async function follow() {
    while (asked && wanted()) {
      asked = false;
      const here = turn();
      try {
        const answer = await ask();
        if (here === turn() && wanted()) take(answer);
      } catch (error) {
        if (!(error instanceof Cancelled)) failed(error);
      }
    }
    asking = null;
  }
  return {
    /** Something has changed. @returns {Promise<void>} until the answer is taken */
    async changed() {
      asked = true;
      asking ??= follow();
      await asking;
    },
    /** Until what was asked is answered. */
    done: async () => asking,
  };
}
