// What a detector's points say of where a face's 68 are.
//
// MediaPipe's points are off, in the mean over people, by up to some mm: a fit that takes them for iBUG's makes that
// a part of everybody's shape, and comes out farther from the person than the mean face is. And it sees people more alike
// than they are. So what error is expected of points is taken off, and the jaw is believed as little as it deserves. Errors
// were measured on heads of the model as the page draws them (tests/browser/detector-bias.js).

import { BIAS, DRAWN, JAW_BIAS, MEAN, MOST, USUAL } from './bias.js';
import { COUNT, INNER_FROM, expectedError, frameOf, ibugOf, irisesOf, looking } from './points.js';

/**
 * One standard deviation of a jaw point across the outline, mm at the face. They were measured to be off by 2.2; but
 * together, so that one by one they tell less.
 */
const JAW_NOISE = 6;
/** One of another point along each axis, mm: measured, on heads that nothing was learned from, 1.3. */
const NOISE = 1.2;

const inMillimetres = (/** @type {number[][]} */ rows) => rows.map((row) => row.map((value) => value / 100));
const known = { usual: inMillimetres(USUAL), bias: inMillimetres(BIAS), drawn: inMillimetres(DRAWN), most: MOST };
/** The 68 points of the mean head, x and y, mm. */
export const mean = Array.from({ length: COUNT }, (_, i) => [MEAN[2 * i] / 10, MEAN[2 * i + 1] / 10]);

/**
 * @param {ArrayLike<number>} mesh the detector's points as x, y pairs, px
 * @returns {{ points: Float64Array, noise: number, jawNoise: number, irises: Float64Array | undefined }} the 68 as x, y pairs, their
 *   noise and that of the jaw's, and the middles of the irises, px
 */
export function marksOf(mesh) {
  const points = ibugOf(mesh);
  const { scale, inFrame, inPhoto } = frameOf(points, mean);
  const found = mean.map((_, i) => inFrame(points[2 * i], points[2 * i + 1]));
  const expected = expectedError({ terms: looking(found), found: found.slice(INNER_FROM).flat() }, known);
  const errors = [...JAW_BIAS.map((value) => value / 100), ...expected];
  for (let i = 0; i < COUNT; i++) {
    const [x, y] = inPhoto(errors[2 * i], errors[2 * i + 1]);
    points[2 * i] -= x;
    points[2 * i + 1] -= y;
  }
  return { points, noise: NOISE * scale, jawNoise: JAW_NOISE * scale, irises: irisesOf(mesh) };
}
