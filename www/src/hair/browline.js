import { points, smoothstep } from '../groundwork/paint.js';

/** Half as high as a brow is where it is fullest, mm. */
const HALF = 4.3;

/**
 * A hair of a brow, seen from the front: its root and how far its tip is from that, mm; how far along the brow it grows, and how far up,
 * -0.5 to 0.5.
 * @typedef {{ x: number, y: number, dx: number, dy: number, t: number, across: number }} BrowHair
 */

/**
 * So far below the model's landmarks hair grows, mm, from the nose outwards: as `brow_hair` in `src/anatomy.rs`, which says why, and paints
 * the model's own brows there.
 */
export const BELOW = [8.5, 7, 6.5, 6, 6];

/** The five points of each brow, from the nose outwards. @param {import('../groundwork/paint.js').Points} at landmarks, mm */
export const browLines = (at) => [points(at, 17, 21).reverse(), points(at, 22, 26)].map((line) => line.map(([x, y, z], i) => [x, y - BELOW[i], z]));

/**
 * Both brows hair by hair.
 * @param {number[][][]} lines of five points each
 * @param {number} tries how many hairs each has at most
 * @param {() => number} random
 * @param {(hair: BrowHair) => void} each called before the next one's chances are drawn
 */
export function growBrows(lines, tries, random, each) {
  for (const brow of lines) {
    const side = Math.sign(brow[4][0] - brow[0][0]);
    const along = (/** @type {number} */ t) => {
      const s = Math.min(3.999, t * 4);
      const i = Math.floor(s);
      const [a, b] = [brow[i], brow[i + 1]];
      return [a[0] + (b[0] - a[0]) * (s - i), a[1] + (b[1] - a[1]) * (s - i)];
    };
    for (let n = 0; n < tries; n++) {
      const t = random();
      const across = (random() + random()) / 2 - 0.5;
      // A brow begins soft, is fullest at a quarter and runs out in a tail.
      const half = HALF * Math.min(1, 0.6 + 2 * t) * (1 - 0.7 * smoothstep(0.35, 1, t));
      // As many would be one stroke where it is narrow.
      if (random() > 0.12 + 0.2 * half) continue;
      const [cx, cy] = along(t);
      const x = cx + (random() - 0.5) * 1.2 - side * 1.5 * (1 - t);
      const y = cy + across * 2 * half - 1.2;
      // Hairs stand up at the inner end and lie down towards the temple; the upper ones point
      // down a little, the lower ones up.
      const [ax, ay] = along(Math.max(0, t - 0.1));
      const [bx, by] = along(Math.min(1, t + 0.1));
      const course = Math.atan2(by - ay, Math.abs(bx - ax));
      const rise = course + 1.2 * (1 - smoothstep(0, 0.5, t)) + 0.12 - 0.7 * across + (random() - 0.5) * (0.35 + 0.45 * smoothstep(0.5, 1, t));
      const length = (3.2 + 3.2 * random()) * (1 - 0.38 * t);
      each({ x, y, dx: side * Math.cos(rise) * length, dy: Math.sin(rise) * length, t, across });
    }
  }
}
