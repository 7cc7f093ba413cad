import { browLines } from './browline.js';

// Which form brows have: those of the model's own line, moved over the skin of the head at rest as it is seen from the front.

/** Each from 0 to 1, as a colouring has them; at a half brows are as the model has them. @typedef {{ breadth: number, arch: number, slant: number, apart: number, raise: number }} BrowForm */

/** How broad brows are beside their own, at both ends of the slider: 3 to 15 mm where they are fullest. */
const BREADTH = [0.36, 1.75];
/** How far an arch rises, and its ends go down, mm; how much higher its outer ends get; how far up all of it goes. */
const ARCH = 5;
const SLANT = 12;
const RAISE = 5;
/** How far inner ends go apart, mm; at the other end of the slider they meet but for so much. */
const APART = 7;
const MEET = 1.2;
/** Where along a brow an arch is highest, and what stays where it is when it slants. */
const PEAK = 0.62;
const PIVOT = 0.35;

/** How far from the middle of its slider something is, -1 to 1. @param {number} value */
const off = (value) => 2 * value - 1;

/**
 * The line of brows: `outer` ends and how long it is, mm from the middle; how high it is there, a polynomial of how far from the outer end, 0 to
 * 1 at the inner one. Both brows are taken for one, as they are on both sides of any face.
 * @typedef {{ outer: number, length: number, heights: readonly number[] }} BrowLine
 */

/** @param {import('../groundwork/paint.js').Points} landmarks of the head at rest, mm @returns {BrowLine | null} null without them */
export function browLine(landmarks) {
  const lines = browLines(landmarks);
  if (lines.some((line) => line.length < 5)) return null;
  const mean = lines[0].map((point, i) => [(Math.abs(point[0]) + Math.abs(lines[1][i][0])) / 2, (point[1] + lines[1][i][1]) / 2]);
  const [outer, length] = [mean[4][0], mean[4][0] - mean[0][0]];
  if (!(length > 0)) return null;
  return { outer, length, heights: cubic(mean.map(([x, y]) => [(outer - x) / length, y])) };
}

/** The cubic that comes closest to some points. @param {number[][]} points */
function cubic(points) {
  const powers = [0, 1, 2, 3];
  const rows = powers.map((i) => [...powers.map((k) => points.reduce((sum, [w]) => sum + w ** (i + k), 0)), points.reduce((sum, [w, y]) => sum + w ** i * y, 0)]);
  // Gauss's elimination: the matrix is positive definite, for no two of the points have the same place.
  for (const i of powers) {
    for (const k of powers) {
      if (k === i) continue;
      const factor = rows[k][i] / rows[i][i];
      rows[k] = rows[k].map((value, j) => value - factor * rows[i][j]);
    }
  }
  return powers.map((i) => rows[i][4] / rows[i][i]);
}

/** How broad brows are beside their own. @param {Pick<BrowForm, 'breadth'>} form */
export function broadOf({ breadth }) {
  const far = off(breadth);
  return 1 + Math.abs(far) * ((far < 0 ? BREADTH[0] : BREADTH[1]) - 1);
}

/**
 * What a form does, in mm: `apart` of the inner ends, how broad they are, and what is added to the height.
 * @param {BrowForm} form @param {BrowLine} line
 */
export function movesOf(form, { outer, length }) {
  const { arch, slant, apart, raise } = form;
  return {
    // Hairs grow from before the line's inner end on.
    apart: apart < 0.5 ? off(apart) * Math.max(0, outer - length - MEET) : off(apart) * APART,
    broad: broadOf(form),
    raise: RAISE * off(raise),
    arch: ARCH * off(arch),
    slant: SLANT * off(slant),
  };
}

/** @typedef {ReturnType<typeof movesOf>} BrowMoves */

/** How high the line is, a share of its length from the outer end. @param {BrowLine} line @param {number} w */
export const heightOf = ({ heights: [a, b, c, d] }, w) => a + w * (b + w * (c + w * d));

/** @param {BrowMoves} moves @param {number} w */
const raised = ({ raise, arch, slant }, w) => raise + arch * (0.6 - ((1 - w - PEAK) / 0.5) ** 2) + slant * (1 - w - PIVOT);

/**
 * Where a place of the model's own brows is in a form.
 * @param {BrowLine} line @param {BrowMoves} moves @param {number} x @param {number} y mm
 */
export function movedBrow(line, moves, x, y) {
  const w = (line.outer - Math.abs(x)) / line.length;
  const across = Math.abs(x) + moves.apart * w * w;
  return [Math.sign(x) * across, heightOf(line, w) + moves.broad * (y - heightOf(line, w)) + raised(moves, w)];
}

/**
 * How far a form turns what grows there towards the temple's way up, radians.
 * @param {BrowLine} line @param {BrowMoves} moves @param {number} x mm
 */
export function turnOfBrow(line, moves, x) {
  const way = (/** @type {(x: number, y: number) => number[]} */ place) => {
    const [inner, outer] = [-1, 1].map((step) => {
      const at = Math.abs(x) + step;
      return place(at, heightOf(line, (line.outer - at) / line.length));
    });
    return Math.atan2(outer[1] - inner[1], outer[0] - inner[0]);
  };
  return way((at, y) => movedBrow(line, moves, at, y)) - way((at, y) => [at, y]);
}

/**
 * Which place of the model's own brows a place in a form is of: a share of the line's length from its outer end, and how far it is above the line, mm.
 * @param {BrowLine} line @param {BrowMoves} moves @param {number} x @param {number} y mm
 */
export function unmovedBrow(line, moves, x, y) {
  const far = (line.outer - Math.abs(x)) / line.length;
  // The place w for which w - apart / length w^2 is that far.
  const w = (2 * far) / (1 + Math.sqrt(Math.max(0, 1 - ((4 * moves.apart) / line.length) * far)));
  return [w, (y - heightOf(line, w) - raised(moves, w)) / moves.broad];
}

/** The same, but for the place itself, in a shader that has `browLine` (the heights), `browSpan` (outer end, length), `browMoves` (apart, broad, raise, arch) and `browSlant`. */
export const UNMOVED_GLSL = /* glsl */ `
  vec2 unmovedBrow(vec2 at) {
    float far = (browSpan.x - abs(at.x)) / browSpan.y;
    // The place w for which w - apart / length w^2 is that far.
    float w = 2.0 * far / (1.0 + sqrt(max(0.0, 1.0 - 4.0 * browMoves.x / browSpan.y * far)));
    float line = browLine.x + w * (browLine.y + w * (browLine.z + w * browLine.w));
    float arch = (1.0 - w - ${PEAK}) / 0.5;
    float up = browMoves.z + browMoves.w * (0.6 - arch * arch) + browSlant * (1.0 - w - ${PIVOT});
    return vec2((at.x < 0.0 ? -1.0 : 1.0) * (browSpan.x - browSpan.y * w), line + (at.y - line - up) / browMoves.y);
  }
`;
