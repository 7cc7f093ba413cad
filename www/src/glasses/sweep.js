// Bodies that a rounded section is drawn along a way to.

/** @typedef {[number, number, number]} Point */
/**
 * A station of a way: where it is, the two axes of the section, which are unit and upright to the way and to each other so that `u` times `v`
 * points along it, and half of how wide the section is along each, mm; whether it is rather square than round.
 * @typedef {{ at: Point, u: Point, v: Point, a: number, b: number, square?: boolean }} Station
 */
/** What bodies are gathered in. @typedef {{ positions: number[], normals: number[], triangles: number[] }} Body */

/** @returns {Body} */
export const empty = () => ({ positions: [], normals: [], triangles: [] });

/** Points around a section. */
export const AROUND = 12;

/** The points of a section of half size 1, and by what normals go from there. @param {number} square 2 is an ellipse, and more is squarer */
const sectionOf = (square) =>
  Array.from({ length: AROUND }, (_, j) => {
    // Three to a corner, which is where it bends.
    const angle = (Math.PI / 2) * Math.floor(j / 3) + Math.PI / 4 + ((j % 3) - 1) * (square > 3 ? 0.36 : Math.PI / 6);
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const on = (/** @type {number} */ x, /** @type {number} */ power) => Math.sign(x) * Math.abs(x) ** power;
    return { x: on(cos, 2 / square), y: on(sin, 2 / square), nx: on(cos, 2 - 2 / square), ny: on(sin, 2 - 2 / square) };
  });
const ROUND = sectionOf(2.2);
const SQUARE = sectionOf(4.5);

/**
 * Writes the rings of a way: plain numbers, as arms are drawn anew with every event of a drag.
 * @param {readonly Station[]} way @param {Float32Array} positions @param {Float32Array} normals @param {number} [o] where they begin
 */
export function rings(way, positions, normals, o = 0) {
  for (const { at: [x, y, z], u: [ux, uy, uz], v: [vx, vy, vz], a, b, square } of way) {
    const section = square ? SQUARE : ROUND;
    for (let j = 0; j < AROUND; j++, o += 3) {
      const one = section[j];
      const p = a * one.x;
      const q = b * one.y;
      positions[o] = x + p * ux + q * vx;
      positions[o + 1] = y + p * uy + q * vy;
      positions[o + 2] = z + p * uz + q * vz;
      // A section that is nothing has normals all the same.
      const m = one.nx * (b + 1e-6);
      const n = one.ny * (a + 1e-6);
      const size = 1 / Math.sqrt(m * m + n * n);
      normals[o] = size * (m * ux + n * vx);
      normals[o + 1] = size * (m * uy + n * vy);
      normals[o + 2] = size * (m * uz + n * vz);
    }
  }
  return o;
}

/** The triangles between rings. @param {number} many rings @param {boolean} closed whether the last one is followed by the first @param {number[]} triangles @param {number} first corner */
export function weave(many, closed, triangles, first) {
  for (let i = 0; i < (closed ? many : many - 1); i++) {
    const [here, next] = [first + i * AROUND, first + ((i + 1) % many) * AROUND];
    for (let j = 0; j < AROUND; j++) {
      const k = (j + 1) % AROUND;
      triangles.push(here + j, here + k, next + j, here + k, next + k, next + j);
    }
  }
  if (closed) return;
  // Rounded ends are as good as points: a fan closes them.
  const end = first + (many - 1) * AROUND;
  for (let j = 2; j < AROUND; j++) triangles.push(first, first + j, first + j - 1, end, end + j - 1, end + j);
}

/** @param {Body} body @param {readonly Station[]} way @param {boolean} [closed] */
export function sweep(body, way, closed = false) {
  const first = body.positions.length / 3;
  const [positions, normals] = [new Float32Array(3 * AROUND * way.length), new Float32Array(3 * AROUND * way.length)];
  rings(way, positions, normals);
  body.positions.push(...positions);
  body.normals.push(...normals);
  weave(way.length, closed, body.triangles, first);
}

/** The same way with ends that are rounded over so many mm. @param {readonly Station[]} way @param {readonly [number, number]} over at the first and at the last end; 0 leaves one as it is */
export function rounded(way, over) {
  const done = [...way];
  for (const [side, reach] of over.entries()) {
    if (reach <= 0) continue;
    const end = side ? done[done.length - 1] : done[0];
    const next = side ? done[done.length - 2] : done[1];
    const ahead = unit(minus(end.at, next.at));
    const caps = [0.25, 0.5, 0.7, 0.85, 0.95, 1].map((t) => {
      const left = Math.max(0.02, Math.sqrt(1 - t * t));
      return { ...end, at: plus(end.at, ahead, (t - 1) * reach), a: end.a * left, b: end.b * left };
    });
    // What lay where the end is rounded goes.
    const stays = (/** @type {Station} */ one) => dot(minus(end.at, one.at), ahead) > reach;
    if (side) {
      while (done.length > 1 && !stays(done[done.length - 1])) done.pop();
      done.push({ ...end, at: plus(end.at, ahead, -reach) }, ...caps);
    } else {
      while (done.length > 1 && !stays(done[0])) done.shift();
      done.unshift(...caps.reverse(), { ...end, at: plus(end.at, ahead, -reach) });
    }
  }
  return done;
}

/** @param {Point} a @param {Point} b @returns {Point} */
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** @param {Point} a @param {Point} b @param {number} t @returns {Point} */
export const plus = (a, b, t = 1) => [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];
/** @param {Point} a @param {Point} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {Point} a @param {Point} b @returns {Point} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {Point} a @returns {Point} */
export function unit(a) {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
}

/**
 * Stations along points, with one axis of the section as near as can be to a way that is given.
 * @param {readonly Point[]} points @param {Point} near the second axis is as near as can be to this @param {(i: number) => readonly [number, number]} half sizes along both axes @param {boolean} [square]
 * @returns {Station[]}
 */
export function along(points, near, half, square = false) {
  return points.map((at, i) => {
    const way = unit(minus(points[Math.min(points.length - 1, i + 1)], points[Math.max(0, i - 1)]));
    const v = unit(plus(near, way, -dot(near, way)));
    const [a, b] = half(i);
    return { at, u: cross(v, way), v, a, b, square };
  });
}
