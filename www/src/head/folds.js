import { points, smoothstep } from '../groundwork/paint.js';

// Where expressions fold a face, and how much.

/** How far the map of lines goes on below the chin, mm: to where the neck is seen no more. */
export const BELOW_CHIN = 62;

/** Which lines an expression folds: across the forehead, between the brows, about the eyes, from the nose around the mouth. */
const FOLDS = [
  { browInnerUp: 0.9, browOuterUp: 0.8 },
  { browDown: 1, noseSneer: 0.4 },
  { cheekSquint: 0.8, eyeSquint: 0.6, mouthSmile: 0.7, noseSneer: 0.3 },
  { mouthSmile: 0.6, noseSneer: 0.8, mouthUpperUp: 0.5, mouthDimple: 0.5, mouthStretch: 0.4 },
];
/** A smile smooths what hangs below the corners of the mouth. */
const SMOOTHS = 'mouthSmile';

/**
 * How much an expression folds a side of the face, as `FOLDS` has it, and how much it smooths below the mouth.
 * @param {Readonly<Record<string, number>>} expression weights by ARKit's names
 * @param {'Left' | 'Right'} side the subject's
 */
export function foldsOf(expression, side) {
  const weight = (/** @type {string} */ name) => Math.min(1, expression[name] ?? expression[name + side] ?? 0);
  return {
    folds: FOLDS.map((by) => Object.entries(by).reduce((most, [name, part]) => Math.max(most, part * weight(name)), 0)),
    smooths: weight(SMOOTHS),
  };
}

/**
 * How much of each vertex is where each of `FOLDS` is, 0 to 1; less than nothing of the last is below the mouth.
 * @param {Float32Array} rest 3 a vertex, mm
 * @param {import('../groundwork/paint.js').Points} at landmarks
 */
export function foldingOf(rest, at) {
  const p = (/** @type {number} */ i) => points(at, i, i)[0];
  const folding = new Float32Array((4 * rest.length) / 3);
  if (![8, 19, 31, 36, 39, 48].every(p)) return folding;
  const [brow, eye, wing, corner, inner] = [p(19)[1], (p(36)[1] + p(39)[1]) / 2, p(31)[1], p(48)[1], Math.abs(p(39)[0])];
  const within = (/** @type {number} */ x, /** @type {number} */ low, /** @type {number} */ high, /** @type {number} */ soft) => smoothstep(low - soft, low + soft, x) * (1 - smoothstep(high - soft, high + soft, x));
  for (let v = 0; v < rest.length / 3; v++) {
    const [x, y] = [Math.abs(rest[3 * v]), rest[3 * v + 1]];
    const frown = (1 - smoothstep(9, 17, x)) * within(y, brow - 10, brow + 13, 4);
    folding.set([smoothstep(brow + 3, brow + 11, y) * (1 - frown), frown, smoothstep(inner - 6, inner, x) * within(y, eye - 26, eye + 11, 5), (1 - smoothstep(wing + 7, wing + 13, y)) * smoothstep(corner - 3, corner + 4, y) - (1 - smoothstep(corner - 6, corner, y))], 4 * v);
  }
  return folding;
}
