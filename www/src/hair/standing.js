import { SOFT } from './parts.js';

// Which strands there are of hair that is thinned: of all of them those that are left, so that what stays is where it was.

/**
 * How much of hair there is, 0 to 1, and how much of each of its parts has gone.
 * @typedef {{ share: number, gone: readonly number[] }} Thinning
 */

/** What all strands together cover many times over is covered by fewer. */
const COVERS = 1.2;

/**
 * Those of the first strands that stand; the first are anywhere on the head.
 * @param {number} count of those that are drawn at most
 * @param {Pick<import('./strands.js').Planted, 'parts'>} planted
 * @param {Thinning} thinning
 * @returns {Uint16Array} their numbers, from the least on
 */
export function standingOf(count, { parts }, { share, gone }) {
  const standing = new Uint16Array(Math.round(count * share ** COVERS));
  let many = 0;
  for (let n = 0; n < standing.length; n++) {
    // A line is where hairs become few, one here and one there, but none stands alone.
    const own = (n * 0.7548776662466927) % 1;
    if (SOFT * (parts[4 * n + 3] / 255 - gone[3]) < 0.9 * Math.sqrt(own) + 0.1) continue;
    if (parts[4 * n] * gone[0] + parts[4 * n + 1] * gone[1] + parts[4 * n + 2] * gone[2] > 250 * (1 - own)) continue;
    standing[many++] = n;
  }
  return standing.slice(0, many);
}

/** How broad each is: hair that goes grows thin first. @param {Thinning} thinning */
export const breadthOf = ({ share }) => 0.25 + 0.75 * share;
