import { chance } from '../chance.js';

const SIZE = 512;
const CELLS = 34;

/**
 * A tile of skin relief: red and green hold the slope, blue the height, alpha a coarse mottling.
 * Pores are dents at the points of a jittered grid, joined by the shallow furrows between them.
 * @returns {import('../rendering/textures.js').Pixels}
 */
export function poreRelief() {
  const random = chance(7);
  // Across, up, depth.
  const points = new Float64Array(3 * CELLS * CELLS);
  for (let i = 0; i < points.length; i += 3) {
    points[i] = 0.15 + 0.7 * random();
    points[i + 1] = 0.15 + 0.7 * random();
    points[i + 2] = 0.35 + 0.65 * random();
  }
  const height = new Float32Array(SIZE * SIZE);
  // Of the cell that a texel is in and of the eight around it.
  const near = new Float64Array(27);
  for (let y = 0; y < SIZE; y++) {
    const gy = (y / SIZE) * CELLS;
    const cy = Math.floor(gy);
    for (let x = 0, cell = -1; x < SIZE; x++) {
      const gx = (x / SIZE) * CELLS;
      const cx = Math.floor(gx);
      if (cx !== cell) {
        cell = cx;
        for (let j = -1, n = 0; j <= 1; j++) {
          for (let i = -1; i <= 1; i++, n += 3) {
            const o = 3 * (((cy + j + CELLS) % CELLS) * CELLS + ((cx + i + CELLS) % CELLS));
            near[n] = cx + i + points[o];
            near[n + 1] = cy + j + points[o + 1];
            near[n + 2] = points[o + 2];
          }
        }
      }
      // Squares of the distances to the nearest two points.
      let first = 81;
      let second = 81;
      let depth = 0;
      for (let n = 0; n < 27; n += 3) {
        const dx = near[n] - gx;
        const dy = near[n + 1] - gy;
        const square = dx * dx + dy * dy;
        if (square < first) {
          second = first;
          first = square;
          depth = near[n + 2];
        } else if (square < second) second = square;
      }
      const pore = Math.exp(-first / 0.24 ** 2) * depth;
      const furrow = Math.exp(-(((Math.sqrt(second) - Math.sqrt(first)) / 0.16) ** 2));
      height[y * SIZE + x] = -0.75 * pore - 0.4 * furrow;
    }
  }
  const mottle = patches(random);
  const pixels = new Uint8Array(SIZE * SIZE * 4);
  for (let y = 0; y < SIZE; y++) {
    const row = y * SIZE;
    const above = ((y + 1) % SIZE) * SIZE;
    const below = ((y + SIZE - 1) % SIZE) * SIZE;
    for (let x = 0; x < SIZE; x++) {
      const o = 4 * (row + x);
      const across = height[row + ((x + 1) % SIZE)] - height[row + ((x + SIZE - 1) % SIZE)];
      pixels[o] = 127.5 + 127.5 * clamp(across * 3, -1, 1);
      pixels[o + 1] = 127.5 + 127.5 * clamp((height[above + x] - height[below + x]) * 3, -1, 1);
      pixels[o + 2] = 255 * clamp(1 + height[row + x], 0, 1);
      pixels[o + 3] = 255 * mottle[row + x];
    }
  }
  return { size: SIZE, rgba: pixels };
}

/**
 * Periodic value noise of four octaves.
 * @param {() => number} random
 */
function patches(random) {
  const sum = new Float32Array(SIZE * SIZE);
  let total = 0;
  for (const [cells, weight] of [[4, 1], [9, 0.8], [21, 0.6], [47, 0.45]]) {
    const grid = Float32Array.from({ length: cells * cells }, random);
    total += weight;
    for (let y = 0; y < SIZE; y++) {
      const up = (y / SIZE) * cells;
      const low = Math.floor(up) * cells;
      const high = (low + cells) % (cells * cells);
      const v = smooth(up - Math.floor(up));
      for (let x = 0; x < SIZE; x++) {
        const across = (x / SIZE) * cells;
        const left = Math.floor(across);
        const right = (left + 1) % cells;
        const u = smooth(across - left);
        const below = grid[low + left] + (grid[low + right] - grid[low + left]) * u;
        const above = grid[high + left] + (grid[high + right] - grid[high + left]) * u;
        sum[y * SIZE + x] += weight * (below + (above - below) * v);
      }
    }
  }
  return sum.map((value) => clamp(0.5 + 1.6 * (value / total - 0.5), 0, 1));
}

/** @param {number} t */
function smooth(t) {
  return t * t * (3 - 2 * t);
}

/** @param {number} x @param {number} low @param {number} high */
function clamp(x, low, high) {
  return Math.min(high, Math.max(low, x));
}
