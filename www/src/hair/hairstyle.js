import { smoothstep } from '../groundwork/paint.js';
import { clamp, norm } from './hull.js';
import { hairLength } from './length.js';
import { EARLIEST } from './strands.js';

// Hair on the head: combed back, parted, or forward into a fringe.

/** What of a colouring is a style, each from 0 to 1. @typedef {{ length: number, comb: number, parting: number, curl: number }} Style */

/** Where hair parts, mm to the subject's left. @param {Style} style */
const lineOf = ({ parting }) => (0.5 - parting) * 90;

/** How much of it is combed forward: from parted to a fringe, which is whole before the slider ends. @param {Style} style */
const fringeOf = ({ comb }) => clamp((comb - 0.5) / 0.3, 0, 1);
/** How much of it is combed back. @param {Style} style */
const backOf = ({ comb }) => Math.max(0, 1 - 2 * comb);
/** How far a fringe is swept to the subject's left, -1 to 1: away from where hair would part. @param {Style} style */
const sweptBy = (style) => fringeOf(style) * clamp(2 * style.parting - 1, -1, 1);
/** How much of it is parted, which is the rest. @param {Style} style */
const asideOf = (style) => 1 - backOf(style) - fringeOf(style);

/** A fringe is made of the hair that grows so far behind the hairline, mm, and less of what is so much farther back. */
const FRINGE = [45, 45];

/**
 * @param {Float32Array} scalp how far inside the hairline each vertex is
 * @param {import('../groundwork/paint.js').Points} landmarks
 * @param {import('./hull.js').Hull} hull
 * @returns {import('./strands.js').Ground<Style> | null} null without the landmarks that it goes by
 */
export function scalpGround(scalp, landmarks, { middle }) {
  const [brow, trichion] = ['ibug_19', 'trichion'].map((name) => landmarks.get(name));
  if (!brow || !trichion) return null;
  /** How far from the middle of the face, around the head. @param {number} x @param {number} z */
  const around = (x, z) => Math.abs(Math.atan2(x, z - middle[2]));
  const turned = (/** @type {number} */ y, /** @type {number} */ z) => Math.atan2(y - middle[1], z - middle[2]);
  const [front, tall] = [turned(trichion[1], trichion[2]), norm(trichion[1] - middle[1], trichion[2] - middle[2])];
  /** How far behind the hairline's midpoint, mm over the head. @param {number} y @param {number} z */
  const fromHairline = (y, z) => tall * (turned(y, z) - front);
  return {
    mask: scalp,
    line: 0.3,
    seed: 67,
    strands: 6000,
    apart: 12,
    long: hairLength,
    thick: (long) => Math.min(9, 0.11 * long),
    lift: 0.55,
    kept: 55,
    comb(roots) {
      // Hair grows away from a whorl behind the crown.
      const crown = roots.reduce((top, at) => Math.max(top, at[1]), -Infinity);
      const back = roots.reduce((least, at) => Math.min(least, at[2]), Infinity);
      const whorl = [6, crown - 0.1 * (crown - middle[1]), middle[2] + 0.62 * (back - middle[2])];
      return {
        field(x, y, z, style, way) {
          const { curl } = style;
          const [toBack, toSide, toFront] = [backOf(style), asideOf(style), fringeOf(style)];
          const behind = smoothstep(whorl[2] + 25, whorl[2] - 10, z);
          const across = clamp((x - lineOf(style)) / 3, -1, 1);
          const away = norm(x - whorl[0], y - whorl[1], z - whorl[2]) || 1;
          const natural = behind + (1 - behind) * toFront;
          // Curls do not lie down to be parted.
          const side = (1 - behind) * toSide * (1 - 0.8 * curl * curl);
          const backwards = (1 - behind) * toBack;
          // Before the ears hair goes down however it is combed.
          const low = 2 * backwards * smoothstep(middle[1] + 15, middle[1] - 20, y);
          // Over the forehead what is combed aside goes back, too, until it can fall before the ear.
          const front = 1 - smoothstep(0.7, 1.3, around(x, z));
          const swept = (1 - behind) * sweptBy(style) * (1 - smoothstep(0.6, 1, around(x, z))) * (1 - smoothstep(5, FRINGE[0], fromHairline(y, z)));
          way[0] = (natural * (x - whorl[0])) / away + side * across + backwards * clamp(x / 130, -0.5, 0.5) + 0.9 * swept;
          way[1] = (natural * (y - whorl[1])) / away - 0.45 * side * (1 - front) - 0.2 * backwards - low;
          way[2] = (natural * (z - whorl[2])) / away - (0.3 + 0.5 * front) * side - backwards;
        },
        // Around the ears and along the nape short hair is cut shorter than on top.
        reach(x, y, z, long, style) {
          const below = 1 - smoothstep(middle[1] - 10, middle[1] + 45, y);
          const lowest = smoothstep(middle[1] + 5, middle[1] - 20, y);
          const own = long * (1 - (0.5 * below + 0.15 * lowest) * (1 - smoothstep(60, 130, long)));
          // A fringe ends in a line: what grows farther back is longer.
          const back = fromHairline(y, z);
          const taken = fringeOf(style) * (1 - smoothstep(0.7, 1.1, around(x, z))) * (1 - smoothstep(FRINGE[0], FRINGE[0] + FRINGE[1], back));
          return own + taken * Math.max(0, back);
        },
        // Between what parts the skin would show: it begins beyond the line, and beyond the whorl.
        early(x, y, z, style) {
          const parted = z > whorl[2] ? asideOf(style) * Math.exp(-(((x - lineOf(style)) / 9) ** 2)) : 0;
          return EARLIEST * Math.max(parted, Math.exp(-((x - whorl[0]) ** 2 + (z - whorl[2]) ** 2) / 150));
        },
        // It does not hang before the eyes: it is cut over the brows.
        cut: (x, y, z, jitter) => y + 4 * jitter < brow[1] + 9 && around(x, z) < 0.95,
        // Nor does it hang before the forehead, unless it is a fringe, which lies on it.
        held(x, y, z, style) {
          const fringe = fringeOf(style);
          const low = 1 - smoothstep(trichion[1] - 12, trichion[1] + 30, y);
          return low * (1 - smoothstep(0.85 + 0.2 * (1 - fringe), 1.4, around(x, z)));
        },
        // What is cut in a line does not end in points.
        even: fringeOf,
        // Below the head it falls towards the neck.
        inward: (y) => 0.25 * smoothstep(middle[1] - 20, middle[1] - 80, y),
      };
    },
  };
}
