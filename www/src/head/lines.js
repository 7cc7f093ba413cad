import { chance } from '../chance.js';
import { between, points } from '../groundwork/paint.js';
import { BELOW_CHIN } from './folds.js';

// The lines that faces get with the years and for a moment with expressions (see `folds.js`), what sinks and sags beside them,
// and freckles: a relief over the front of the face at rest, from landmarks.

/** Texels a side, of which a line has two to four across. */
const SIZE = 640;
/** What a step of the slopes' bytes is: slopes go from -1 to 1. */
const STEEP = 127;
/** How much darker than its depth alone makes it a line is, where nothing else is said. */
const STAIN = 0.75;

/**
 * A line: points (mm), half its width and its depth (mm); its ends run out, the first by less when it begins in a fold. `stain` is how
 * much darker it is for its depth, `over` on which side (1 is where x grows) the skin hangs over it, `uneven` how much less deep it is in
 * places.
 * @typedef {{ through: number[][], half: number, deep: number, blunt?: boolean, stain?: number, over?: -1 | 1, uneven?: number }} Line
 */

/** Points on a smooth way through some. @param {number[][]} through @param {number} steps between two */
function smoothWay(through, steps = 5) {
  const way = [];
  for (let i = 0; i + 1 < through.length; i++) {
    const [a, b, c, d] = [-1, 0, 1, 2].map((k) => through[Math.min(through.length - 1, Math.max(0, i + k))]);
    for (let s = 0; s < steps; s++) way.push(between(a, b, c, d, s / steps));
  }
  way.push(through[through.length - 1]);
  return way;
}

/**
 * Where faces fold, on both sides.
 * @param {import('../groundwork/paint.js').Points} at landmarks of the face at rest, mm
 * @returns {Line[]}
 */
function linesOf(at) {
  const random = chance(83);
  const some = (/** @type {number} */ size) => size * (2 * random() - 1);
  const p = (/** @type {number} */ i) => points(at, i, i)[0];
  const trichion = at.get('trichion') ?? [0, p(27)[1] + 62, 0];
  /** @type {Line[]} */
  const lines = [];
  // Across the forehead, lower in the middle, from above the brows to below the hairline.
  const bottom = (p(19)[1] + p(24)[1]) / 2 + 11;
  const reach = 0.82 * Math.abs(p(17)[0]);
  const rows = 5;
  for (let n = 0; n < rows; n++) {
    const y = bottom + ((trichion[1] - 9 - bottom) * n) / (rows - 1);
    const wide = reach * (0.72 + 0.28 * Math.sin((Math.PI * (n + 1)) / rows)) + some(3);
    const through = Array.from({ length: 9 }, (_, i) => {
      const t = i / 4 - 1;
      return [wide * t + some(1), y - 2.4 * Math.exp(-((t / 0.3) ** 2)) - 3 * t * t + some(1.1)];
    });
    const deep = 0.32 + some(0.07);
    lines.push({ through, half: 0.85, deep, uneven: 0.5 });
    // Skin that has folded for years rises between its lines.
    lines.push({ through, half: 2.6, deep: 0.9 * deep, stain: 0, uneven: 0.3 });
  }
  for (const [side, eye, brow, wing, lid, upper, lower] of /** @type {const} */ ([
    [-1, 36, 21, 31, [36, 41, 40, 39], [48, 49, 50, 51], [48, 59, 58, 57]],
    [1, 45, 22, 35, [45, 46, 47, 42], [54, 53, 52, 51], [54, 55, 56, 57]],
  ])) {
    // Between the brows.
    const inner = p(brow);
    lines.push({
      through: [[inner[0] * 0.62 + some(0.6), inner[1] - 5], [inner[0] * 0.5 + some(0.6), inner[1] + 3], [inner[0] * 0.6 + some(0.8), inner[1] + 12 + some(2)]],
      half: 0.8,
      deep: 0.34,
    });
    // Beside the eyes.
    const outer = p(eye);
    for (const angle of [42, 17, -9, -34]) {
      const turn = ((angle + some(4)) * Math.PI) / 180;
      const [from, to] = [6 + random() * 2, 19 + random() * 5];
      const bend = angle > 0 ? 0.12 : -0.12;
      const ray = (/** @type {number} */ r) => {
        const a = turn + bend * ((r - from) / 10);
        return [outer[0] + side * r * Math.cos(a) * 0.78, outer[1] - 1 + r * Math.sin(a)];
      };
      lines.push({ through: [ray(from), ray((2 * from + to) / 3), ray((from + 2 * to) / 3), ray(to)], half: 0.6, deep: 0.26 });
    }
    // Down the cheeks, from below those: finer.
    for (let n = 0; n < 4; n++) {
      const [x, y] = [outer[0] + side * (1 - 5 * n + some(1)), outer[1] - 15 - 1.5 * n + some(1.5)];
      lines.push({ through: [[x, y], [x + side * (2.5 + some(0.6)), y - 9], [x + side * (1.5 + some(0.8)), y - 19 - 6 * random()]], half: 0.7, deep: 0.09 });
    }
    // Below the lids: the fold of the lid, and the bag's lower edge.
    const under = lid.map(p);
    for (const [below, deep] of [[5.5, 0.16], [10.5, 0.26]]) {
      lines.push({
        through: under.map(([x, y], i) => [x - side * (i === 3 ? 1.5 : 0), y - below * [0.45, 1, 1.05, 0.62][i] + some(0.4)]),
        // A bag ends in a soft step, and in no line.
        half: below > 8 ? 2.3 : 0.7,
        deep,
        stain: below > 8 ? 0.3 : STAIN,
      });
    }
    // From the wing of the nose around the mouth, and from its corner down.
    const [nose, mouth] = [p(wing), p(upper[0])];
    const chin = p(8);
    lines.push({
      through: [
        [nose[0] + side * 4.5, nose[1] + 7],
        [nose[0] + side * 9.5, nose[1] - 2],
        [mouth[0] + side * 6.5, mouth[1] + 7],
        [mouth[0] + side * 9, mouth[1] - 4],
      ],
      half: 1.7,
      deep: 0.85,
      blunt: true,
      over: side,
    });
    lines.push({
      through: [
        [mouth[0] + side * 1.5, mouth[1] - 2.5],
        [mouth[0] + side * 4.5, mouth[1] - 9],
        [mouth[0] + side * 7.5, mouth[1] + 0.45 * (chin[1] - mouth[1])],
      ],
      half: 1.7,
      deep: 0.36,
    });
    // Up and down from the lips.
    for (const [edge, way, many] of /** @type {const} */ ([[upper, 1, 4], [lower, -1, 3]])) {
      const border = smoothWay(edge.map(p));
      for (let n = 0; n < many; n++) {
        const [x, y] = border[Math.round(((n + 0.9 + some(0.25)) / (many + 0.6)) * (border.length - 1))];
        lines.push({
          through: [[x, y - way * 0.6], [x + some(0.5), y + way * 3], [x + side * 0.8 + some(0.6), y + way * (5 + 2.5 * random())]],
          half: 0.45,
          deep: 0.13,
          blunt: true,
        });
      }
    }
  }
  // Around the neck.
  for (const [n, down] of [17, 27, 38].entries()) {
    lines.push({
      through: [-1, -0.6, -0.2, 0.2, 0.6, 1].map((t) => [(46 - 3 * n) * t + some(2), p(8)[1] - down - 3 * (1 - t * t) + some(0.9)]),
      half: 1.1,
      deep: 0.3,
      uneven: 0.5,
    });
  }
  // Below the lower lip.
  const [lip, chin] = [p(57), p(8)];
  lines.push({
    through: [-1, -0.5, 0, 0.5, 1].map((t) => [15 * t, lip[1] - 0.3 * (lip[1] - chin[1]) - 2.5 * t * t + some(0.5)]),
    half: 1.5,
    deep: 0.4,
  });
  return lines;
}

/**
 * What sinks and sags with the years, on both sides: the middle, half the width and height, and how far it stands out, mm.
 * @param {import('../groundwork/paint.js').Points} at landmarks of the face at rest, mm
 * @returns {{ middle: number[], half: number[], high: number, turn?: number }[]}
 */
function formsOf(at) {
  const p = (/** @type {number} */ i) => points(at, i, i)[0];
  const chin = p(8);
  return /** @type {const} */ ([[-1, 36, 39, 41, 40, 31, 48], [1, 45, 42, 46, 47, 35, 54]]).flatMap(([side, outer, inner, ...rest]) => {
    const [lidOut, lidIn, wing, mouth] = rest.map(p);
    const [far, near] = [p(outer), p(inner)];
    const across = Math.abs(far[0] - near[0]);
    return [
      // The bag below the eye.
      { middle: [(lidOut[0] + lidIn[0]) / 2, (lidOut[1] + lidIn[1]) / 2 - 6.5], half: [0.42 * across, 3.6], high: 1.9, turn: side * 0.1 },
      // Above the fold from the nose to the mouth the cheek hangs over.
      { middle: [0.5 * (wing[0] + mouth[0]) + side * 14, 0.5 * (wing[1] + mouth[1]) + 4], half: [7, 12], high: 3, turn: -side * 0.5 },
      // Below the cheekbone it is hollow.
      { middle: [far[0] + side * 6, 0.4 * wing[1] + 0.6 * mouth[1]], half: [13, 18], high: -2.6, turn: side * 0.35 },
      // The jowl, and the hollow between it and the chin.
      { middle: [mouth[0] + side * 13, 0.3 * mouth[1] + 0.7 * chin[1]], half: [9, 11], high: 2.9 },
      { middle: [mouth[0] - side * 3, 0.12 * mouth[1] + 0.88 * chin[1]], half: [5, 8], high: -2.2 },
      // The bands of the neck, and the hollow between them.
      { middle: [side * 13, chin[1] - 34], half: [3.2, 19], high: 2.6, turn: side * 0.12 },
      { middle: [side * 2.5, chin[1] - 34], half: [5, 15], high: -1.2 },
      // The temple.
      { middle: [far[0] + side * 12, far[1] + 20], half: [9, 14], high: -3 },
    ];
  });
}

/**
 * Red and green: how the relief rises to the right and up, from -1 to 1 as 0 to 255. Blue: how deep in a line it is.
 * Alpha: freckles.
 *
 * @param {import('../groundwork/paint.js').Points} at landmarks of the face at rest, mm
 * @returns {{ map: import('../rendering/textures.js').Pixels, frame: [number, number, number, number] }} `frame` is the lower left
 *   corner and the size of the map, mm
 */
export function paintLines(at) {
  const [chin] = points(at, 8, 8);
  const frame = /** @type {[number, number, number, number]} */ ([-125, chin[1] - BELOW_CHIN, 250, 250]);
  const texel = frame[2] / SIZE;
  const height = new Float32Array(SIZE * SIZE);
  const groove = new Float32Array(SIZE * SIZE);
  /** @param {number} value mm along an axis @param {number} k the axis */
  const texelAt = (value, k) => Math.min(SIZE - 1, Math.max(0, Math.round((value - frame[k]) / texel)));
  const random = chance(29);
  for (const { through, half, deep, blunt, stain = STAIN, over = 0, uneven = 0 } of linesOf(at)) {
    const way = smoothWay(through);
    const [first, second] = [6.3 * random(), 6.3 * random()];
    const flat = Float64Array.from(way.flat());
    const far = 4.5 * half;
    const [left, right, low, high] = [0, 1].flatMap((k) => {
      const all = way.map((point) => point[k]);
      return [texelAt(Math.min(...all) - far, k), texelAt(Math.max(...all) + far, k)];
    });
    for (let j = low; j <= high; j++) {
      for (let i = left; i <= right; i++) {
        const x = frame[0] + (i + 0.5) * texel;
        const y = frame[1] + (j + 0.5) * texel;
        let nearest = Infinity;
        let place = 0;
        let beside = 0;
        for (let s = 0; s + 1 < way.length; s++) {
          const ax = x - flat[2 * s];
          const ay = y - flat[2 * s + 1];
          const ex = flat[2 * s + 2] - flat[2 * s];
          const ey = flat[2 * s + 3] - flat[2 * s + 1];
          const t = Math.min(1, Math.max(0, (ax * ex + ay * ey) / (ex * ex + ey * ey)));
          const away = (ax - ex * t) * (ax - ex * t) + (ay - ey * t) * (ay - ey * t);
          if (away < nearest) {
            nearest = away;
            place = (s + t) / (way.length - 1);
            beside = ex * ay - ey * ax > 0 ? over : -over;
          }
        }
        // It runs out at its ends.
        const whole = Math.min(1, (blunt ? 12 : 3.5) * place + (blunt ? 0.3 : 0), 3 * (1 - place));
        const full = whole * (1 - uneven * (0.5 + 0.25 * (Math.sin(19 * place + first) + Math.sin(31 * place + second))));
        if (full <= 0 || nearest > far * far) continue;
        const across = nearest / (half * half);
        const down = Math.exp(-across);
        // Skin that a line takes in stands beside it.
        height[j * SIZE + i] += full * deep * (0.3 * (1 + beside * (1 - down)) * Math.exp(-across / 6) - down);
        groove[j * SIZE + i] = Math.max(groove[j * SIZE + i], full * stain * Math.min(1, deep / 0.4) * down);
      }
    }
  }
  for (const { middle, half, high, turn = 0 } of formsOf(at)) {
    const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
    const far = 2.6 * Math.max(...half);
    const [left, right, bottom, top] = [0, 1].flatMap((k) => [texelAt(middle[k] - far, k), texelAt(middle[k] + far, k)]);
    for (let j = bottom; j <= top; j++) {
      for (let i = left; i <= right; i++) {
        const [x, y] = [frame[0] + (i + 0.5) * texel - middle[0], frame[1] + (j + 0.5) * texel - middle[1]];
        const [u, v] = [(x * cos + y * sin) / half[0], (y * cos - x * sin) / half[1]];
        height[j * SIZE + i] += high * Math.exp(-u * u - v * v);
      }
    }
  }
  const freckles = paintFreckles(at, frame);
  const rgba = new Uint8Array(4 * SIZE * SIZE);
  const byte = (/** @type {number} */ slope) => Math.min(255, Math.max(0, Math.round(127.5 + STEEP * slope)));
  for (let j = 0; j < SIZE; j++) {
    for (let i = 0; i < SIZE; i++) {
      const o = j * SIZE + i;
      const beside = (/** @type {number} */ step, /** @type {boolean} */ inside) => (inside ? height[o + step] : height[o]);
      rgba[4 * o] = byte((beside(1, i < SIZE - 1) - beside(-1, i > 0)) / (2 * texel));
      rgba[4 * o + 1] = byte((beside(SIZE, j < SIZE - 1) - beside(-SIZE, j > 0)) / (2 * texel));
      rgba[4 * o + 2] = 255 * groove[o];
      rgba[4 * o + 3] = 255 * freckles[o];
    }
  }
  return { map: { size: SIZE, rgba }, frame };
}

/**
 * Most are on the nose and below the eyes.
 * @param {import('../groundwork/paint.js').Points} at @param {number[]} frame
 */
function paintFreckles(at, [left, low, size]) {
  const random = chance(91);
  const spots = new Float32Array(SIZE * SIZE);
  const texel = size / SIZE;
  const [tip] = points(at, 30, 30);
  const eyes = [points(at, 36, 41), points(at, 42, 47)].map((eye) => [0, 1].map((k) => eye.reduce((sum, point) => sum + point[k], 0) / eye.length));
  const cheeks = eyes.map(([x, y]) => [x * 1.15, 0.45 * y + 0.55 * tip[1]]);
  for (let n = 0; n < 5600; n++) {
    const [x, y] = [left + size * random(), low + size * random()];
    const near = (/** @type {number[]} */ [cx, cy], /** @type {number} */ rx, /** @type {number} */ ry) => Math.exp(-(((x - cx) / rx) ** 2) - ((y - cy) / ry) ** 2);
    const likely = 0.07 + 0.9 * Math.min(1, near([0, tip[1] + 9], 14, 17) + cheeks.reduce((sum, cheek) => sum + near(cheek, 22, 14), 0));
    const [wide, round, dark, turn] = [0.35 + 0.55 * random() ** 2, 0.7 + 0.6 * random(), 0.35 + 0.65 * random(), Math.PI * random()];
    if (random() > likely) continue;
    const [i0, j0] = [(x - left) / texel, (y - low) / texel];
    const far = Math.ceil((2.2 * wide * 1.3) / texel);
    for (let j = Math.max(0, Math.floor(j0) - far); j <= Math.min(SIZE - 1, j0 + far); j++) {
      for (let i = Math.max(0, Math.floor(i0) - far); i <= Math.min(SIZE - 1, i0 + far); i++) {
        const [dx, dy] = [(i + 0.5 - i0) * texel, (j + 0.5 - j0) * texel];
        const [u, v] = [(dx * Math.cos(turn) + dy * Math.sin(turn)) / wide, (dy * Math.cos(turn) - dx * Math.sin(turn)) / (wide * round)];
        spots[j * SIZE + i] = Math.max(spots[j * SIZE + i], dark * Math.exp(-((u * u + v * v) ** 1.5)));
      }
    }
  }
  return spots;
}
