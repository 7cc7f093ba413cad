// What a mirror makes of a model's faces, in their coefficients. A mode is its own mirror image, or the opposite of it, or one of two that are each
// other's; which of these is found on the model's own vertices, once.

import { readColouring, whole } from '../head/colouring.js';
import { encodeMarks, marksOf, mirrorMarks, skinTriangles } from '../head/marks.js';

/** Every so many vertices of the features are looked at. */
const APART = 4;
/** Images are told by their directions: modes are rounded to some hundredths of a mm. */
const ALIKE = 0.99;

/**
 * @typedef {{
 *   image: (coefficients: ArrayLike<number>) => Float32Array,
 *   withSides: (coefficients: Float32Array, times: number) => Float32Array,
 *   differ: (coefficients: ArrayLike<number>) => number,
 * }} Mirror
 * `image` is the mirror image of a face, `withSides` a face whose two sides differ so many times as much, `differ` by how much they do: the
 * distance of a spot on a feature from the mirror image of its counterpart, mm RMS.
 */

/**
 * @param {import('phiz').FaceModel} model
 * @param {() => Promise<void>} pause awaited between small parts of the work
 * @returns {Promise<Mirror | null>} null for a model that knows sides apart
 */
export async function mirrorOf(model, pause) {
  const probe = model.face();
  try {
    const { mirror, regionOf, regionGroups } = model;
    /** Pairs of images. @type {number[]} */
    const seen = [];
    for (let v = 0; v < model.vertexCount; v++) {
      const other = mirror[v];
      if (regionGroups[regionOf[v]] !== null && other >= v && v % APART === 0) seen.push(v, other);
    }
    const none = new Float32Array(probe.coefficients.length);
    probe.coefficients = none;
    const rest = probe.positions.slice();
    /** How a coefficient moves these. @type {Float32Array[]} */
    const fields = [];
    for (const k of none.keys()) {
      await pause();
      const one = none.slice();
      one[k] = 1;
      probe.coefficients = one;
      const { positions } = probe;
      fields.push(Float32Array.from({ length: 3 * seen.length }, (_, i) => positions[3 * seen[(i / 3) | 0] + (i % 3)] - rest[3 * seen[(i / 3) | 0] + (i % 3)]));
    }
    const images = fields.map((field) => field.map((_, i) => (i % 3 === 0 ? -1 : 1) * field[3 * (((i / 3) | 0) ^ 1) + (i % 3)]));
    const dot = (/** @type {Float32Array} */ a, /** @type {Float32Array} */ b) => a.reduce((sum, x, i) => sum + x * b[i], 0);

    /** Of each coefficient which one it is in the mirror, and with which sign. @type {[number, number][]} */
    const twins = [];
    for (const [k, field] of fields.entries()) {
      await pause();
      const length = dot(field, field);
      const own = dot(field, images[k]) / length;
      const isTwin = (/** @type {number} */ j) => j !== k && dot(images[k], fields[j]) / Math.sqrt(length * dot(fields[j], fields[j])) > ALIKE;
      const twin = Math.abs(own) > ALIKE ? k : fields.findIndex((_, j) => isTwin(j));
      if (twin < 0) return null;
      twins.push([twin, twin === k ? Math.sign(own) : 1]);
    }
    const image = (/** @type {ArrayLike<number>} */ coefficients) => Float32Array.from(twins, ([twin, sign]) => sign * coefficients[twin]);

    // Half of what a face and its image differ by is odd: of these coefficients the lengths are known from their products.
    const odd = [...none.keys()].filter((k) => twins[k][0] !== k || twins[k][1] < 0);
    /** @type {number[][]} */
    const products = [];
    for (const a of odd) {
      await pause();
      products.push(odd.map((b) => dot(fields[a], fields[b]) / seen.length));
    }
    /** By how much a coefficient and that of the image differ. */
    const unlike = (/** @type {ArrayLike<number>} */ coefficients, /** @type {number} */ k) => coefficients[k] - twins[k][1] * coefficients[twins[k][0]];
    return {
      image,
      withSides: (coefficients, times) => coefficients.map((own, k) => own + ((times - 1) * unlike(coefficients, k)) / 2),
      differ(coefficients) {
        // A slider shows it with every event of a drag: these are plain loops.
        const parts = Float64Array.from(odd, (k) => unlike(coefficients, k));
        let sum = 0;
        for (let i = 0; i < parts.length; i++) {
          const row = products[i];
          let along = 0;
          for (let j = 0; j < parts.length; j++) along += parts[j] * row[j];
          sum += parts[i] * along;
        }
        return Math.sqrt(Math.max(0, sum));
      },
    };
  } finally {
    probe.free();
  }
}

/**
 * An expression in the mirror.
 * @param {Readonly<Record<string, number>>} weights
 */
export function mirroredExpression(weights) {
  const other = (/** @type {string} */ name) => name.replace(/(Left|Right)$/, (side) => (side === 'Left' ? 'Right' : 'Left'));
  return Object.fromEntries(Object.entries(weights).map(([name, weight]) => [other(name), weight]));
}

/**
 * Looks in the mirror: hair is parted on the other side, where marks of the skin are as well.
 * @param {import('../head/colouring.js').Colouring} colouring
 * @param {import('phiz').FaceModel} model
 * @returns {import('../head/colouring.js').Colouring}
 */
export function mirroredColouring(colouring, model) {
  const marks = colouring.marks && encodeMarks(mirrorMarks(skinTriangles(model), model.mirror)(marksOf(colouring)));
  return readColouring({ ...colouring, parting: 1 - whole(colouring).parting, marks });
}
