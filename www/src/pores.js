import { DataTexture, LinearFilter, LinearMipmapLinearFilter, RepeatWrapping, RGBAFormat } from 'three';
import { chance } from './chance.js';

const SIZE = 512;
const CELLS = 34;

/**
 * A tile of skin relief: red and green hold the slope, blue the height, alpha a coarse mottling.
 * Pores are dents at the points of a jittered grid, joined by the shallow furrows between them.
 */
export function createPores() {
  const random = chance(7);
  const points = Array.from({ length: CELLS * CELLS }, () => [
    0.15 + 0.7 * random(),
    0.15 + 0.7 * random(),
    0.35 + 0.65 * random(),
  ]);
  const height = new Float32Array(SIZE * SIZE);
  for (let y = 0; y < SIZE; y++) {
    for (let x = 0; x < SIZE; x++) {
      const gx = (x / SIZE) * CELLS;
      const gy = (y / SIZE) * CELLS;
      const cx = Math.floor(gx);
      const cy = Math.floor(gy);
      // Squares of the distances to the nearest two points.
      let first = 81;
      let second = 81;
      let depth = 0;
      for (let j = -1; j <= 1; j++) {
        for (let i = -1; i <= 1; i++) {
          const [px, py, d] = points[((cy + j + CELLS) % CELLS) * CELLS + ((cx + i + CELLS) % CELLS)];
          const [dx, dy] = [cx + i + px - gx, cy + j + py - gy];
          const square = dx * dx + dy * dy;
          if (square < first) {
            second = first;
            first = square;
            depth = d;
          } else if (square < second) second = square;
        }
      }
      const pore = Math.exp(-first / 0.24 ** 2) * depth;
      const furrow = Math.exp(-(((Math.sqrt(second) - Math.sqrt(first)) / 0.16) ** 2));
      height[y * SIZE + x] = -0.75 * pore - 0.4 * furrow;
    }
  }
  const mottle = patches(random);
  const pixels = new Uint8Array(SIZE * SIZE * 4);
  const at = (/** @type {number} */ x, /** @type {number} */ y) =>
    height[((y + SIZE) % SIZE) * SIZE + ((x + SIZE) % SIZE)];
  for (let y = 0; y < SIZE; y++) {
    for (let x = 0; x < SIZE; x++) {
      const o = 4 * (y * SIZE + x);
      pixels[o] = 127.5 + 127.5 * clamp((at(x + 1, y) - at(x - 1, y)) * 3, -1, 1);
      pixels[o + 1] = 127.5 + 127.5 * clamp((at(x, y + 1) - at(x, y - 1)) * 3, -1, 1);
      pixels[o + 2] = 255 * clamp(1 + at(x, y), 0, 1);
      pixels[o + 3] = 255 * mottle[y * SIZE + x];
    }
  }
  const texture = new DataTexture(pixels, SIZE, SIZE, RGBAFormat);
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
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
    const places = Array.from({ length: SIZE }, (_, i) => {
      const at = (i / SIZE) * cells;
      const low = Math.floor(at);
      return { low, high: (low + 1) % cells, part: smooth(at - low) };
    });
    for (let y = 0; y < SIZE; y++) {
      const { low, high, part: v } = places[y];
      for (let x = 0; x < SIZE; x++) {
        const { low: left, high: right, part: u } = places[x];
        const [a, b] = [grid[low * cells + left], grid[high * cells + left]];
        const [c, d] = [grid[low * cells + right], grid[high * cells + right]];
        const [below, above] = [a + (c - a) * u, b + (d - b) * u];
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
