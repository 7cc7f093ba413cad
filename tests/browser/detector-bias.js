// Learns how far MediaPipe's face mesh puts the 68 points from where the model has them, and writes it down as
// www/src/photo/bias.js:
//
//     node tests/browser/detected-heads.js 420 1 target/heads.json
//     node tests/browser/detector-bias.js target/heads.json
//
// A detector is off in the same way on everybody: its points are others than iBUG's, and it has seen people
// from some sides more often than from others. So the mean error of each point is a polynomial of where the head
// looks, least squares over the heads and their mirror images. And it takes people for more alike than they are, and
// puts points where others make it expect them: what is left of the error is linear in how far all inner
// points are from where a head that looks there has them, by ridge regression. All is in the frame of the face: points
// and errors are turned and scaled so that the inner 51 lie on those of the mean head, mm.

import { readFile, writeFile } from 'node:fs/promises';
import { load } from '../../pkg/index.js';
import { COUNT, INNER_FROM, expectedError, frameOf, ibugOf, less, looking, mapped, size } from '../../www/src/photo/points.js';

const file = process.argv[2];
if (!file) {
  console.error('usage: node tests/browser/detector-bias.js HEADS.json');
  process.exit(2);
}
const read = (/** @type {string} */ path) => readFile(new URL(`../../www/public/${path}`, import.meta.url));
const model = await load(await read('model.phiz'));
await model.loadExpressions(await read('expressions.phiz'));

/** The points on the other side. */
const MIRROR = Array.from({ length: COUNT }, (_, i) => i);
for (const run of [
  [0, 16], [17, 26], [31, 35], [48, 54], [55, 59], [60, 64], [65, 67],
]) for (let i = run[0]; i <= run[1]; i++) MIRROR[i] = run[0] + run[1] - i;
for (const [right, left] of [[36, 45], [37, 44], [38, 43], [39, 42], [40, 47], [41, 46]]) [MIRROR[right], MIRROR[left]] = [left, right];
const mirrored = (/** @type {number[][]} */ points) => MIRROR.map((i) => [-points[i][0], points[i][1]]);

const stencils = Array.from({ length: COUNT }, (_, i) => model.landmarks.find(({ name }) => name === `ibug_${String(i).padStart(2, '0')}`).stencil);
const placed = (/** @type {Float32Array} */ positions) => stencils.map((stencil) => [0, 1, 2].map((axis) => stencil.reduce((sum, [v, w]) => sum + w * positions[3 * v + axis], 0)));
const median = model.face();
const right = placed(median.positions).map(([x, y]) => [x, -y]);
const middle = [0, 1].map((axis) => right.slice(INNER_FROM).reduce((sum, p) => sum + p[axis], 0) / (COUNT - INNER_FROM));
const other = mirrored(right.map(([x, y]) => [x - middle[0], y - middle[1]]));
const mean = right.map(([x, y], i) => [(x - middle[0] + other[i][0]) / 2, (y - middle[1] + other[i][1]) / 2].map((mm) => Math.round(10 * mm) / 10));

/** @type {{ terms: number[], found: number[], errors: number[] }[]} */
const rows = [];
for (const { code, expression, camera, points } of JSON.parse(await readFile(file, 'utf8'))) {
  const face = model.fromCode(code);
  face.expression = expression;
  const truth = placed(face.positions).map(([x, y, z]) => {
    const [u, v, w] = [0, 4, 8].map((at) => camera[at] * x + camera[at + 1] * y + camera[at + 2] * z + camera[at + 3]);
    return [u / w, v / w];
  });
  face.free();
  const seen = ibugOf(points);
  const { inFrame } = frameOf(seen, mean);
  const found = Array.from({ length: COUNT }, (_, i) => inFrame(seen[2 * i], seen[2 * i + 1]));
  const there = truth.map(([x, y]) => inFrame(x, y));
  for (const [a, b] of [[found, there], [mirrored(found), mirrored(there)]]) {
    rows.push({ terms: looking(a), found: a.slice(INNER_FROM).flat(), errors: a.flatMap(([x, y], i) => [x - b[i][0], y - b[i][1]]) });
  }
}

/** The solution of a small linear system, by elimination with pivots. @param {number[][]} a rows with their right sides */
function solved(a) {
  for (let i = 0; i < a.length; i++) {
    const best = a.reduce((most, row, r) => (r >= i && Math.abs(row[i]) > Math.abs(a[most][i]) ? r : most), i);
    [a[i], a[best]] = [a[best], a[i]];
    for (let r = 0; r < a.length; r++) {
      if (r === i) continue;
      const factor = a[r][i] / a[i][i];
      for (let c = i; c < a[r].length; c++) a[r][c] -= factor * a[i][c];
    }
  }
  return a.map((row, i) => row.slice(a.length).map((value) => value / row[i]));
}

/** Least squares of some numbers of each row on others, which are held to 0 by `ridge` a row. @param {number[][]} of @param {number[][]} to @param {number} [ridge] */
const leastSquares = (of, to, ridge = 0) =>
  solved(
    of[0].map((_, a) => [
      ...of[0].map((_, b) => of.reduce((sum, row) => sum + row[a] * row[b], a === b ? ridge * of.length : 0)),
      ...to[0].map((_, e) => of.reduce((sum, row, i) => sum + row[a] * to[i][e], 0)),
    ]),
  );
const inner = (/** @type {number[]} */ of) => of.slice(2 * INNER_FROM);

/**
 * Holds what is learned of errors to 0, mm^2: with a tenth of it errors are smaller by a fiftieth, on heads of the
 * model, and what no head has is made three times as large.
 */
const RIDGE = 1;

/** What is learned from heads. @param {typeof rows} of @returns {import('../../www/src/photo/points.js').Known} */
function learned(of) {
  const terms = of.map((row) => row.terms);
  const usual = leastSquares(terms, of.map(({ found }) => found));
  const bias = leastSquares(terms, of.map(({ errors }) => inner(errors)));
  const unusual = of.map(({ terms, found }) => less(found, mapped(terms, usual)));
  const rest = of.map(({ terms, errors }) => less(inner(errors), mapped(terms, bias)));
  const most = unusual.map(size).sort((a, b) => a - b)[Math.floor(0.95 * of.length)];
  return { usual, bias, drawn: leastSquares(unusual, rest, RIDGE), most };
}

/** Root mean square a axis, mm, of what is left of the inner points. @param {typeof rows} of @param {(row: (typeof rows)[0]) => number[]} taken */
const left = (of, taken) => size(of.flatMap((row) => less(inner(row.errors), taken(row))));
const folds = [0, 1, 2, 3, 4].map((fold) => {
  const held = (/** @type {number} */ i) => (i >> 1) % 5 === fold;
  const by = learned(rows.filter((_, i) => !held(i)));
  const others = rows.filter((_, i) => held(i));
  return [left(others, ({ terms }) => mapped(terms, by.bias)), left(others, (row) => expectedError(row, by))];
});
// Of the jaw only from heads that are seen from the front: elsewhere its points are on the outline.
const front = rows.filter(({ terms }) => Math.abs(terms[1]) < 0.5);
const jaw = Array.from({ length: INNER_FROM }, (_, i) => [0, 1].map((axis) => front.reduce((sum, { errors }) => sum + errors[2 * i + axis], 0) / front.length));
let [across, count] = [0, 0];
for (let i = 0; i < INNER_FROM; i++) {
  const along = [0, 1].map((axis) => mean[Math.min(i + 1, INNER_FROM - 1)][axis] - mean[Math.max(i - 1, 0)][axis]);
  const length = Math.hypot(...along);
  for (const { errors } of front) {
    across += ((errors[2 * i] - jaw[i][0]) * along[1] - (errors[2 * i + 1] - jaw[i][1]) * along[0]) ** 2 / length ** 2;
    count += 1;
  }
}
const { usual, bias, drawn, most } = learned(rows);
const hundredths = (/** @type {number[]} */ row) => row.map((mm) => Math.round(100 * mm));
const lines = (/** @type {number[]} */ numbers) => numbers.join(', ').replace(/(.{1,116})(, |$)/g, '  $1,\n').replaceAll(',,', ',');
await writeFile(
  new URL('../../www/src/photo/bias.js', import.meta.url),
  `// Made by tests/browser/detector-bias.js, which says what it is, from ${rows.length / 2} heads. All of it is in the frame of
// the face: x to the subject's left, y down, 0 the middle of the inner 51 points of the mean head.

/** The 68 points of the mean head, x and y, tenths of a mm. */
export const MEAN = [
${lines(mean.flat().map((mm) => Math.round(10 * mm)))}];

/** Where the inner 51 are seen, x and y, hundredths of a mm, for each term of \`looking\`. */
export const USUAL = [
${usual.map((row) => `  [\n${lines(hundredths(row))}  ],`).join('\n')}
];

/** By how much they are off in the mean, in the same way. */
export const BIAS = [
${bias.map((row) => `  [\n${lines(hundredths(row))}  ],`).join('\n')}
];

/** By how much more for each number, x or y, of a point that is not where it is usual: hundredths. */
export const DRAWN = [
${drawn.map((row) => `  [\n${lines(hundredths(row))}  ],`).join('\n')}
];

/** The root mean square of these numbers that one head in twenty is above, mm. */
export const MOST = ${most.toFixed(2)};

/** The jaw's 17, of a head that looks into the camera. */
export const JAW_BIAS = [
${lines(hundredths(jaw.flat()))}];
`,
);
const [held, all] = [0, 1].map((k) => folds.reduce((sum, fold) => sum + fold[k], 0) / 5);
console.log(`${rows.length / 2} heads; the inner points are off by ${left(rows, ({ errors }) => inner(errors).map(() => 0)).toFixed(2)} mm a axis, on heads it was not learned from by ${held.toFixed(2)} once the mean error is taken off, and by ${all.toFixed(2)} once all is; the jaw's across by ${Math.sqrt(across / count).toFixed(2)}`);
