import { chance } from './chance.js';
import { smoothstep } from './groundwork/paint.js';

// How longer hair grows on the generic head: strands with roots spread over the scalp, combed by a field of
// directions, pulled down by their weight, kept outside of the head and gathered into locks. The same strands with
// the same seeds are there for every style, so that one style turns into another as sliders move.

/** What of a colouring is a style, each from 0 to 1. @typedef {{ length: number, comb: number, parting: number, curl: number }} Style */

/** Points along a strand, its root among them. */
export const POINTS = 16;
const STRANDS = 3000;
const LOCKS = 420;
/** The least distance between the roots of two locks, mm. */
const APART = 8;
/** Of a lock while it grows. */
const STEPS = 28;
/** The longest that hair is, mm: to below the chin. */
const LONGEST = 230;
/** How far hair bends where it is pulled, mm. */
const STIFFNESS = 16;

// Much quicker than Math.hypot, and no length here is near a float's limits.
/** @param {number} x @param {number} y @param {number} [z] */
const norm = (x, y, z = 0) => Math.sqrt(x * x + y * y + z * z);

/** How long hair is, mm. @param {number} length of a style */
export const hairLength = (length) => LONGEST * length ** 1.5;

/** How thick hair lies on the head, mm. @param {Style} style @param {number} long mm */
const volumeOf = ({ curl }, long) => Math.min(9, 0.11 * long) + 14 * curl * Math.min(1, long / 90);

/** Where hair parts, mm to the subject's left. @param {Style} style */
const lineOf = ({ parting }) => (0.5 - parting) * 90;

/** @param {number} x @param {number} low @param {number} high */
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

// Columns and rows of a hull, around and from the lowest point up.
const AROUND = 96;
const ALONG = 48;

/**
 * How far the head reaches from its middle in each direction: what hair lies on.
 * @param {Float32Array} rest 3 a vertex, mm @param {Uint32Array} triangles
 * @param {readonly [number, number, number]} middle
 */
function hullOf(rest, triangles, middle) {
  const reach = new Float32Array(AROUND * ALONG);
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
        const column = Math.floor((Math.atan2(x, z) / (2 * Math.PI) + 0.5) * AROUND) % AROUND;
        const row = clamp(Math.floor((Math.asin(y / radius) / Math.PI + 0.5) * ALONG), 0, ALONG - 1);
        const at = row * AROUND + column;
        if (radius > reach[at]) reach[at] = radius;
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
  return reach;
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
 * What grows hair on a head: strands for any style.
 *
 * @param {Float32Array} rest 3 a vertex, mm
 * @param {Float32Array} normals 3 a vertex
 * @param {Uint32Array} triangles
 * @param {Float32Array} scalp how far inside the hairline each vertex is, as `growth` has it
 * @param {import('./groundwork/paint.js').Points} landmarks
 * @returns {Hair | null} null where nothing grows
 */
export function createHairstyle(rest, normals, triangles, scalp, landmarks) {
  const [trichion, tragion, brow] = ['trichion', 'tragion left', 'ibug_19'].map((name) => landmarks.get(name));
  if (!trichion || !tragion || !brow) return null;
  const tall = trichion[1] - tragion[1];
  /** @type {[number, number, number]} */
  const middle = [0, tragion[1] + 0.42 * tall, tragion[2] + 0.11 * tall];
  const reach = hullOf(rest, triangles, middle);

  /** The hull above a point: how high the point is over it, mm, and the way out of it. */
  const over = { height: 0, x: 0, y: 0, z: 0, radius: 0 };
  /** @param {number} x @param {number} y @param {number} z mm */
  function look(x, y, z) {
    const [dx, dy, dz] = [x - middle[0], y - middle[1], z - middle[2]];
    const radius = norm(dx, dy, dz) || 1;
    const i = (Math.atan2(dx, dz) / (2 * Math.PI) + 0.5) * AROUND - 0.5 + AROUND;
    const j = clamp((Math.asin(dy / radius) / Math.PI + 0.5) * ALONG - 0.5, 0, ALONG - 1.001);
    const [left, low] = [Math.floor(i), Math.floor(j)];
    const [u, v] = [i - left, j - low];
    const [a, b] = [left % AROUND, (left + 1) % AROUND];
    const p = reach[low * AROUND + a];
    const q = reach[low * AROUND + b];
    const r = reach[(low + 1) * AROUND + a];
    const s = reach[(low + 1) * AROUND + b];
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

  // Roots: a place on a triangle of the scalp.
  const random = chance(67);
  /** @type {number[]} */
  const areas = [];
  /** @type {number[]} */
  const grown = [];
  let whole = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    if (Math.max(scalp[triangles[t]], scalp[triangles[t + 1]], scalp[triangles[t + 2]]) < 0) continue;
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const [ux, uy, uz] = [0, 1, 2].map((k) => rest[b + k] - rest[a + k]);
    const [vx, vy, vz] = [0, 1, 2].map((k) => rest[c + k] - rest[a + k]);
    whole += 0.5 * norm(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
    areas.push(whole);
    grown.push(t);
  }
  if (whole === 0) return null;
  function anywhere() {
    for (;;) {
      const aim = whole * random();
      let [low, high] = [0, areas.length - 1];
      while (low < high) {
        const half = (low + high) >> 1;
        if (areas[half] < aim) low = half + 1;
        else high = half;
      }
      let [u, v] = [random(), random()];
      if (u + v > 1) [u, v] = [1 - u, 1 - v];
      const corners = [0, 1, 2].map((k) => triangles[grown[low] + k]);
      const weights = [1 - u - v, u, v];
      const blend = (/** @type {Float32Array} */ values, /** @type {number} */ size, /** @type {number} */ k) =>
        corners.reduce((sum, corner, i) => sum + weights[i] * values[size * corner + k], 0);
      // No hairline is a line.
      if (blend(scalp, 1, 0) < 0.3 * random() - 0.15) continue;
      return {
        corners,
        weights,
        at: [0, 1, 2].map((k) => blend(rest, 3, k)),
        normal: [0, 1, 2].map((k) => blend(normals, 3, k)),
      };
    }
  }
  /** @type {ReturnType<typeof anywhere>[]} */
  const locks = [];
  for (let tries = 0; tries < 40 * LOCKS && locks.length < LOCKS; tries++) {
    const root = anywhere();
    if (locks.every(({ at }) => norm(at[0] - root.at[0], at[1] - root.at[1], at[2] - root.at[2]) > APART)) locks.push(root);
  }
  const places = Float32Array.from(locks.flatMap(({ at }) => at));
  const signed = () => random() + random() - 1;
  const ofLock = locks.map(() => ({ layer: random(), long: 0.86 + 0.14 * random(), turn: 2 * Math.PI * random(), hand: random() < 0.5 ? -1 : 1, lean: [signed(), signed(), signed()] }));
  const strands = Array.from({ length: STRANDS }, () => {
    const root = anywhere();
    let lock = 0;
    let nearest = Infinity;
    const [x, y, z] = root.at;
    for (let i = 0; i < locks.length; i++) {
      const away = (places[3 * i] - x) ** 2 + (places[3 * i + 1] - y) ** 2 + (places[3 * i + 2] - z) ** 2;
      if (away < nearest) {
        nearest = away;
        lock = i;
      }
    }
    return { ...root, lock, long: 0.9 + 0.1 * random(), stray: [signed(), signed(), signed()], turn: 0.9 * signed(), rise: random() };
  });

  // Where hair parts from: a whorl behind the crown.
  const crown = strands.reduce((top, { at }) => Math.max(top, at[1]), -Infinity);
  const back = strands.reduce((least, { at }) => Math.min(least, at[2]), Infinity);
  const whorl = [6, crown - 0.1 * (crown - middle[1]), middle[2] + 0.62 * (back - middle[2])];

  const way = [0, 0, 0];
  /**
   * Which way hair is combed at a place on the head, along what `over` has found there.
   * @param {number} x @param {number} y @param {number} z @param {Style} style
   */
  function combed(x, y, z, style) {
    const { comb, curl } = style;
    const [toBack, toSide, toFront] = [Math.max(0, 1 - 2 * comb), 1 - Math.abs(2 * comb - 1), Math.max(0, 2 * comb - 1)];
    const behind = smoothstep(whorl[2] + 25, whorl[2] - 10, z);
    const across = clamp((x - lineOf(style)) / 3, -1, 1);
    const away = norm(x - whorl[0], y - whorl[1], z - whorl[2]) || 1;
    const natural = behind + (1 - behind) * toFront;
    // Curls do not lie down to be parted.
    const side = (1 - behind) * toSide * (1 - 0.8 * curl * curl);
    const backwards = (1 - behind) * toBack;
    way[0] = (natural * (x - whorl[0])) / away + side * across + backwards * clamp(x / 130, -0.5, 0.5);
    way[1] = (natural * (y - whorl[1])) / away - 0.45 * side - 0.2 * backwards;
    way[2] = (natural * (z - whorl[2])) / away - 0.3 * side - backwards;
    const out = way[0] * over.x + way[1] * over.y + way[2] * over.z;
    way[0] -= out * over.x;
    way[1] -= out * over.y;
    way[2] -= out * over.z;
    const length = norm(way[0], way[1], way[2]) || 1;
    for (let k = 0; k < 3; k++) way[k] /= length;
  }

  /**
   * Hair does not hang before the eyes: it is cut over the brows.
   * @param {number} x @param {number} y @param {number} z
   */
  const beforeFace = (x, y, z) => y < brow[1] + 9 && Math.abs(Math.atan2(x, z - middle[2])) < 0.9;

  const paths = new Float32Array(3 * (STEPS + 1) * LOCKS);
  /** How far along its path each lock is cut, 0 to 1. */
  const cut = new Float32Array(LOCKS);
  /** How long each lock is, mm. */
  const reachOf = new Float32Array(LOCKS);

  /** @param {Style} style @param {number} long mm */
  function growLocks(style, long) {
    const { curl } = style;
    const free = Math.min(1, long / 25);
    const volume = volumeOf(style, long);
    // Tight curls carry themselves.
    const heavy = 1 - 0.85 * curl * curl;
    locks.forEach((lock, n) => {
      const own = ofLock[n];
      // Around the ears and along the nape short hair is cut shorter than on top.
      const top = smoothstep(middle[1] - 10, middle[1] + 45, lock.at[1]);
      const cropped = (1 - top) * (1 - smoothstep(60, 130, long));
      reachOf[n] = long * own.long * (1 - 0.6 * cropped);
      const step = reachOf[n] / STEPS;
      const bent = 1 - Math.exp(-step / STIFFNESS);
      let [x, y, z] = lock.at;
      look(x, y, z);
      combed(x, y, z, style);
      const lift = 0.55 + 0.8 * curl * curl;
      let dx = way[0] + lift * lock.normal[0] + 0.12 * own.lean[0];
      let dy = way[1] + lift * lock.normal[1] + 0.12 * own.lean[1];
      let dz = way[2] + lift * lock.normal[2] + 0.12 * own.lean[2];
      // What parts would show the skin between: it begins beyond the line.
      const parts = Math.max(
        style.comb < 1 && z > whorl[2] ? (1 - Math.abs(2 * style.comb - 1)) * Math.exp(-(((x - lineOf(style)) / 9) ** 2)) : 0,
        Math.exp(-((x - whorl[0]) ** 2 + (z - whorl[2]) ** 2) / 150),
      );
      const early = 8 * parts * (1 - curl * curl);
      x -= early * way[0];
      y -= early * way[1];
      z -= early * way[2];
      const o = 3 * (STEPS + 1) * n;
      paths[o] = x;
      paths[o + 1] = y;
      paths[o + 2] = z;
      cut[n] = 1;
      for (let s = 1; s <= STEPS; s++) {
        const length = norm(dx, dy, dz);
        x += (step * dx) / length;
        y += (step * dy) / length;
        z += (step * dz) / length;
        const along = s * step;
        look(x, y, z);
        const clear = Math.min(0.5 * along, 1.2 + own.layer * volume) * free;
        if (over.height < clear) {
          const pushed = (over.radius + clear) / (over.radius + over.height);
          x = middle[0] + (x - middle[0]) * pushed;
          y = middle[1] + (y - middle[1]) * pushed;
          z = middle[2] + (z - middle[2]) * pushed;
          const into = Math.min(0, (dx * over.x + dy * over.y + dz * over.z) / length);
          dx -= into * length * over.x;
          dy -= into * length * over.y;
          dz -= into * length * over.z;
        }
        combed(x, y, z, style);
        const kept = Math.exp(-along / 55) * (1 - smoothstep(12, 40, over.height));
        const now = norm(dx, dy, dz) || 1;
        const out = 0.75 * curl * curl;
        // Below the head hair falls towards the neck.
        const inward = 0.25 * (1 - kept) * smoothstep(middle[1] - 20, middle[1] - 80, y);
        const [tx, ty, tz] = [
          kept * way[0] + (out - inward) * over.x,
          kept * way[1] - (1 - kept) * heavy + out * over.y,
          kept * way[2] + (out - inward) * over.z,
        ];
        dx = (dx / now) * (1 - bent) + tx * bent;
        dy = (dy / now) * (1 - bent) + ty * bent;
        dz = (dz / now) * (1 - bent) + tz * bent;
        paths[o + 3 * s] = x;
        paths[o + 3 * s + 1] = y;
        paths[o + 3 * s + 2] = z;
        if (cut[n] === 1 && beforeFace(x, y + 4 * own.lean[0], z)) cut[n] = (s - 0.5) / STEPS;
      }
    });
  }

  /**
   * @param {Style} style
   * @returns {Grown}
   */
  function grow(style) {
    // Rolled up it reaches less far.
    const long = hairLength(style.length) * (1 - 0.5 * style.curl ** 2);
    growLocks(style, long);
    const { curl } = style;
    const points = new Float32Array(3 * POINTS * STRANDS);
    const outward = new Float32Array(points.length);
    const open = new Float32Array(points.length / 3);
    const deep = 3 + 0.6 * volumeOf(style, long);
    // Short hair hides little of the light.
    const least = clamp(1 - long / 50, 0, 0.8);
    // Waves, then curls, then coils that a strand's few points can still follow.
    const wave = Math.max(46 - 36 * curl, long / 4.2);
    const swing = curl * Math.min(7, 0.04 * wave + 0.022 * long) * Math.min(1, long / 30);
    const p = [0, 0, 0];
    strands.forEach((strand, n) => {
      const own = ofLock[strand.lock];
      const root = locks[strand.lock].at;
      const from = 3 * (STEPS + 1) * strand.lock;
      const end = Math.min(strand.long, cut[strand.lock] + 0.02 * strand.stray[0]);
      for (let s = 0; s < POINTS; s++) {
        const t = (end * s) / (POINTS - 1);
        const along = t * reachOf[strand.lock];
        const at = Math.min(STEPS - 0.001, t * STEPS);
        const i = Math.floor(at);
        // Locks are wide at their roots and gather to their tips.
        const wide = 1 - 0.72 * smoothstep(4, 70, along);
        const stray = Math.min(7, 0.075 * along);
        const turn = (2 * Math.PI * along * own.hand) / wave + own.turn + strand.turn * (0.5 + 3 * curl ** 3);
        const swung = swing * smoothstep(2, 30, along);
        for (let k = 0; k < 3; k++) {
          const path = paths[from + 3 * i + k] + (paths[from + 3 * i + 3 + k] - paths[from + 3 * i + k]) * (at - i);
          p[k] = path + (strand.at[k] - root[k]) * wide + strand.stray[k] * stray;
        }
        if (swung > 0) {
          p[0] += swung * Math.cos(turn);
          p[1] += swung * 0.35 * Math.cos(turn + 1);
          p[2] += swung * Math.sin(turn);
        }
        look(p[0], p[1], p[2]);
        const clear = Math.min(0.4 * along, 1 + 1.5 * strand.rise);
        if (over.height < clear && s > 0) {
          const pushed = (over.radius + clear) / (over.radius + over.height);
          for (let k = 0; k < 3; k++) p[k] = middle[k] + (p[k] - middle[k]) * pushed;
        }
        const point = POINTS * n + s;
        open[point] = clamp((over.height - 1) / deep, least, 1);
        for (let k = 0; k < 3; k++) points[3 * point + k] = p[k];
        outward[3 * point] = over.x;
        outward[3 * point + 1] = over.y;
        outward[3 * point + 2] = over.z;
      }
    });
    return { points, outward, open };
  }
  return {
    strands: STRANDS,
    locks: locks.length,
    lockOf: Uint16Array.from(strands, ({ lock }) => lock),
    /** How far each lock's root has moved from where it is at rest. @param {ArrayLike<number>} positions @param {Float32Array} into 4 a lock */
    shifts(positions, into) {
      locks.forEach(({ corners, weights, at }, n) => {
        for (let k = 0; k < 3; k++) {
          into[4 * n + k] = corners.reduce((sum, corner, i) => sum + weights[i] * positions[3 * corner + k], 0) - at[k];
        }
      });
    },
    grow,
  };
}

/**
 * What a style gives: the points of each strand from root to tip, mm, the way out of the head there, and how near the
 * outside of the hair they are, 0 to 1.
 * @typedef {{ points: Float32Array, outward: Float32Array, open: Float32Array }} Grown
 */
/**
 * @typedef {{
 *   strands: number, locks: number, lockOf: Uint16Array,
 *   shifts: (positions: ArrayLike<number>, into: Float32Array) => void,
 *   grow: (style: Style) => Grown,
 * }} Hair
 */
