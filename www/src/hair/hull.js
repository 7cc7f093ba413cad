import { smoothstep } from '../groundwork/paint.js';

// The outside of a head as hair meets it: how far it reaches from its middle in each direction.

/** @param {number} x @param {number} low @param {number} high */
export const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

// Much quicker than Math.hypot, and no length here is near a float's limits.
/** @param {number} x @param {number} y @param {number} [z] */
export const norm = (x, y, z = 0) => Math.sqrt(x * x + y * y + z * z);

// Columns and rows of a hull, around and from the lowest point up.
const AROUND = 96;
const ALONG = 48;

/** The cell of a direction. @param {number} x @param {number} y @param {number} z @param {number} radius how long that is */
function cellOf(x, y, z, radius) {
  const column = Math.floor((Math.atan2(x, z) / (2 * Math.PI) + 0.5) * AROUND) % AROUND;
  const row = clamp(Math.floor((Math.asin(y / radius) / Math.PI + 0.5) * ALONG), 0, ALONG - 1);
  return row * AROUND + column;
}

/**
 * How far the head reaches, by direction, and what of it is there: three vertices with a weight each.
 * @param {Float32Array} rest 3 a vertex, mm @param {Uint32Array} triangles
 * @param {readonly [number, number, number]} middle
 */
function hullOf(rest, triangles, middle) {
  const reach = new Float32Array(AROUND * ALONG);
  const corners = new Uint32Array(3 * reach.length);
  const weights = new Float32Array(corners.length);
  const n = 5;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    for (let i = 0; i <= n; i++) {
      for (let j = 0; i + j <= n; j++) {
        const [u, v, w] = [i / n, j / n, 1 - (i + j) / n];
        const x = u * rest[a] + v * rest[b] + w * rest[c] - middle[0];
        const y = u * rest[a + 1] + v * rest[b + 1] + w * rest[c + 1] - middle[1];
        const z = u * rest[a + 2] + v * rest[b + 2] + w * rest[c + 2] - middle[2];
        const radius = norm(x, y, z);
        const at = cellOf(x, y, z, radius);
        if (radius <= reach[at]) continue;
        reach[at] = radius;
        corners.set([triangles[t], triangles[t + 1], triangles[t + 2]], 3 * at);
        weights.set([u, v, w], 3 * at);
      }
    }
  }
  // Cells that nothing fell into, below the neck's edge and between large triangles, from those around them;
  // and no steps from cell to cell.
  for (let round = 0; round < AROUND && reach.includes(0); round++) {
    const before = reach.slice();
    for (let at = 0; at < reach.length; at++) if (before[at] === 0) reach[at] = mean(before, at, false);
  }
  for (let round = 0; round < 2; round++) {
    const before = reach.slice();
    for (let at = 0; at < reach.length; at++) reach[at] = Math.max(0.5 * (before[at] + mean(before, at, true)), mean(before, at, true));
  }
  return { reach, corners, weights };
}

/**
 * As far as a cloth over the head reaches: ears are no steps in it, on which hair would stop.
 * @param {Float32Array} reach
 */
function drapeOver(reach) {
  const drape = reach.slice();
  // From wherever a head is wide it falls almost straight.
  for (let at = drape.length - 1 - AROUND; at >= 0; at--) {
    const up = at + AROUND;
    const [here, above] = [at, up].map((cell) => Math.cos(((Math.floor(cell / AROUND) + 0.5) / ALONG - 0.5) * Math.PI));
    if (here > 0.5 && here < above) drape[at] = Math.max(drape[at], (0.98 * drape[up] * above) / here);
  }
  for (let round = 0; round < 14; round++) {
    const before = drape.slice();
    for (let at = 0; at < drape.length; at++) drape[at] = Math.max(before[at] - 0.2, mean(before, at, true));
  }
  // A fringe lies on the forehead.
  return drape.map((value, at) => {
    const turn = Math.abs(((at % AROUND) + 0.5) / AROUND - 0.5) * 2 * Math.PI;
    return reach[at] + Math.max(0, value - reach[at]) * smoothstep(0.8, 1.3, turn);
  });
}

/** Of the cells around one that hold something. @param {Float32Array} reach @param {number} at @param {boolean} own */
function mean(reach, at, own) {
  const [column, row] = [at % AROUND, Math.floor(at / AROUND)];
  let sum = 0;
  let count = 0;
  for (let j = Math.max(0, row - 1); j <= Math.min(ALONG - 1, row + 1); j++) {
    for (let i = -1; i <= 1; i++) {
      const value = reach[j * AROUND + ((column + i + AROUND) % AROUND)];
      if (value === 0 || (!own && i === 0 && j === row)) continue;
      sum += value;
      count++;
    }
  }
  return count ? sum / count : 0;
}

/**
 * @param {Float32Array} rest 3 a vertex, mm @param {Uint32Array} triangles
 * @param {import('../groundwork/paint.js').Points} landmarks
 * @returns null without the landmarks that tell where its middle is
 */
export function createHull(rest, triangles, landmarks) {
  const [trichion, tragion] = ['trichion', 'tragion left'].map((name) => landmarks.get(name));
  if (!trichion || !tragion) return null;
  const tall = trichion[1] - tragion[1];
  /** @type {[number, number, number]} */
  const middle = [0, tragion[1] + 0.42 * tall, tragion[2] + 0.11 * tall];
  const { reach, corners, weights } = hullOf(rest, triangles, middle);
  const drape = drapeOver(reach);
  /** @param {number} at @param {number} draped */
  const reached = (at, draped) => reach[at] + (drape[at] - reach[at]) * draped;
  /** Of the point that was looked at last: how high it is over the hull, mm, and the way out there. */
  const over = { height: 0, x: 0, y: 0, z: 0, radius: 0 };
  /**
   * @param {number} x @param {number} y @param {number} z mm
   * @param {number} [draped] 0 looks at the head, 1 at a cloth over it
   */
  function look(x, y, z, draped = 0) {
    const [dx, dy, dz] = [x - middle[0], y - middle[1], z - middle[2]];
    const radius = norm(dx, dy, dz) || 1;
    const i = (Math.atan2(dx, dz) / (2 * Math.PI) + 0.5) * AROUND - 0.5 + AROUND;
    const j = clamp((Math.asin(dy / radius) / Math.PI + 0.5) * ALONG - 0.5, 0, ALONG - 1.001);
    const [left, low] = [Math.floor(i), Math.floor(j)];
    const [u, v] = [i - left, j - low];
    const [a, b] = [left % AROUND, (left + 1) % AROUND];
    const p = reached(low * AROUND + a, draped);
    const q = reached(low * AROUND + b, draped);
    const r = reached((low + 1) * AROUND + a, draped);
    const s = reached((low + 1) * AROUND + b, draped);
    const [bottom, top] = [p + (q - p) * u, r + (s - r) * u];
    over.radius = bottom + (top - bottom) * v;
    over.height = radius - over.radius;
    // Of radius less reach, along the circle around and the one up.
    const flat = norm(dx, dz) || 1e-3;
    const east = (((q - p) * (1 - v) + (s - r) * v) * AROUND) / (2 * Math.PI * Math.max(flat, 0.15 * radius));
    const north = ((top - bottom) * ALONG) / (Math.PI * radius);
    const [ex, ez] = [dz / flat, -dx / flat];
    const [nx, ny, nz] = [(-dx / flat) * (dy / radius), flat / radius, (-dz / flat) * (dy / radius)];
    over.x = dx / radius - east * ex - north * nx;
    over.y = dy / radius - north * ny;
    over.z = dz / radius - east * ez - north * nz;
    const length = norm(over.x, over.y, over.z);
    over.x /= length;
    over.y /= length;
    over.z /= length;
  }
  return {
    middle,
    over,
    look,
    /**
     * What of the head is below a point: three vertices with a weight each, no weights where there is none.
     * @param {number} x @param {number} y @param {number} z mm
     */
    below(x, y, z) {
      const [dx, dy, dz] = [x - middle[0], y - middle[1], z - middle[2]];
      const o = 3 * cellOf(dx, dy, dz, norm(dx, dy, dz) || 1);
      return { corners: corners.subarray(o, o + 3), weights: weights.subarray(o, o + 3) };
    },
  };
}

/** @typedef {NonNullable<ReturnType<typeof createHull>>} Hull */
