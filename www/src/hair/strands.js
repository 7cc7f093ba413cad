import { chance } from '../chance.js';
import { smoothstep } from '../groundwork/paint.js';
import { clamp, norm } from './hull.js';
import { MARGIN } from './margin.js';

// How hair grows from some ground: strands with roots spread over it, combed by a field of directions, pulled down by
// their weight, kept outside of the head and gathered into locks. The same strands with the same seeds are there for every
// style, so that one style turns into another as sliders move.

/** Points along a strand, its root among them. */
export const POINTS = 24;
/** Along a lock those that go with the head where they lie on it: its root, and at even distances to its tip. */
export const ANCHORS = 4;
/** What is farther off the head hangs from where it left it, mm. */
const HANGS = 30;
/** Of a lock while it grows. */
const STEPS = 28;
/** How far hair bends where it is pulled, mm. */
const STIFFNESS = 16;
/** How often the path of hair that is held is smoothed. */
const ROUNDED = 24;
/** How far before its root hair begins at most, mm. */
export const EARLIEST = 8;
/** Of a head, mm. */
const RADIUS = 105;
/** How much of a hair is cut off what is cut in a line: most of what grows thin. */
const BLUNT = 0.4;
/** How far behind its line, mm, hair is still seen from its root on, and how fine it begins there. */
const BEHIND = 11;
const FINEST = 0.3;
/** Over how much of its length what begins fine gets its breadth, mm. */
const BROADENS = 14;
/** How far roots that are seen are lit, and how much, mm. */
const LIT = 30;
const LIGHT = 0.8;
/** How often a root is looked for: a beard's ground is a tenth of the head, and most triangles are small. */
const TRIES = 3000;

/** How long hair is, from none (0) to its longest (1), and from straight to curly. @typedef {{ length: number, curl: number }} Curled */

/**
 * What hair grows from.
 * @template {Curled} S
 * @typedef {object} Ground
 * @property {Float32Array} mask how far inside of it each vertex is, as `growth` has it
 * @property {number} line over how much of the mask hair becomes dense
 * @property {(x: number, y: number) => boolean} [bare] where nothing grows all the same
 * @property {number} seed
 * @property {number} strands how many
 * @property {number} apart the distance between the roots of two locks, mm
 * @property {(style: S) => number} long how long hair is, mm
 * @property {(long: number) => number} thick how thick it lies, mm
 * @property {number} lift how far it stands up at its roots
 * @property {number} kept how far from its root it is combed before it hangs, mm
 * @property {(roots: number[][]) => Comb<S>} comb laid out when roots are known, mm
 */
/**
 * @template {Curled} S
 * @typedef {object} Comb
 * @property {(x: number, y: number, z: number, style: S, way: number[]) => void} field which way hair goes, in any length, which is
 *   made to lie on the head
 * @property {(x: number, y: number, z: number, long: number, style: S) => number} reach how long hair is, by its root, mm
 * @property {(x: number, y: number, z: number, style: S) => number} early how far before its root it begins, mm, `EARLIEST` at most
 * @property {(x: number, y: number, z: number, jitter: number) => boolean} cut where hair is cut; `jitter` is from -1 to 1
 * @property {(y: number) => number} inward how much hair that hangs is drawn to the head
 * @property {(x: number, y: number, z: number, style: S) => number} [held] how far hair stays combed and close to the head here,
 *   however long it is, 0 to 1
 * @property {(style: S) => number} [even] how evenly hair that is held is cut, 0 to 1: its locks do not gather to their tips
 */

/**
 * @template {Curled} S
 * @param {Float32Array} rest 3 a vertex, mm
 * @param {Float32Array} normals 3 a vertex
 * @param {Uint32Array} triangles
 * @param {import('./hull.js').Hull} hull
 * @param {Ground<S>} ground
 * @param {Uint8Array} parts as `partsOf` has them
 * @returns {Hair<S> | null} null where nothing grows
 */
export function growOn(rest, normals, triangles, { middle, over, look: lookAt, below: underneath }, ground, parts) {
  const { mask } = ground;
  if (!mask.some((inside) => inside > 0.2)) return null;
  // Roots: a place on a triangle of the ground. Each strand has chances of its own, and none goes by a sum over
  // the head: where that is some thousandths of a millimetre different, hair is the same.
  const areas = new Float64Array(triangles.length / 3);
  let largest = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const [ux, uy, uz] = [rest[b] - rest[a], rest[b + 1] - rest[a + 1], rest[b + 2] - rest[a + 2]];
    const [vx, vy, vz] = [rest[c] - rest[a], rest[c + 1] - rest[a + 1], rest[c + 2] - rest[a + 2]];
    areas[t / 3] = norm(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
    largest = Math.max(largest, areas[t / 3]);
  }
  /** @param {() => number} random */
  function anywhere(random) {
    for (let tries = 0; tries < TRIES; tries++) {
      const pick = Math.floor(areas.length * random());
      if (areas[pick] < largest * random()) continue;
      let u = random();
      let v = random();
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      const corners = [triangles[3 * pick], triangles[3 * pick + 1], triangles[3 * pick + 2]];
      const weights = [1 - u - v, u, v];
      const blend = (/** @type {Float32Array | Uint8Array} */ values, /** @type {number} */ size, /** @type {number} */ k) =>
        weights[0] * values[size * corners[0] + k] + weights[1] * values[size * corners[1] + k] + weights[2] * values[size * corners[2] + k];
      // No hairline is a line.
      const inside = blend(mask, 1, 0);
      if (inside < ground.line * random() - 0.15) continue;
      const at = [0, 1, 2].map((k) => blend(rest, 3, k));
      if (ground.bare?.(at[0], at[1])) continue;
      return { inside, corners, weights, at, normal: [0, 1, 2].map((k) => blend(normals, 3, k)), part: [0, 1, 2, 3].map((k) => blend(parts, 4, k)) };
    }
    return null;
  }
  const chances = (/** @type {number} */ n) => {
    const random = chance(Math.imul(ground.seed, 0x9e3779b1) + Math.imul(n, 0x85ebca6b));
    return { random, signed: () => random() + random() - 1 };
  };
  const roots = Array.from({ length: ground.strands }, (_, n) => {
    const { random, signed } = chances(n);
    const root = anywhere(random);
    return root && { ...root, long: 0.9 + 0.1 * random(), stray: [signed(), signed(), signed()], turn: 0.9 * signed(), rise: random() };
  }).filter((root) => root !== null);

  // Locks: the strands nearest to directions that are spread evenly around the head (Fibonacci's spiral), not quite.
  const apart = ground.apart / RADIUS;
  const directions = Math.round((4 * Math.PI) / (0.87 * apart * apart));
  /** @type {(Pick<NonNullable<ReturnType<typeof anywhere>>, 'at' | 'corners' | 'weights' | 'normal'> & { layer: number, long: number, turn: number, hand: number, lean: number[] })[]} */
  const locks = [];
  const towards = Float32Array.from(roots.flatMap(({ at }) => {
    const way = [at[0] - middle[0], at[1] - middle[1], at[2] - middle[2]];
    const far = norm(way[0], way[1], way[2]);
    return way.map((x) => x / far);
  }));
  for (let n = 0; n < directions; n++) {
    const { random, signed } = chances(-1 - n);
    const height = 1 - (2 * n + 1) / directions + 0.5 * apart * apart * signed();
    const turn = n * 2.399963229728653 + 0.4 * apart * signed();
    const flat = Math.sqrt(Math.max(0, 1 - height * height));
    const [x, y, z] = [flat * Math.cos(turn), height, flat * Math.sin(turn)];
    let best = -1;
    let least = Math.cos(0.6 * apart);
    for (let i = 0; i < roots.length; i++) {
      const cosine = towards[3 * i] * x + towards[3 * i + 1] * y + towards[3 * i + 2] * z;
      if (cosine > least) {
        least = cosine;
        best = i;
      }
    }
    if (best < 0) continue;
    const { at, corners, weights, normal } = roots[best];
    locks.push({ at, corners, weights, normal, layer: random(), long: 0.86 + 0.14 * random(), turn: signed(), hand: random() < 0.5 ? -1 : 1, lean: [signed(), signed(), signed()] });
  }
  if (locks.length === 0) return null;
  const places = Float32Array.from(locks.flatMap(({ at }) => at));
  const cornersOf = Uint32Array.from(locks.flatMap(({ corners }) => corners));
  const weightsOf = Float32Array.from(locks.flatMap(({ weights }) => weights));
  const strands = roots.map((root) => {
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
    return { ...root, lock };
  });

  const { field, reach, early, cut: isCut, inward, held = () => 0, even = () => 0 } = ground.comb(strands.map(({ at }) => at));

  const way = [0, 0, 0];
  /** The field along what `over` has found. @param {number} x @param {number} y @param {number} z @param {S} style */
  function combed(x, y, z, style) {
    field(x, y, z, style, way);
    const out = way[0] * over.x + way[1] * over.y + way[2] * over.z;
    way[0] -= out * over.x;
    way[1] -= out * over.y;
    way[2] -= out * over.z;
    const length = norm(way[0], way[1], way[2]) || 1;
    for (let k = 0; k < 3; k++) way[k] /= length;
  }

  /** How thick hair lies on the head, mm: curls stand off. @param {S} style @param {number} long mm */
  const volumeOf = ({ curl }, long) => ground.thick(long) + 14 * curl * Math.min(1, long / 90);

  // Long hair lies over ears, and short hair around them.
  let draped = 0;
  /** @param {number} x @param {number} y @param {number} z */
  const look = (x, y, z) => lookAt(x, y, z, draped);

  /** How far down from the top of the head, mm over it and then straight. @param {number} x @param {number} y @param {number} z */
  function down(x, y, z) {
    const below = middle[1] - y;
    return below > 0 ? RADIUS * (0.5 * Math.PI) + below : RADIUS * Math.acos(-below / norm(x - middle[0], below, z - middle[2]));
  }

  const rooted = locks.length;
  /** The head at the anchors of all locks, from the roots on. */
  const anchors = { places: new Float32Array(3 * ANCHORS * rooted), corners: new Uint32Array(3 * ANCHORS * rooted), weights: new Float32Array(3 * ANCHORS * rooted) };
  anchors.places.set(places);
  anchors.corners.set(cornersOf);
  anchors.weights.set(weightsOf);

  /** Where each lock lies on the head, which it goes along with there. */
  function anchor() {
    for (let n = 0; n < rooted; n++) {
      for (let k = 1; k < ANCHORS; k++) {
        const [o, before] = [3 * (k * rooted + n), 3 * ((k - 1) * rooted + n)];
        const from = 3 * ((STEPS + 1) * n + Math.round((cut[n] * STEPS * k) / (ANCHORS - 1)));
        const [x, y, z] = paths.subarray(from, from + 3);
        lookAt(x, y, z);
        const { corners, weights } = underneath(x, y, z);
        if (over.height > HANGS || weights[0] + weights[1] + weights[2] === 0) {
          for (const of of [anchors.places, anchors.corners, anchors.weights]) of.copyWithin(o, before, before + 3);
          continue;
        }
        anchors.corners.set(corners, o);
        anchors.weights.set(weights, o);
        for (let i = 0; i < 3; i++) anchors.places[o + i] = weights[0] * rest[3 * corners[0] + i] + weights[1] * rest[3 * corners[1] + i] + weights[2] * rest[3 * corners[2] + i];
      }
    }
    return { places: anchors.places.slice(), corners: anchors.corners.slice(), weights: anchors.weights.slice() };
  }

  const paths = new Float32Array(3 * (STEPS + 1) * locks.length);
  /** Across the path of each lock, which is where it swings: along the head, and out. */
  const aside = new Float32Array(paths.length);
  const away = new Float32Array(paths.length);
  /** How far down each lock is, as `down` has it. */
  const fallen = new Float32Array((STEPS + 1) * locks.length);
  /** How far each lock is held there. */
  const holds = new Float32Array(fallen.length);
  /** How far along its path each lock is cut, 0 to 1. */
  const cut = new Float32Array(locks.length);
  /** How long each lock is, mm. */
  const reachOf = new Float32Array(locks.length);

  /** How high hair is where it is held, mm: a fringe of curls is thicker. @param {S} style @param {number} hold */
  const highest = ({ curl }, hold) => 6 + 5 * curl + 300 * (1 - hold) ** 2;

  /** @param {S} style @param {number} long mm */
  function growLocks(style, long) {
    const { curl } = style;
    const free = Math.min(1, long / 25);
    const volume = volumeOf(style, long);
    // Tight curls carry themselves.
    const coiled = curl * curl * (1 - 0.75 * smoothstep(35, 110, long));
    const heavy = 1 - 0.85 * coiled;
    locks.forEach((lock, n) => {
      reachOf[n] = lock.long * reach(lock.at[0], lock.at[1], lock.at[2], long, style);
      const step = reachOf[n] / STEPS;
      const bent = 1 - Math.exp(-step / STIFFNESS);
      let [x, y, z] = lock.at;
      look(x, y, z);
      combed(x, y, z, style);
      const begin = early(x, y, z, style);
      const lift = ground.lift * (1 - 0.08 * begin) * (1 - 0.6 * held(x, y, z, style)) * (1 - 0.4 * draped) + 0.8 * coiled;
      const lean = 0.12 + 0.6 * coiled;
      let dx = way[0] + lift * lock.normal[0] + lean * lock.lean[0];
      let dy = way[1] + lift * lock.normal[1] + lean * lock.lean[1];
      let dz = way[2] + lift * lock.normal[2] + lean * lock.lean[2];
      // Across both: a frame that goes along the path without turning around it, so that waves stay waves.
      let [bx, by, bz] = [dy * over.z - dz * over.y, dz * over.x - dx * over.z, dx * over.y - dy * over.x];
      const before = begin * (1 - curl * curl);
      x -= before * way[0];
      y -= before * way[1];
      z -= before * way[2];
      const o = 3 * (STEPS + 1) * n;
      paths[o] = x;
      paths[o + 1] = y;
      paths[o + 2] = z;
      fallen[o / 3] = down(x, y, z);
      aside.fill(0, o, o + 3);
      away.fill(0, o, o + 3);
      cut[n] = 1;
      for (let s = 1; s <= STEPS; s++) {
        const length = norm(dx, dy, dz);
        x += (step * dx) / length;
        y += (step * dy) / length;
        z += (step * dz) / length;
        const along = s * step;
        look(x, y, z);
        const hold = held(x, y, z, style);
        const most = highest(style, hold);
        const clear = Math.min(0.5 * along, 1.2 + lock.layer * volume, most) * free;
        if (over.height > most) {
          const pulled = (over.radius + most + 0.6 * (over.height - most)) / (over.radius + over.height);
          x = middle[0] + (x - middle[0]) * pulled;
          y = middle[1] + (y - middle[1]) * pulled;
          z = middle[2] + (z - middle[2]) * pulled;
        } else if (over.height < clear) {
          // No further than it has come from a root that lies deeper, as beside an ear.
          const pushed = (over.radius + Math.min(clear, over.height + along)) / (over.radius + over.height);
          x = middle[0] + (x - middle[0]) * pushed;
          y = middle[1] + (y - middle[1]) * pushed;
          z = middle[2] + (z - middle[2]) * pushed;
          const into = Math.min(0, (dx * over.x + dy * over.y + dz * over.z) / length);
          dx -= into * length * over.x;
          dy -= into * length * over.y;
          dz -= into * length * over.z;
        }
        combed(x, y, z, style);
        const kept = Math.max(hold, Math.exp(-along / ground.kept) * (1 - smoothstep(12, 40, over.height)));
        const now = norm(dx, dy, dz) || 1;
        const out = 0.75 * coiled * (1 - smoothstep(20, 60, over.height));
        const drawn = (1 - kept) * inward(y);
        const [tx, ty, tz] = [
          kept * way[0] + (out - drawn) * over.x,
          kept * way[1] - (1 - kept) * heavy + out * over.y,
          kept * way[2] + (out - drawn) * over.z,
        ];
        dx = (dx / now) * (1 - bent) + tx * bent;
        dy = (dy / now) * (1 - bent) + ty * bent;
        dz = (dz / now) * (1 - bent) + tz * bent;
        paths[o + 3 * s] = x;
        paths[o + 3 * s + 1] = y;
        paths[o + 3 * s + 2] = z;
        fallen[o / 3 + s] = down(x, y, z);
        holds[o / 3 + s] = hold;
        const ahead = norm(dx, dy, dz) || 1;
        const [ux, uy, uz] = [dx / ahead, dy / ahead, dz / ahead];
        const back = bx * ux + by * uy + bz * uz;
        bx -= back * ux;
        by -= back * uy;
        bz -= back * uz;
        const wide = norm(bx, by, bz) || 1;
        bx /= wide;
        by /= wide;
        bz /= wide;
        aside.set([bx, by, bz], o + 3 * s);
        away.set([by * uz - bz * uy, bz * ux - bx * uz, bx * uy - by * ux], o + 3 * s);
        if (cut[n] === 1 && isCut(x, y, z, lock.lean[0])) cut[n] = (s - 0.5) / STEPS;
      }
      // Where hair is held it goes round what the head turns by in a corner.
      if (holds[o / 3 + STEPS - 1] > 0) {
        for (let pass = 0; pass < ROUNDED; pass++) {
          for (let k = o + 3; k < o + 3 * STEPS; k++) paths[k] = (paths[k - 3] + 2 * paths[k] + paths[k + 3]) / 4;
        }
      }
    });
  }

  /**
   * @param {S} style
   * @returns {Grown}
   */
  function grow(style) {
    // Rolled up it reaches less far.
    const long = ground.long(style) * (1 - 0.5 * style.curl ** 2);
    draped = smoothstep(40, 100, long);
    growLocks(style, long);
    const { curl } = style;
    const points = new Float32Array(3 * POINTS * strands.length);
    const outward = new Float32Array(points.length);
    const open = new Float32Array(points.length / 3);
    const breadth = new Float32Array(open.length);
    const ends = new Float32Array(strands.length);
    const deep = 3 + 0.6 * volumeOf(style, long);
    // Short hair hides little of the light.
    const least = clamp(1 - long / 90, 0, 0.85);
    // Waves, then curls, then coils, each of as many points as make it round.
    const wave = 12 + 62 * (1 - curl) ** 1.3 + 0.3 * Math.max(0, long - 40) * curl;
    const swing = curl * Math.min(7, (0.1 + 0.1 * curl ** 3) * wave + 0.015 * long) * Math.min(1, long / 30);
    const gather = (0.42 + 0.9 * curl * (1 - curl)) * (0.5 + 0.5 * smoothstep(30, 90, long));
    // How far waves go by how far down they are, as a comb or a neighbour lays them, and not by their own length.
    const together = 0.75 * (1 - curl * curl);
    const evenly = even(style);
    const p = [0, 0, 0];
    strands.forEach((strand, n) => {
      const own = locks[strand.lock];
      const root = locks[strand.lock].at;
      const from = 3 * (STEPS + 1) * strand.lock;
      const phase = 1.1 * Math.sin(root[0] / 34 + root[2] / 45) + 0.9 * Math.sin(root[1] / 39 - root[2] / 31);
      // Nothing lies over roots along the line or where hair parts.
      const parted = (early(root[0], root[1], root[2], style) / EARLIEST) * (1 - curl * curl);
      const seen = Math.max(1 - smoothstep(0, BEHIND / MARGIN, strand.inside), smoothstep(0.2, 0.8, parted));
      const end = Math.min(strand.long, cut[strand.lock] + 0.02 * strand.stray[0]);
      ends[n] = 1 - (strand.rise < 0.5 ? BLUNT : 0) * evenly * holds[from / 3 + Math.round(end * STEPS)];
      for (let s = 0; s < POINTS; s++) {
        const t = (end * s) / (POINTS - 1);
        const along = t * reachOf[strand.lock];
        const at = Math.min(STEPS - 0.001, t * STEPS);
        const i = Math.floor(at);
        // Locks are wide at their roots and gather to their tips, but for those that lie side by side in a line.
        const loose = 1 - (strand.rise < 0.5 ? 0.8 : 0.35) * evenly * holds[i + from / 3];
        const wide = 1 - loose * gather * smoothstep(4, 70 - 40 * curl, along);
        const stray = loose * Math.min(7, 0.075 * along);
        // Waves of neighbours go along with each other, and each curl goes its own way.
        const fall = fallen[i + from / 3] + (fallen[i + 1 + from / 3] - fallen[i + from / 3]) * (at - i);
        const turn = (2 * Math.PI * (along + (fall - along) * together)) / wave + phase + own.turn * (0.3 + 3 * curl ** 3) + strand.turn * (0.25 + 0.6 * curl);
        for (let k = 0; k < 3; k++) {
          const path = paths[from + 3 * i + k] + (paths[from + 3 * i + 3 + k] - paths[from + 3 * i + k]) * (at - i);
          p[k] = path + (strand.at[k] - root[k]) * wide + strand.stray[k] * stray;
        }
        const swung = swing * smoothstep(2, 30, along) * (1 - 0.5 * held(p[0], p[1], p[2], style));
        if (swung > 0) {
          const sideways = swung * Math.cos(turn);
          // Out from where it lies, and never into it.
          const outwards = swung * (0.2 + 0.8 * curl) * (0.4 + 0.6 * smoothstep(40, 130, fall)) * (1 + own.hand * Math.sin(turn));
          for (let k = 0; k < 3; k++) {
            const o = from + 3 * i + k;
            p[k] += sideways * (aside[o] + (aside[o + 3] - aside[o]) * (at - i)) + outwards * (away[o] + (away[o + 3] - away[o]) * (at - i));
          }
        }
        look(p[0], p[1], p[2]);
        const clear = Math.min(0.4 * along, 1 + 1.5 * strand.rise);
        const most = highest(style, held(p[0], p[1], p[2], style)) + 1.5 * strand.rise;
        if ((over.height < clear || over.height > Math.max(clear, most)) && s > 0) {
          const pushed = (over.radius + (over.height < clear ? Math.min(clear, over.height + along) : most + 0.4 * (over.height - most))) / (over.radius + over.height);
          for (let k = 0; k < 3; k++) p[k] = middle[k] + (p[k] - middle[k]) * pushed;
        }
        const point = POINTS * n + s;
        open[point] = clamp((over.height - 1) / deep, Math.max(least, LIGHT * seen * (1 - smoothstep(0.4 * LIT, LIT, along))), 1);
        breadth[point] = 1 - (1 - FINEST) * seen * (1 - smoothstep(0, Math.min(BROADENS, 0.4 * reachOf[strand.lock]), along));
        for (let k = 0; k < 3; k++) points[3 * point + k] = p[k];
        outward[3 * point] = over.x;
        outward[3 * point + 1] = over.y;
        outward[3 * point + 2] = over.z;
      }
    });
    return { points, outward, open, breadth, ends, anchors: anchor() };
  }
  return {
    strands: strands.length,
    locks: locks.length,
    lockOf: Uint16Array.from(strands, ({ lock }) => lock),
    parts: Uint8Array.from(strands.flatMap(({ part }) => part), Math.round),
    grow,
  };
}

/**
 * How far each anchor has moved from where it is at rest.
 * @param {Anchors} anchors @param {ArrayLike<number>} positions of the head, mm @param {Float32Array} into 4 an anchor
 */
export function shiftsOf({ places, corners, weights }, positions, into) {
  for (let n = 0; n < places.length / 3; n++) {
    for (let k = 0; k < 3; k++) {
      let sum = -places[3 * n + k];
      for (let i = 3 * n; i < 3 * n + 3; i++) sum += weights[i] * positions[3 * corners[i] + k];
      into[4 * n + k] = sum;
    }
  }
}

/**
 * Where locks go along with the head: at rest, mm, and on three vertices with a weight each. `ANCHORS` times all locks, from the roots on.
 * @typedef {{ places: Float32Array<ArrayBuffer>, corners: Uint32Array<ArrayBuffer>, weights: Float32Array<ArrayBuffer> }} Anchors
 */
/**
 * What a style gives: the points of each strand from root to tip, mm, the way out of the head there, how near the
 * outside of the hair they are, 0 to 1, and how much of its breadth the strand has there; and of each strand how much of a hair it is,
 * from the root on, 1 when it ends in a point.
 * @typedef {{ points: Float32Array, outward: Float32Array, open: Float32Array, breadth: Float32Array, ends: Float32Array, anchors: Anchors }} Grown
 */
/**
 * What does not depend on a style: how many strands and locks there are, the lock of each strand, and which parts its root is of.
 * @typedef {{
 *   strands: number, locks: number, lockOf: Uint16Array<ArrayBuffer>, parts: Uint8Array<ArrayBuffer>,
 * }} Planted
 */
/**
 * @template {Curled} S
 * @typedef {Planted & { grow: (style: S) => Grown }} Hair
 */
