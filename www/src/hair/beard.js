import { distanceTo, points, smoothstep } from '../groundwork/paint.js';
import { clamp } from './hull.js';

// A beard that is longer than stubble, with a moustache.

/** What of a colouring it goes by, from 0 to 1; its curl is its own. @typedef {import('./strands.js').Curled} Beard */

/** On the chin, mm. */
const LONGEST = 95;

/** How long a beard is on the chin, mm. @param {{ length: number }} style */
export const beardLength = ({ length }) => LONGEST * length ** 1.5;

/**
 * @param {Float32Array} beard how far inside of a beard's line each vertex is
 * @param {import('../groundwork/paint.js').Points} landmarks
 * @returns {import('./strands.js').Ground<Beard> | null} null without the landmarks that it goes by
 */
export function beardGround(beard, landmarks) {
  const lips = points(landmarks, 48, 59);
  const ear = landmarks.get('tragion left');
  if (lips.length < 12 || !ear) return null;
  const [right, left, above, below] = [lips[0], lips[6], lips[3], lips[9]];
  const outline = lips.map(([x, y]) => [x, y]);
  const half = (left[0] - right[0]) / 2;
  const parting = (above[1] + below[1]) / 2;
  return {
    mask: beard,
    line: 0.45,
    bare: (x, y) => distanceTo(outline, x, y) < 1.5,
    seed: 71,
    strands: 3800,
    apart: 7,
    long: beardLength,
    thick: (long) => Math.min(7, 0.16 * long),
    lift: 0.4,
    kept: 30,
    comb: () => ({
      field(x, y, z, _, way) {
        // A moustache is combed to both sides, and all else down.
        const over = smoothstep(parting - 2, parting + 3, y) * (1 - smoothstep(half + 4, half + 14, Math.abs(x)));
        way[0] = over * clamp(x / 4, -1, 1) + (1 - over) * clamp(x / 160, -0.3, 0.3);
        way[1] = -1 + 0.35 * over;
        way[2] = -0.1 * (1 - over);
      },
      // Longest on the chin, shorter on the cheeks, and above the lip no longer than to the corners of the mouth.
      reach(x, y, z, long) {
        const over = smoothstep(parting - 2, parting + 3, y) * (1 - smoothstep(half + 6, half + 16, Math.abs(x)));
        const back = smoothstep(0.65 * right[2] + 0.35 * ear[2], ear[2], z);
        return long * Math.max(0.2, 1 - 0.6 * over - 0.6 * back);
      },
      early: () => 0,
      // Off the lips.
      cut: (x, y, z, jitter) => Math.abs(x) < half && y < above[1] + 0.6 + jitter && y > below[1] - 1 && z > right[2] - 12,
      inward: () => 0.1,
    }),
  };
}
