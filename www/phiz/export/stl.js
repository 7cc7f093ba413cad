import { ByteWriter } from './bytes.js';
import { meshOf } from './mesh.js';

/**
 * Binary STL, for printers: triangles in mm with their normals. z is up, as slicers have it, and
 * the face looks along -y.
 * @param {import('phiz').Face} face
 */
export function toStl(face) {
  const { positions, corners, triangles } = meshOf(face);
  const count = triangles.length / 3;
  const out = new ByteWriter(84 + 50 * count);
  const title = new Uint8Array(80);
  // It must not start with "solid", by which readers know a text file.
  title.set(new TextEncoder().encode('phiz: a face, lengths are millimetres, z is up').subarray(0, 80));
  out.bytes(title);
  out.u32(count);
  const p = new Float64Array(9);
  for (let t = 0; t < triangles.length; t += 3) {
    for (let k = 0; k < 3; k++) {
      const o = 3 * corners[triangles[t + k]];
      p[3 * k] = positions[o];
      p[3 * k + 1] = -positions[o + 2];
      p[3 * k + 2] = positions[o + 1];
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
