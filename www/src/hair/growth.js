import { smoothed } from '../groundwork/occlusion.js';
import { distanceTo } from '../groundwork/paint.js';
import { MARGIN } from './margin.js';

// Where hair and a beard grow on the generic head.

// Lines around the head, from the middle of the face to the middle of the nape: degrees around an upright axis, and
// heights of which 0 is the tragion's and 1 the trichion's, the hairline's midpoint. A man's who keeps his hair:
// a little back above the temples, down before the ear and around it, and along the nape.
const HAIRLINE = [
  [0, 1], [14, 1.01], [27, 1.05], [36, 1.02], [44, 0.86], [51, 0.68], [57, 0.54], [64, 0.48], [71, 0.4], [77, 0.27],
  [81, 0.1], [83, -0.04], [97, -0.05], [112, -0.1], [128, -0.22], [150, -0.34], [180, -0.38],
];
/** From below the nose over the cheek to the ear, and back along the throat. */
const BEARD = [
  [0, -0.31], [8, -0.32], [15, -0.41], [21, -0.5], [31, -0.45], [43, -0.38], [56, -0.27], [70, -0.15], [80, -0.05], [84, 0.02], [97, 0],
  [98, -0.3], [90, -0.58], [78, -0.78], [60, -0.95], [38, -1.07], [18, -1.12], [0, -1.13],
];
/** Of a head around its axis, mm: what makes a line of angles and heights one of lengths. */
const RADIUS = 75;

/**
 * How far inside the lines within which hair and beard grow each vertex is, in `MARGIN`s, -1 to 1.
 * A head without the landmarks that they go by has neither.
 * @param {Float32Array} rest 3 a vertex, mm
 * @param {import('../groundwork/paint.js').Points} at landmarks
 * @param {Iterable<number>} hollow vertices in the mouth and behind the lids
 * @param {Uint32Array} triangles
 */
export function growth(rest, at, hollow, triangles) {
  const count = rest.length / 3;
  const [scalp, beard] = [0, 1].map(() => new Float32Array(count).fill(-1));
  const [trichion, tragion, root, above, behind, below] = ['trichion', 'tragion left', 'helix root left', 'superaurale left', 'postaurale left', 'subaurale left'].map((name) => at.get(name));
  if (!trichion || !tragion || !root || !above || !behind || !below) return { scalp, beard };
  const tall = trichion[1] - tragion[1];
  const axis = tragion[2] + 0.11 * tall;
  const line = (/** @type {number[][]} */ points) => points.map(([angle, height]) => [(angle / 180) * Math.PI * RADIUS, tragion[1] + height * tall]);
  const mirrored = (/** @type {number[][]} */ points) => points.slice(1).reverse().map(([x, y]) => [-x, y]);
  const hairline = line(HAIRLINE);
  // Past the nape, so that its two ends are no edges, and over the crown.
  const past = 4 * RADIUS;
  const [, nape] = hairline[hairline.length - 1];
  const over = trichion[1] + 10 * tall;
  const within = [...mirrored(hairline), ...hairline, [past, nape], [past, over], [-past, over], [-past, nape]];
  const half = line(BEARD);
  const around = [...mirrored(half.slice(0, -1)), ...half];
  for (let v = 0; v < count; v++) {
    const [x, y, z] = [rest[3 * v], rest[3 * v + 1], rest[3 * v + 2]];
    // What stands off the head where ears are is an ear: how far into it, mm. Skin around it stays bare for a
    // millimetre, and hair is whole after three.
    const off = Math.max(Math.abs(x) - root[0] - 0.6, Math.min(root[1] + 1 - y, z - behind[2] - 2));
    const ear = Math.min(off, above[1] + 2 - y, root[2] + 3 - z, z - behind[2] + 4, y - below[1] + 4);
    const most = (-5 * ear - 4) / MARGIN;
    const turn = Math.atan2(x, z - axis) * RADIUS;
    scalp[v] = Math.max(-1, Math.min(1, most, -distanceTo(within, turn, y) / MARGIN));
    beard[v] = Math.max(-1, Math.min(1, most, -distanceTo(around, turn, y) / MARGIN));
  }
  for (const v of hollow) scalp[v] = beard[v] = -1;
  // Triangles around ears are no steps.
  return { scalp: smoothed(scalp, triangles, 2), beard: smoothed(beard, triangles, 1) };
}
