import { BELOW } from '../hair/browline.js';
import { mean } from './detected.js';
import { frameOf } from './points.js';

/** The points on both brows, from the nose outwards. */
const BROWS = [
  [21, 20, 19, 18, 17],
  [22, 23, 24, 25, 26],
];

/**
 * How far from the model's 68 points people mark them: brows on their hair, which is below; all else where it is.
 * @param {Float64Array} points as x, y pairs, px
 * @returns {Float64Array} as many, px
 */
export function onHair(points) {
  const { inPhoto } = frameOf(points, mean);
  const off = new Float64Array(points.length);
  for (const brow of BROWS) brow.forEach((point, i) => off.set(inPhoto(0, BELOW[i]), 2 * point));
  return off;
}
