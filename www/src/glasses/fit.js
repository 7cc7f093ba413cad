import { ANGLES } from './frame.js';
import { mix } from './style.js';

// Where a pair of glasses sits on a head: before the eyes, on the bridge of the nose and on the ears, and clear of the skin.

/** From the cornea to the back of a lens, mm: what opticians fit to. */
const VERTEX = 12.5;
/** How far lenses lean: their lower edge is nearer to the face. */
const TILT = (8 * Math.PI) / 180;
/** A cornea is so much farther from the middle of the eyeball than its radius. */
const CORNEA = 1.09;
/** The faces that sizes of glasses are of: between the pupils, and across the face before the ears, mm. */
const USUAL = { pupils: 63, across: 148 };
const SMALLEST = 0.84;
const LARGEST = 1.18;
/** Where lenses end below, where they end above, and beside the eyes: what of the skin may come near a front, mm from the middle of the eyes. */
const NEAR_FRONT = { down: 46, up: 36, aside: 62, back: 2 };
/** Eyes and what is right beside them are behind the lenses of any glasses: they need not be looked at. */
const EYES = { down: 9, up: 8, inner: 19 };
/** How far the front stays off the skin: its rims, its lenses, and the bridge, which lies on the nose; mm. */
const OFF = { rim: 0.6, nose: 0.4, lens: 1.6, bridge: 0.35, arm: 0.9, behind: 0.6 };
/** For a broad nose lenses go so far aside of the pupils at most, and so far up, before they go ahead, mm. */
const ASIDE = 6;
const UP = 3.5;
/**
 * Skin beside what is over it lets that come the nearer the farther beside it is: the front for each mm so many, up to so far, and arms two. What would matter on one side of
 * an edge alone would make glasses jump when it comes over it.
 */
const STEEP = 4;
const EDGE = 3;

/** Stations of an arm to where it bends, and behind. */
const STRAIGHT = 15;
const BENT = 16;
export const STATIONS = STRAIGHT + BENT;

/** @typedef {import('./sweep.js').Point} Point */
/** @typedef {{ centre: { x: number, y: number, z: number }, radius: number }} Eye */

/**
 * How thick an arm is on its way, half of it, mm.
 * @param {import('./style.js').Style} style @param {number} i station
 * @returns {readonly [aside: number, up: number]}
 */
export function armHalf({ plastic, rim, isRimless }, i) {
  const way = Math.min(1, i / (STRAIGHT - 1));
  const tip = Math.min(1, Math.max(0, (i - STRAIGHT + 3) / 8));
  const begin = 1 - Math.min(1, way * 3);
  const aside = mix(0.6 + 0.1 * begin, mix(1.35, 1.75, begin), plastic);
  const up = mix((isRimless ? 0.75 : 0.9) + 0.25 * begin, mix(2.3, 1.7 + 0.42 * rim, begin), plastic);
  return [mix(aside, mix(0.6, 1.1, plastic), tip), mix(up, mix(0.75, 2.3, plastic), tip)];
}

/** How an arm bows on its straight way. @param {number} s */
const bowed = (s) => Math.sin(Math.PI * Math.min(1, Math.max(0, s))) ** 0.8;

/**
 * Before which eyes glasses stand, and how: how large they are, where their axes point, as columns, how far the pupils are apart in their mm, and the point
 * between the corneas before which the middle of the front is, mm of the head. The nose moves them ahead.
 * @typedef {{ scale: number, axes: readonly [Point, Point, Point], pupils: number, eyes: Point }} Stand
 */
/**
 * @param {readonly Eye[]} eyes the subject's right first @param {number} across the face before the ears, mm @param {number} nose where its root is to the subject's left, mm
 * @returns {Stand}
 */
export function standOn([right, left], across, nose) {
  const [a, b] = [left.centre, right.centre];
  const pupils = Math.hypot(a.x - b.x, a.y - b.y);
  const scale = Math.min(LARGEST, Math.max(SMALLEST, 0.5 * (pupils / USUAL.pupils) + 0.5 * (across / USUAL.across)));
  const roll = Math.atan2(a.y - b.y, a.x - b.x);
  const [cr, sr, ct, st] = [Math.cos(roll), Math.sin(roll), Math.cos(TILT), Math.sin(TILT)];
  return {
    scale,
    axes: [[cr, sr, 0], [-sr * ct, cr * ct, st], [sr * st, -cr * st, ct]],
    pupils: pupils / scale,
    eyes: [0.6 * ((a.x + b.x) / 2) + 0.4 * nose, (a.y + b.y) / 2, Math.max(a.z + CORNEA * left.radius, b.z + CORNEA * right.radius)],
  };
}

/**
 * Finds once what of a head matters for how glasses sit on it.
 * @param {{
 *   rest: Float32Array, normals: Float32Array, skin: Iterable<number>, mirror: ArrayLike<number>, scalp: ArrayLike<number>,
 *   at: import('../groundwork/paint.js').Points, vertexOf: (landmark: string) => number, eyes: readonly Eye[],
 * }} head at rest; `skin` are the vertices of it that are seen, `scalp` is positive where hair grows; the eyes are the subject's right first
 */
export function createFit({ rest, normals, skin, mirror, scalp, at, vertexOf, eyes }) {
  const need = (/** @type {string} */ name) => {
    const point = at.get(name);
    if (!point) throw new Error(`no landmark is called "${name}"`);
    return point;
  };
  const [right, left] = eyes;
  const middle = { y: (left.centre.y + right.centre.y) / 2, z: (left.centre.z + right.centre.z) / 2 };
  const [above, behind, root] = ['superaurale left', 'postaurale left', 'helix root left'].map(need);
  /** Left ones, and theirs on the other side. @param {(x: number, y: number, z: number, n: Float32Array) => boolean} is */
  const pick = (is) => {
    const found = [...new Set(skin)].filter((v) => rest[3 * v] >= 0 && is(rest[3 * v], rest[3 * v + 1], rest[3 * v + 2], normals.subarray(3 * v, 3 * v + 3)));
    return [Uint32Array.from(found), Uint32Array.from(found, (v) => mirror[v])];
  };
  const front = pick((x, y, z) => y > middle.y - NEAR_FRONT.down && y < middle.y + NEAR_FRONT.up && x < NEAR_FRONT.aside && z > middle.z - NEAR_FRONT.back && (x < EYES.inner || y > middle.y + EYES.up || y < middle.y - EYES.down));
  /** The side of the nose, below its root. */
  const flank = pick((x, y, z, [nx, , nz]) => x > 3 && x < 15 && y > middle.y - 22 && y < middle.y + 1 && z > middle.z + 7 && nx > 0.35 && nz > 0.1);
  // What stands off the head here is the ear, behind which the head is seen again.
  const isHead = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ z, /** @type {number} */ nx) => nx > 0.2 && (z > root[2] + 2 || x < root[0] + 0.4) && (z > root[2] - 2 || y > above[1] - 7 || z < behind[2] + 7);
  const side = pick((x, y, z, [nx]) => x > 40 && isHead(x, y, z, nx) && z > root[2] - 16 && z < middle.z + 4 && y > middle.y - 22 && y < middle.y + 34);
  const back = pick((x, y, z, [nx]) => nx > 0.75 && isHead(x, y, z, nx) && z < root[2] - 2 && z > behind[2] - 24 && y < above[1] + 6 && y > above[1] - 52);
  /** What an arm rests on: where the ear grows out of the head. */
  const rests = pick((x, y, z, [, ny]) => ny > 0.25 && x > root[0] - 2.5 && x < root[0] + 4 && z < root[2] + 2 && z > above[2] - 4 && y > above[1] - 5 && y < above[1] + 3);
  /** The nearest vertex of some to a place. @param {readonly Uint32Array[]} some @param {Point} place */
  const nearest = (some, [x, y, z]) => {
    let best = 0;
    let least = Infinity;
    some[0].forEach((v, i) => {
      const far = (rest[3 * v] - x) ** 2 + (rest[3 * v + 1] - y) ** 2 + (rest[3 * v + 2] - z) ** 2;
      if (far < least) [best, least] = [i, far];
    });
    return [some[0][best], some[1][best]];
  };
  const crest = nearest(side, [root[0] - 1.5, above[1] - 0.5, above[2] + 4]);
  // Behind the ear and a little below its middle.
  const tip = nearest(back, [root[0] - 12, above[1] - 35, behind[2] - 8]);
  const [ear, otherEar] = [vertexOf('ibug_16'), vertexOf('ibug_00')];
  const nose = vertexOf('ibug_27');

  /** The plane of one side of the nose: z = a + b |x - x0| + e y. @param {ArrayLike<number>} p @param {Uint32Array} of @param {number} x0 */
  function plane(p, of, x0) {
    let [n, sx, sy, sz, sxx, sxy, syy, sxz, syz] = [0, 0, 0, 0, 0, 0, 0, 0, 0];
    for (const v of of) {
      const [x, y, z] = [Math.abs(p[3 * v] - x0), p[3 * v + 1], p[3 * v + 2]];
      n += 1;
      sx += x;
      sy += y;
      sz += z;
      sxx += x * x;
      sxy += x * y;
      syy += y * y;
      sxz += x * z;
      syz += y * z;
    }
    const [xx, xy, yy, xz, yz] = [sxx - (sx * sx) / n, sxy - (sx * sy) / n, syy - (sy * sy) / n, sxz - (sx * sz) / n, syz - (sy * sz) / n];
    const d = xx * yy - xy * xy;
    // Never so flat that nothing would rest on it.
    const b = Math.min(-0.5, (xz * yy - yz * xy) / d);
    const e = (yz - b * xy) / yy;
    return { a: (sz - b * sx - e * sy) / n, b, e };
  }

  /**
   * @param {ArrayLike<number>} p positions of a face of the model, mm
   * @param {readonly Eye[]} both eyes of it, the subject's right first
   * @param {import('./style.js').Style} style @param {import('./frame.js').Front} made
   * @param {number} lift how far off the skin hair that is cropped is, mm
   */
  function fit(p, both, style, made, lift) {
    const { scale, axes, pupils, eyes: eyesAt } = standOn(both, p[3 * ear] - p[3 * otherEar], p[3 * nose]);
    const [X, Y, Z] = axes;
    const [ct, st] = [Math.cos(TILT), Math.sin(TILT)];
    const x0 = eyesAt[0];
    // Pupils are above the middle of lenses, the more so the higher these are.
    const sunk = scale * (0.6 + 0.07 * style.height);
    const origin = /** @type {Point} */ ([x0, eyesAt[1] - sunk, eyesAt[2]]);

    // A broad nose wants lenses apart, as far as eyes are still behind their middles.
    const planes = [plane(p, flank[0], x0), plane(p, flank[1], x0)];
    let wanted = pupils / 2 + 0.5;
    for (const { x, y, z } of made.noseSide) {
      // As it leans.
      const [high, deep] = [origin[1] + scale * (ct * y - st * z), eyesAt[2] + VERTEX + 2 * scale + scale * (st * y + ct * z)];
      for (const { a, b, e } of planes) wanted = Math.max(wanted, ((deep - a - e * high) / b + OFF.nose) / scale - x);
    }
    const least = style.width / 2 + Math.max(6.2, 4.2 + style.rim);
    const most = Math.max(least, pupils / 2 + ASIDE + Math.max(0, style.width - 50) / 2);
    const aside = Math.max(least, Math.min(wanted, most)) - made.centre;
    origin[1] += scale * Math.min(UP, Math.max(0, wanted - most));
    const centre = made.centre + aside;

    // As far ahead as opticians have it, and as all of the skin needs.
    const pupil = made.lensBack(pupils / 2 - centre, (eyesAt[1] - origin[1]) / scale) * scale;
    let ahead = VERTEX - pupil;
    const half = { x: style.width / 2 + style.rim + EDGE + 3, y: style.height / 2 + style.rim + EDGE + 3 };
    const { bridge } = made;
    // Of rim and lens what is farther back, which is the same everywhere.
    const off = Math.max(OFF.rim, OFF.lens + made.back(0, 0) - made.lensBack(0, 0));
    const bridged = bridge.reach + aside;
    const [ox, oy, oz] = origin;
    const [zx, zy, zz] = Z;
    // With every event of a drag, of a thousand vertices a side: plain numbers.
    for (const list of front) {
      for (let i = 0; i < list.length; i++) {
        const o = 3 * list[i];
        const dx = p[o] - ox;
        const dy = p[o + 1] - oy;
        const dz = p[o + 2] - oz;
        const z = zx * dx + zy * dy + zz * dz;
        // The front is nowhere farther back than this.
        if (z + 14 * scale < ahead) continue;
        const x = (X[0] * dx + X[1] * dy) / scale;
        const y = (Y[0] * dx + Y[1] * dy + Y[2] * dz) / scale;
        const far = Math.abs(x);
        const u = far - centre;
        if (far < bridged + EDGE) {
          const round = 1 - (far / bridged) ** 2;
          const over = Math.max(0, Math.abs(y - bridge.y - bridge.arch * round) - bridge.half) + Math.max(0, far - bridged);
          if (over < EDGE) ahead = Math.max(ahead, z - scale * (bridge.back + bridge.bulge * round) + OFF.bridge - STEEP * over);
        }
        if (Math.abs(u) > half.x || Math.abs(y) > half.y) continue;
        const turn = ((Math.atan2(y, u) / (2 * Math.PI)) * ANGLES + ANGLES) % ANGLES;
        const at = Math.floor(turn);
        const edge = made.reach[at] + (turn - at) * (made.reach[(at + 1) % ANGLES] - made.reach[at]);
        const over = Math.max(0, Math.hypot(u, y) - edge);
        if (over < EDGE) ahead = Math.max(ahead, z - scale * made.back(u, y) + off - STEEP * over);
      }
    }
    for (let k = 0; k < 3; k++) origin[k] += ahead * Z[k];
    /** @param {number} x @param {number} y @param {number} z of the front's axes @returns {Point} */
    const place = (x, y, z) => [
      origin[0] + scale * (X[0] * x + Y[0] * y + Z[0] * z),
      origin[1] + scale * (X[1] * x + Y[1] * y + Z[1] * z),
      origin[2] + scale * (Y[2] * y + Z[2] * z),
    ];
    const arms = [0, 1].map((other) => armOn(p, other, place, scale, aside, style, made, lift));
    const pads = planes.map((one, other) => padOn(one, other ? -1 : 1, x0, place, aside, made, style.plastic > 0.5));
    return { scale, axes, origin, aside, arms, pads, ahead };
  }

  /** Where an arm goes. @param {ArrayLike<number>} p @param {number} other 0 for the left one @param {(x: number, y: number, z: number) => Point} place @param {number} scale @param {number} aside @param {import('./style.js').Style} style @param {import('./frame.js').Front} made @param {number} lift @returns {Point[]} */
  function armOn(p, other, place, scale, aside, style, made, lift) {
    const way = other ? -1 : 1;
    const [hx, hy, hz] = place(way * (made.hinge[0] + aside), made.hinge[1], made.hinge[2] - 0.1);
    const [halfAside, halfUp] = armHalf(style, STRAIGHT - 1);
    const from = way * hx;
    const k = 3 * crest[other];
    const bendZ = p[k + 2];
    let bendY = p[k + 1] + halfUp;
    const long = hz - bendZ;
    const list = side[other];
    const raised = (/** @type {number} */ v) => (scalp[v] > 0 ? lift * Math.min(1, 2 * scalp[v]) : 0);
    // Where the ear begins it lies on the head, on the root of the ear.
    let bend = way * p[k] + halfAside + OFF.arm;
    for (let i = 0; i < list.length; i++) {
      const o = 3 * list[i];
      const s = (hz - p[o + 2]) / long;
      const beside = 2 * Math.max(0, Math.abs(p[o + 1] - bendY) - halfUp) + long * Math.max(0, 0.88 - s, s - 1.1);
      if (beside < EDGE) bend = Math.max(bend, way * p[o] + halfAside + OFF.arm + raised(list[i]) - beside);
    }
    const on = rests[other];
    let top = -Infinity;
    for (let i = 0; i < on.length; i++) {
      const o = 3 * on[i];
      const beside = Math.max(0, Math.abs(way * p[o] - bend) - halfAside);
      if (beside < EDGE) top = Math.max(top, p[o + 1] - 2 * beside);
    }
    if (top > -Infinity) bendY = top + halfUp + OFF.behind;
    let bow = 0;
    const highest = armHalf(style, 0)[1] + EDGE;
    for (let i = 0; i < list.length; i++) {
      const o = 3 * list[i];
      const s = (hz - p[o + 2]) / long;
      // Nearer to the bend that goes out as far as it has to.
      if (s < 0.05 || s > 0.9) continue;
      const off = Math.abs(p[o + 1] - hy - s * (bendY - hy));
      if (off > highest) continue;
      const [thick, high] = armHalf(style, s * (STRAIGHT - 1));
      bow = Math.max(bow, (way * p[o] + thick + OFF.arm + raised(list[i]) - 2 * Math.max(0, off - high) - from - s * (bend - from)) / bowed(s));
    }
    /** @type {Point[]} */
    const points = [];
    for (let i = 0; i < STRAIGHT; i++) {
      const s = i / (STRAIGHT - 1);
      points.push([way * (from + s * (bend - from) + bow * bowed(s)), hy + s * (bendY - hy), hz - s * long]);
    }

    // It bends down behind the ear and lies on the head there.
    const t = 3 * tip[other];
    const slope = (bendY - hy) / long;
    const reach = 15 * scale;
    const ys = [bendY, bendY + slope * reach, p[t + 1] + 24 * scale, p[t + 1]];
    const zs = [bendZ, bendZ - reach, p[t + 2] + 5.5 * scale, p[t + 2] - 0.5 * scale];
    const bezier = (/** @type {number[]} */ of, /** @type {number} */ u) => {
      const w = 1 - u;
      return w * w * w * of[0] + 3 * w * w * u * of[1] + 3 * w * u * u * of[2] + u * u * u * of[3];
    };
    const drop = Array.from({ length: BENT }, (_, i) => {
      const u = (i + 1) / BENT;
      return { u, y: bezier(ys, u), z: bezier(zs, u), x: -Infinity };
    });
    const skull = back[other];
    for (let i = 0; i < skull.length; i++) {
      const o = 3 * skull[i];
      const [y, z] = [p[o + 1], p[o + 2]];
      for (let n = 0; n < BENT; n++) {
        const one = drop[n];
        const dy = one.y - y;
        const dz = one.z - z;
        const far = dy * dy + dz * dz;
        if (far > 25) continue;
        const [thick, high] = armHalf(style, STRAIGHT + n);
        one.x = Math.max(one.x, way * p[o] + thick + OFF.behind - Math.max(0, Math.sqrt(far) - high));
      }
    }
    const last = drop[BENT - 1];
    const end = last.x > -Infinity ? last.x : way * p[t] + halfAside + OFF.behind;
    // As far out as the head wants it from place to place, without steps.
    const out = drop.map(({ u, x }) => Math.max(x, bend + u * (end - bend)));
    const at = (/** @type {number} */ n) => (n < 0 ? bend : out[Math.min(BENT - 1, n)]);
    const wide = out.map((_, n) => Math.max(at(n - 1), at(n), at(n + 1)));
    const within = (/** @type {number} */ n) => (n < 0 ? bend : wide[Math.min(BENT - 1, n)]);
    drop.forEach(({ y, z }, n) => points.push([(way * (within(n - 1) + 2 * within(n) + within(n + 1))) / 4, y, z]));
    return points;
  }

  /**
   * Where a pad lies on the side of the nose, and how that faces.
   * @param {ReturnType<typeof plane>} on @param {number} way 1 for the left one @param {number} x0 @param {(x: number, y: number, z: number) => Point} place @param {number} aside @param {import('./frame.js').Front} made @param {boolean} isPlastic
   */
  function padOn({ a, b, e }, way, x0, place, aside, made, isPlastic) {
    const from = place(way * (made.nasal.x + aside), made.nasal.y, made.nasal.z);
    const y = from[1] - 1.5;
    const edge = way * (from[0] - x0);
    // Behind the lens, and between it and the ridge of the nose; what is of a piece with the rim is behind that.
    const on = (/** @type {number} */ behind) => (from[2] - behind - a - e * y) / b;
    const x = isPlastic ? Math.min(on(5), Math.max(edge, on(1.5))) : Math.min(edge + 1.5, Math.max(3.5, on(3.4)));
    const long = Math.hypot(b, e, 1);
    const facing = /** @type {Point} */ ([(-way * b) / long, -e / long, 1 / long]);
    return { from, at: /** @type {Point} */ ([x0 + way * x, y, a + b * x + e * y]), facing };
  }

  return {
    fit,
    /** All that it looks at. */
    vertices: [...new Set([...[front, flank, side, back, rests].flatMap((both) => both.flatMap((list) => [...list])), ...crest, ...tip, ear, otherEar, nose])],
  };
}

/** @typedef {ReturnType<ReturnType<typeof createFit>['fit']>} Fitted */
