import { ByteWriter } from './bytes.js';
import { optionsOf } from './checks.js';
import { meshOf, provenance } from './mesh.js';

/**
 * Binary PLY, little-endian: positions (mm), normals, colours; the model's vertices in its order.
 * @param {import('phiz').Face} face
 * @param {{ colours?: Uint8Array | Uint8ClampedArray }} [options]
 */
export function toPly(face, options) {
  const { colours: given } = optionsOf('toPly', options, ['colours']);
  const { positions, normals, colours, corners, triangles } = meshOf(face, given);
  const vertices = positions.length / 3;
  const faces = triangles.length / 3;
  const header = new TextEncoder().encode(
    [
      'ply',
      'format binary_little_endian 1.0',
      // Readers take a header for ASCII: letters go without what is above and below them.
      ...provenance(face.model).map((line) => `comment ${line.normalize('NFKD').replaceAll(/\p{M}/gu, '').replaceAll(/[^ -~]/g, '?')}`),
      'comment lengths are millimetres, y is up',
      `element vertex ${vertices}`,
      ...['x', 'y', 'z', 'nx', 'ny', 'nz'].map((name) => `property float ${name}`),
      ...['red', 'green', 'blue'].map((name) => `property uchar ${name}`),
      `element face ${faces}`,
      'property list uchar int vertex_indices',
      'end_header\n',
    ].join('\n'),
  );
  const out = new ByteWriter(header.length + 27 * vertices + 13 * faces);
  out.bytes(header);
  for (let i = 0; i < positions.length; i += 3) {
    for (let k = 0; k < 3; k++) out.f32(positions[i + k]);
    for (let k = 0; k < 3; k++) out.f32(normals[i + k]);
    for (let k = 0; k < 3; k++) out.u8(colours[i + k]);
  }
  for (let t = 0; t < triangles.length; t += 3) {
    out.u8(3);
    for (let k = 0; k < 3; k++) out.u32(corners[triangles[t + k]]);
  }
  return out.finish();
}
