import { valueIn } from '../head/colouring.js';

/** How many are taken between two frames: the stage is drawn again after each batch. */
const BATCH = 4;

/** Whether hair is to be grown for somebody, which takes longer than all else. @param {import('../keep/library.js').Likeness} sitter */
const isLongHaired = ({ colouring = {} }) => Math.max(valueIn(colouring, 'length'), valueIn(colouring, 'beardLength')) > 0;

/**
 * Those of who waits who sit for their portraits next: of the long-haired one at a time.
 * @param {Iterable<string>} waiting each a likeness as JSON
 */
export function batchOf(waiting) {
  /** @type {[string, import('../keep/library.js').Likeness][]} */
  const batch = [];
  for (const code of waiting) {
    /** @type {import('../keep/library.js').Likeness} */
    const sitter = JSON.parse(code);
    if (isLongHaired(sitter) && batch.some(([, other]) => isLongHaired(other))) continue;
    batch.push([code, sitter]);
    if (batch.length === BATCH) break;
  }
  return batch;
}
