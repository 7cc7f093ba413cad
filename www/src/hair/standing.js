// Which strands there are of hair that is thinned: of all of them those that are left, so that what stays is where it was.

/** How much of hair there is, 0 to 1. @typedef {{ share: number }} Thinning */

/** What all strands together cover many times over is covered by fewer. */
const COVERS = 1.2;

/**
 * The first are anywhere on the head.
 * @param {number} count of those that are drawn at most
 * @param {Thinning} thinning
 * @returns {Uint16Array} their numbers, from the least on
 */
export const standingOf = (count, { share }) => Uint16Array.from({ length: Math.round(count * share ** COVERS) }, (_, n) => n);

/** How broad each is: hair that goes grows thin first. @param {Thinning} thinning */
export const breadthOf = ({ share }) => 0.25 + 0.75 * share;
