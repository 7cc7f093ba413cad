import { clamp, norm } from './hull.js';

// Skin as it is seen from the front, around the brows.

/** How far a brow's hairs grow and reach from the model's own line, mm, whatever form they have. */
const AROUND = 24;
/** No triangle there is larger, mm. */
const LARGE = 20;
/** Between points at which the skin is known, mm. */
const STEP = 0.7;

/**
 * The skin around a line as it is seen from the front: how far forward it is, and which triangle is there.
 * @param {number[][]} line
 * @param {import('./plant.js').Skin} skin
 */
export function reliefAround(line, { positions, normals, triangles }) {
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
