import { POINTS } from './strands.js';

// What is drawn of strands: ribbons, of two corners a point.

/** Of the points of a strand those that are drawn where it hardly bends. */
export const SHORT = [0, 3, 6, 9, 12, 15, 18, 21, POINTS - 1];

/** A strand's own number, 0 to 1, by its place among all. @param {number} n */
export const numberOf = (n) => (n * 0.6180339887) % 1;

/**
 * What does not depend on a style: triangles of all points and of those that short hair takes, and each corner's lock and
 * its strand's own number.
 * @param {Pick<import('./strands.js').Planted, 'strands' | 'lockOf'>} planted
 */
export function layRibbons({ strands, lockOf }) {
  const all = new Uint32Array(strands * (POINTS - 1) * 6);
  const short = new Uint32Array(strands * (SHORT.length - 1) * 6);
  const strand = new Float32Array(strands * POINTS * 4);
  for (let n = 0, i = 0, j = 0; n < strands; n++) {
    for (let k = 1; k < SHORT.length; k++) {
      const [a, b] = [SHORT[k - 1], SHORT[k]].map((s) => 2 * (n * POINTS + s));
      for (const corner of [a, a + 1, b, a + 1, b + 1, b]) short[j++] = corner;
    }
    for (let s = 0; s < POINTS; s++) {
      const o = 2 * (n * POINTS + s);
      if (s < POINTS - 1) for (const corner of [0, 1, 2, 1, 3, 2]) all[i++] = o + corner;
      for (const side of [0, 1]) strand.set([lockOf[n], numberOf(n)], 2 * (o + side));
    }
  }
  return { all, short, strand };
}

/**
 * A style's ribbons before they have a width, each corner's: where it is, mm; the way to the tip, and on which side it is by
 * the sign of how open it is to the light; the way out of the head, as long as the ribbon has its breadth there, and how far along its
 * hair it is, to 1 in a point. And where it goes along with the head.
 * @param {import('./strands.js').Grown} grown
 */
export function ribbonsOf({ points, outward, open, breadth, ends, anchors }) {
  const count = points.length / 3;
  const out = { position: new Float32Array(6 * count), course: new Int8Array(8 * count), outward: new Int8Array(8 * count), ...anchors };
  for (let i = 0; i < count; i++) {
    const s = i % POINTS;
    const [a, b] = [3 * (s === 0 ? i : i - 1), 3 * (s === POINTS - 1 ? i : i + 1)];
    const [x, y, z] = [points[b] - points[a], points[b + 1] - points[a + 1], points[b + 2] - points[a + 2]];
    const scale = 127 / (Math.hypot(x, y, z) || 1);
    for (const side of [0, 1]) {
      const [o, p] = [6 * i + 3 * side, 8 * i + 4 * side];
      for (let k = 0; k < 3; k++) {
        out.position[o + k] = points[3 * i + k];
        out.outward[p + k] = Math.round(127 * breadth[i] * outward[3 * i + k]);
      }
      out.course[p] = Math.round(x * scale);
      out.course[p + 1] = Math.round(y * scale);
      out.course[p + 2] = Math.round(z * scale);
      out.course[p + 3] = (side ? 1 : -1) * Math.max(1, Math.round(127 * open[i]));
      out.outward[p + 3] = Math.round((127 * ends[(i - s) / POINTS] * s) / (POINTS - 1));
    }
  }
  return out;
}
