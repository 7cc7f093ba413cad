// What a detector's points say of where a face's 68 are.
//
// MediaPipe's points are off, in the mean over people, by up to some mm: a fit that takes them for iBUG's makes that
// a part of everybody's shape, and comes out farther from the person than the mean face is. So the mean error
// is taken off, and the jaw is believed as little as it deserves. Errors were measured on heads of the
// model as the page draws them (tests/browser/detector-bias.js). They are those of photos, too: the points of two
// portraits are met better by a third when the errors are taken off.

import { BIAS, JAW_BIAS, MEAN } from './bias.js';
import { COUNT, INNER_FROM, frameOf, ibugOf, looking } from './points.js';

/**
 * One standard deviation of a jaw point across the outline, mm at the face. They were measured to be off by 2.5; but
 * together, so that one by one they tell less.
 */
const JAW_NOISE = 3.7;

const mean = Array.from({ length: COUNT }, (_, i) => [MEAN[2 * i] / 10, MEAN[2 * i + 1] / 10]);

/**
 * @param {ArrayLike<number>} mesh the detector's 468 points as x, y pairs, px
 * @returns {{ points: Float64Array, jawNoise: number }} the 68 as x, y pairs and the noise of the jaw's, px
 */
export function marksOf(mesh) {
  const points = ibugOf(mesh);
  const { scale, inFrame, inPhoto } = frameOf(points, mean);
  const terms = looking(mean.map((_, i) => inFrame(points[2 * i], points[2 * i + 1])));
  for (let i = 0; i < COUNT; i++) {
    const error = [0, 1].map((axis) =>
      i < INNER_FROM ? JAW_BIAS[2 * i + axis] : terms.reduce((sum, term, t) => sum + term * BIAS[t][2 * (i - INNER_FROM) + axis], 0),
    );
    const [x, y] = inPhoto(error[0] / 100, error[1] / 100);
    points[2 * i] -= x;
    points[2 * i + 1] -= y;
  }
  return { points, jawNoise: JAW_NOISE * scale };
}
