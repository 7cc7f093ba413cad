import { ByteWriter } from './bytes.js';
import { meshOf } from './mesh.js';

/**
 * Where the mesh is open: the neck, and the lids, behind which an eyeball stands. Each opening as its vertices in the order in
 * which triangles that close it have them; one that meets another in a vertex stays open.
 * @param {Uint32Array} vertices three a triangle
 */
function openings(vertices) {
  /** @type {Set<string>} */
  const edges = new Set();
  const each = (/** @type {(a: number, b: number) => void} */ visit) => {
    for (let t = 0; t < vertices.length; t++) visit(vertices[t], vertices[t % 3 === 2 ? t - 2 : t + 1]);
  };
  each((a, b) => edges.add(`${a} ${b}`));
  /** Against the sense of the triangles that are there. @type {Map<number, number>} */
  const next = new Map();
  const shared = new Set();
  each((a, b) => {
    if (edges.has(`${b} ${a}`)) return;
    if (next.has(b)) shared.add(b);
    next.set(b, a);
  });
  const loops = [];
  while (next.size) {
    const loop = [];
    for (let [v] = next.keys(); next.has(v); ) {
      loop.push(v);
      const to = /** @type {number} */ (next.get(v));
      next.delete(v);
      v = to;
    }
    if (loop.length > 2 && !loop.some((v) => shared.has(v))) loops.push(loop);
  }
  return loops;
}

/** A mesh with its openings closed, each from its middle. @param {Float32Array} positions @param {Uint32Array} vertices three a triangle */
function closed(positions, vertices) {
  const points = Array.from(positions);
  const all = Array.from(vertices);
  for (const loop of openings(vertices)) {
    const middle = points.length / 3;
    for (let k = 0; k < 3; k++) points.push(loop.reduce((sum, v) => sum + positions[3 * v + k], 0) / loop.length);
    loop.forEach((v, i) => all.push(v, loop[(i + 1) % loop.length], middle));
  }
  return { points, all };
}

/**
 * Binary STL, for printers: triangles in mm with their normals, closed at the neck and behind the lids, so that what is inside
 * is told from what is not. z is up, as slicers have it, and the face looks along -y.
 * @param {import('phiz').Face} face
 */
export function toStl(face) {
  const { positions, corners, triangles } = meshOf(face);
  const { points, all } = closed(positions, triangles.map((corner) => corners[corner]));
  const count = all.length / 3;
  const out = new ByteWriter(84 + 50 * count);
  const title = new Uint8Array(80);
  // It must not start with "solid", by which readers know a text file.
  title.set(new TextEncoder().encode('phiz: a face, lengths are millimetres, z is up').subarray(0, 80));
  out.bytes(title);
  out.u32(count);
  const p = new Float64Array(9);
  for (let t = 0; t < all.length; t += 3) {
    for (let k = 0; k < 3; k++) {
      const o = 3 * all[t + k];
      p[3 * k] = points[o];
      p[3 * k + 1] = -points[o + 2];
      p[3 * k + 2] = points[o + 1];
    }
    const [ux, uy, uz] = [p[3] - p[0], p[4] - p[1], p[5] - p[2]];
    const [vx, vy, vz] = [p[6] - p[0], p[7] - p[1], p[8] - p[2]];
    const n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    // A triangle without area has no normal; the format's word for that is zero.
    const length = Math.hypot(...n) || 1;
    for (const x of n) out.f32(x / length);
    for (const x of p) out.f32(x);
    out.u16(0);
  }
  return out.finish();
}
