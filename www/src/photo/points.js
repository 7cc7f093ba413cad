// From the points of MediaPipe's face mesh to the 68 of iBUG.
//
// The table is our own. For each point of iBUG's drawing it has the vertices of the canonical face mesh
// that MediaPipe publishes with its landmark model whose mean comes nearest to it. Where iBUG's annotators
// space points evenly between two ends (jaw, brows), so does this. What the points are still off by is in
// `detected.js`.
// Sides are the subject's, as in iBUG's numbers; a row goes as iBUG counts, and a vertex that stands
// twice counts twice.

/** The face oval from the right temple along the jaw to the chin, and on to the left temple. */
const RIGHT_JAW = [[127, 162], [127], [234], [93], [132], [58], [172], [136], [150], [149], [176], [148], [152]];
const LEFT_JAW = [[152], [377], [400], [378], [379], [365], [397], [288], [361], [323], [454], [356], [356, 389]];
/** Brows, each from the subject's right to left: between the upper and the lower row of vertices. */
const RIGHT_BROW = [[70, 46], [63, 53], [105, 52], [66, 65], [107, 55]];
const LEFT_BROW = [[336, 285], [296, 295], [334, 282], [293, 283], [300, 276]];

/** Points 27 to 67. */
const INNER = [
  // The ridge of the nose downwards, and along its base.
  [168, 6], [197], [195, 5], [4],
  [98, 97], [97], [2], [326], [327, 326],
  // Right eye from its outer corner over the upper lid, then the left from its inner.
  [33], [160], [158], [133], [153], [144],
  [362], [385], [387], [263], [373], [380],
  // The outer border of the lips from the right corner over the upper lip, then the inner.
  [61], [39, 40], [37], [0], [267], [269, 270], [291], [321, 321, 405], [314, 405], [17], [84, 181], [91, 91, 181],
  [78], [81], [13], [311], [308], [402], [14], [178],
];

/**
 * Points along a line with equal lengths between them, its ends among them.
 * @param {(readonly [number, number])[]} line @param {number} count
 */
function evenly(line, count) {
  const lengths = line.slice(1).map(([x, y], i) => Math.hypot(x - line[i][0], y - line[i][1]));
  const step = lengths.reduce((sum, length) => sum + length, 0) / (count - 1);
  /** @type {[number, number][]} */
  const even = [];
  let segment = 0;
  let before = 0;
  for (let i = 0; i < count; i++) {
    const at = i * step;
    while (segment < lengths.length - 1 && before + lengths[segment] < at) before += lengths[segment++];
    const t = Math.min(1, lengths[segment] > 0 ? (at - before) / lengths[segment] : 0);
    const [a, b] = [line[segment], line[segment + 1]];
    even.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
  }
  return even;
}

/**
 * @param {ArrayLike<number>} mesh 468 points as x, y pairs
 * @returns {Float64Array} 68 points as x, y pairs
 */
export function ibugOf(mesh) {
  /** @param {readonly number[]} vertices @returns {[number, number]} */
  const at = (vertices) => {
    const sum = [0, 0];
    for (const vertex of vertices) for (const axis of [0, 1]) sum[axis] += mesh[2 * vertex + axis];
    return [sum[0] / vertices.length, sum[1] / vertices.length];
  };
  return Float64Array.from(
    [
      ...evenly(RIGHT_JAW.map(at), 9),
      ...evenly(LEFT_JAW.map(at), 9).slice(1),
      ...evenly(RIGHT_BROW.map(at), 5),
      ...evenly(LEFT_BROW.map(at), 5),
      ...INNER.map(at),
    ].flat(),
  );
}

/** The mesh's points, and the first of the five of the subject's right and left iris, which is its middle. */
const MESH = 468;
const IRISES = [MESH, MESH + 5];
/** @param {ArrayLike<number>} mesh as x, y pairs @returns {Float64Array | undefined} where the irises are, in the same order; none of a mesh without */
export function irisesOf(mesh) {
  if (mesh.length <= 2 * IRISES[1]) return undefined;
  return Float64Array.from(IRISES.flatMap((i) => [mesh[2 * i], mesh[2 * i + 1]]));
}

/** How many points there are, and the first of them that is not the jaw's. */
export const COUNT = 68;
export const INNER_FROM = 17;

/**
 * The frame of a face: turned and scaled so that its inner points lie on those of the mean head.
 * @param {ArrayLike<number>} points 68 as x, y pairs, px
 * @param {ArrayLike<ArrayLike<number>>} mean the mean head's, mm, the inner ones around 0
 */
export function frameOf(points, mean) {
  const inner = Array.from({ length: COUNT - INNER_FROM }, (_, i) => i + INNER_FROM);
  const [cx, cy] = [0, 1].map((axis) => inner.reduce((sum, i) => sum + points[2 * i + axis], 0) / inner.length);
  let [re, im, square] = [0, 0, 0];
  for (const i of inner) {
    const [x, y] = [points[2 * i] - cx, points[2 * i + 1] - cy];
    re += x * mean[i][0] + y * mean[i][1];
    im += x * mean[i][1] - y * mean[i][0];
    square += x * x + y * y;
  }
  const [a, b] = [re / square, im / square];
  return {
    /** A mm in px. */
    scale: 1 / Math.hypot(a, b),
    /** @param {number} px @param {number} py @returns {[number, number]} mm */
    inFrame: (px, py) => [a * (px - cx) - b * (py - cy), b * (px - cx) + a * (py - cy)],
    /** A displacement. @param {number} x @param {number} y mm @returns {[number, number]} px */
    inPhoto: (x, y) => [(a * x + b * y) / (a * a + b * b), (a * y - b * x) / (a * a + b * b)],
  };
}

/**
 * Where a head looks, as the terms of a polynomial: how far the tip of the nose is beside the middle of the
 * eyes, and how far down on the way to the mouth. Heads that are turned farther than 40 degrees count as that.
 * @param {ArrayLike<ArrayLike<number>>} at 68 points in the frame of the face
 */
export function looking(at) {
  const half = (/** @type {number} */ i, /** @type {number} */ j, /** @type {number} */ axis) => (at[i][axis] + at[j][axis]) / 2;
  const eyes = half(36, 45, 1);
  const within = (/** @type {number} */ value, /** @type {number} */ most) => Math.min(most, Math.max(-most, value));
  const aside = within((at[30][0] - half(36, 45, 0)) / 20, 1.8);
  const down = within(5 * ((at[30][1] - eyes) / (half(48, 54, 1) - eyes) - 0.68), 1.2);
  return [1, aside, down, aside * aside, aside * down, down * down];
}

/**
 * What is known of a detector's errors, in the frame of the face, mm, with x and y of the inner points one after the other: for each
 * of the terms of `looking` where these points are usual and by how much they are off in the mean; by how much more for each number
 * that is not usual; and the root mean square of those up to which that is so.
 * @typedef {{ usual: number[][], bias: number[][], drawn: number[][], most: number }} Known
 */

/** What a linear map makes of numbers. @param {readonly number[]} of @param {readonly (readonly number[])[]} map */
export const mapped = (of, map) => map[0].map((_, e) => of.reduce((sum, value, i) => sum + value * map[i][e], 0));
/** @param {readonly number[]} a @param {readonly number[]} b */
export const less = (a, b) => a.map((value, i) => value - b[i]);
/** The root mean square. @param {readonly number[]} of */
export const size = (of) => Math.sqrt(of.reduce((sum, value) => sum + value ** 2, 0) / of.length);

/**
 * What of the error of the inner points is expected.
 * @param {{ terms: number[], found: number[] }} head where it looks and where its points were found @param {Known} known
 */
export function expectedError({ terms, found }, { usual, bias, drawn, most }) {
  const unusual = less(found, mapped(terms, usual));
  // What is farther from all that was learned from is not told of as surely.
  const part = Math.min(1, most / size(unusual));
  const own = mapped(unusual, drawn);
  return mapped(terms, bias).map((value, e) => value + part * own[e]);
}

/** The lines of the drawing, as runs of points: first, last, whether it closes. */
export const LINES = /** @type {const} */ ([
  ['jaw', 0, 16, false],
  ['rightBrow', 17, 21, false],
  ['leftBrow', 22, 26, false],
  ['ridge', 27, 30, false],
  ['nostrils', 31, 35, false],
  ['rightEye', 36, 41, true],
  ['leftEye', 42, 47, true],
  ['outerLips', 48, 59, true],
  ['innerLips', 60, 67, true],
]);

/**
 * The box around points: left, top, right, bottom.
 * @param {ArrayLike<number>} points x, y pairs
 */
export function boxOf(points) {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 2) {
    box[0] = Math.min(box[0], points[i]);
    box[1] = Math.min(box[1], points[i + 1]);
    box[2] = Math.max(box[2], points[i]);
    box[3] = Math.max(box[3], points[i + 1]);
  }
  return box;
}

/** A face with room around it, as a part of its height. @param {Float64Array} points @param {number} part */
export function around(points, part) {
  const [left, top, right, bottom] = boxOf(points);
  const room = part * (bottom - top);
  return [left - room, top - room, right + room, bottom + room];
}

/**
 * The points of the median face as a camera in front of it would see them, in a box one high around 0.
 * @param {import('phiz').FaceModel} model
 */
export function meanPoints(model) {
  const median = model.face();
  const { positions } = median;
  const points = new Float64Array(2 * COUNT);
  for (let i = 0; i < COUNT; i++) {
    const landmark = model.landmarks.find(({ name }) => name === `ibug_${String(i).padStart(2, '0')}`);
    for (const [vertex, weight] of landmark?.stencil ?? []) {
      // The subject's left is on the right of the picture, and y goes down there.
      points[2 * i] += weight * positions[3 * vertex];
      points[2 * i + 1] -= weight * positions[3 * vertex + 1];
    }
  }
  median.free();
  const [left, top, right, bottom] = boxOf(points);
  return points.map((value, i) => (value - (i % 2 ? (top + bottom) / 2 : (left + right) / 2)) / (bottom - top));
}
