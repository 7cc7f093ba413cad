import { chance } from '../chance.js';
import { smoothstep } from '../groundwork/paint.js';
import { browLine, movedBrow, movesOf, turnOfBrow } from './browform.js';
import { browLines, growBrows } from './browline.js';
import { clamp, norm } from './hull.js';
import { ANCHORS, POINTS } from './strands.js';

// Brows as strands: short hairs that lie close to the skin, each of which goes with the skin at its root.

/** Of each brow, at most. */
const HAIRS = 800;
/** How far a brow's hairs grow and reach from the model's own line, mm, whatever form they have. */
const AROUND = 24;
/** How much longer the hairs of broader brows are: as a power of how much broader. */
const LONGER = 0.4;
/** No triangle there is larger, mm. */
const LARGE = 20;
/** Between points at which the skin is known, mm. */
const STEP = 0.7;

/**
 * The skin around a line as it is seen from the front: how far forward it is, and which triangle is there.
 * @param {number[][]} line
 * @param {import('./plant.js').Skin} skin
 */
function reliefAround(line, { positions, normals, triangles }) {
  const [left, low] = [0, 1].map((k) => Math.min(...line.map((point) => point[k])) - AROUND);
  const [right, high] = [0, 1].map((k) => Math.max(...line.map((point) => point[k])) + AROUND);
  const deepest = Math.min(...line.map((point) => point[2])) - AROUND;
  const [columns, rows] = [Math.ceil((right - left) / STEP) + 1, Math.ceil((high - low) / STEP) + 1];
  const forward = new Float32Array(columns * rows).fill(deepest);
  const of = new Int32Array(columns * rows).fill(-1);
  /** @param {number} t @param {number} x @param {number} y */
  function weightsAt(t, x, y) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const [ux, uy, vx, vy] = [positions[b] - positions[a], positions[b + 1] - positions[a + 1], positions[c] - positions[a], positions[c + 1] - positions[a + 1]];
    const area = ux * vy - uy * vx;
    const [px, py] = [x - positions[a], y - positions[a + 1]];
    const [v, w] = [(px * vy - py * vx) / area, (ux * py - uy * px) / area];
    return [1 - v - w, v, w];
  }
  for (let t = 0; t < triangles.length; t += 3) {
    const [x, y] = [positions[3 * triangles[t]], positions[3 * triangles[t] + 1]];
    if (x < left - LARGE || x > right + LARGE || y < low - LARGE || y > high + LARGE) continue;
    const corners = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const xs = corners.map((o) => positions[o]);
    const ys = corners.map((o) => positions[o + 1]);
    if (corners.some((o) => normals[o + 2] < 0.1)) continue;
    for (let j = Math.max(0, Math.ceil((Math.min(...ys) - low) / STEP)); j <= Math.min(rows - 1, (Math.max(...ys) - low) / STEP); j++) {
      for (let i = Math.max(0, Math.ceil((Math.min(...xs) - left) / STEP)); i <= Math.min(columns - 1, (Math.max(...xs) - left) / STEP); i++) {
        const weights = weightsAt(t, left + i * STEP, low + j * STEP);
        if (weights.some((weight) => weight < -1e-6)) continue;
        const z = weights.reduce((sum, weight, k) => sum + weight * positions[corners[k] + 2], 0);
        if (z <= forward[j * columns + i]) continue;
        forward[j * columns + i] = z;
        of[j * columns + i] = t;
      }
    }
  }
  const column = (/** @type {number} */ x) => clamp((x - left) / STEP, 0, columns - 1.001);
  const row = (/** @type {number} */ y) => clamp((y - low) / STEP, 0, rows - 1.001);
  /** @param {number} x @param {number} y */
  function z(x, y) {
    const [i, j] = [column(x), row(y)];
    const o = Math.floor(j) * columns + Math.floor(i);
    const [u, v] = [i % 1, j % 1];
    return (forward[o] * (1 - u) + forward[o + 1] * u) * (1 - v) + (forward[o + columns] * (1 - u) + forward[o + columns + 1] * u) * v;
  }
  return {
    z,
    /** The way out of the skin. @param {number} x @param {number} y */
    out(x, y) {
      const [across, up] = [(z(x + 1, y) - z(x - 1, y)) / 2, (z(x, y + 1) - z(x, y - 1)) / 2];
      const length = norm(across, up, 1);
      return [-across / length, -up / length, 1 / length];
    },
    /** The triangle at a place, and how much of each of its corners is there; null beside the head. @param {number} x @param {number} y */
    bind(x, y) {
      const t = of[Math.round(row(y)) * columns + Math.round(column(x))];
      return t < 0 ? null : { corners: [triangles[t], triangles[t + 1], triangles[t + 2]], weights: weightsAt(t, x, y) };
    },
  };
}

/** How brows are, as strands: never longer or shorter. @typedef {import('./strands.js').Curled & import('./browform.js').BrowForm} Brows */

/**
 * @param {import('./plant.js').Skin} skin
 * @returns {import('./strands.js').Hair<Brows> | null} null without the landmarks that it goes by
 */
export function browHair(skin) {
  const form = browLine(skin.landmarks);
  if (!form) return null;
  const random = chance(31);
  /** @type {(import('./browline.js').BrowHair & { relief: ReturnType<typeof reliefAround>, lift: number, broad: number, lasts: number, order: number })[]} */
  const hairs = [];
  for (const line of browLines(skin.landmarks)) {
    const relief = reliefAround(line, skin);
    growBrows([line], HAIRS, random, (hair) => {
      const { x, y, t, across } = hair;
      const [order, lift] = [random(), random()];
      if (!relief.bind(x, y)) return;
      // A brow begins soft, and ends in single hairs.
      const broad = Math.min(1, 0.45 + 2 * t) * (1 - 0.55 * smoothstep(0.5, 1, t)) * (0.55 + 0.45 * random());
      // Those in the middle of a brow are there however thin it is, but for its tail.
      hairs.push({ ...hair, relief, lift, broad, lasts: (1 - 1.5 * Math.abs(across)) * (1 - 0.5 * smoothstep(0.6, 1, t)), order });
    });
  }
  // The first of them are anywhere: where few are drawn, it is they.
  hairs.sort((a, b) => a.order - b.order);
  const count = hairs.length;
  const open = Float32Array.from({ length: count * POINTS }, (_, i) => 0.45 + 0.3 * ((Math.floor(i / POINTS) * 0.7548776662) % 1) + (0.25 * (i % POINTS)) / POINTS);
  const breadth = Float32Array.from(open, (_, i) => hairs[Math.floor(i / POINTS)].broad);

  const grow = (/** @type {Brows} */ style) => {
    const moves = movesOf(style, form);
    const [points, outward] = [new Float32Array(3 * POINTS * count), new Float32Array(3 * POINTS * count)];
    // They are too short to lie on anything but what they grow from.
    const [places, weights] = [0, 1].map(() => new Float32Array(3 * ANCHORS * count));
    const corners = new Uint32Array(3 * ANCHORS * count);
    hairs.forEach(({ x, y, dx, dy, t, relief, lift }, n) => {
      const [left, low] = movedBrow(form, moves, x, y);
      const side = Math.sign(x);
      const turn = turnOfBrow(form, moves, x);
      const longer = moves.broad ** LONGER;
      const [cos, sin] = [longer * Math.cos(turn), longer * Math.sin(turn)];
      const [alongX, alongY] = [cos * dx - side * sin * dy, side * sin * dx + cos * dy];
      for (let s = 0; s < POINTS; s++) {
        const at = s / (POINTS - 1);
        // As they are painted, and a little off the skin from the root on.
        const [px, py] = [left + alongX * (1.1 * at - 0.1 * at * at), low + alongY * (1.5 * at - 0.78 * at * at)];
        const out = relief.out(px, py);
        const off = (0.35 + 0.75 * lift) * (1 - 0.4 * t) * at * (1.9 - 1.1 * at) - 0.1;
        const o = 3 * (n * POINTS + s);
        points.set([px + off * out[0], py + off * out[1], relief.z(px, py) + off * out[2]], o);
        outward.set(out, o);
      }
      const bound = relief.bind(left, low);
      // Beside the head nothing would carry it: it goes nowhere.
      if (!bound) return;
      for (let k = 0; k < ANCHORS; k++) {
        const o = 3 * (k * count + n);
        corners.set(bound.corners, o);
        weights.set(bound.weights, o);
        for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) places[o + i] += bound.weights[j] * skin.positions[3 * bound.corners[j] + i];
      }
    });
    return { points, outward, open, breadth, ends: new Float32Array(count).fill(1), anchors: { places, corners, weights } };
  };
  return {
    strands: count,
    locks: count,
    lockOf: Uint16Array.from(hairs, (_, n) => n),
    // However thin they are, it is the same hairs that stand.
    parts: Uint8Array.from(hairs.flatMap(({ lasts }) => [0, 0, 0, Math.round(255 * lasts)])),
    grow,
  };
}
