import { optionsOf } from './checks.js';
import { meshOf, provenance } from './mesh.js';

/**
 * Wavefront OBJ: positions (mm) with colours, texture coordinates, normals, a group a part.
 * @param {import('phiz').Face} face
 * @param {{ colours?: Uint8Array | Uint8ClampedArray }} [options]
 */
export function toObj(face, options) {
  const { colours: given } = optionsOf('toObj', options, ['colours']);
  const { positions, normals, colours, uvs, corners, triangles, parts } = meshOf(face, given);
  const lines = [...provenance(face.model), 'Lengths are millimetres; y is up.'].map((l) => `# ${l}`);
  lines.push('o face');
  for (let i = 0; i < positions.length; i += 3) {
    // A tenth of a micrometre. Colours after the position are what most programs read.
    const at = [0, 1, 2].map((k) => positions[i + k].toFixed(4));
    const colour = [0, 1, 2].map((k) => (colours[i + k] / 255).toFixed(4));
    lines.push(`v ${at.join(' ')} ${colour.join(' ')}`);
  }
  for (let i = 0; i < uvs.length; i += 2) lines.push(`vt ${uvs[i].toFixed(6)} ${uvs[i + 1].toFixed(6)}`);
  for (let i = 0; i < normals.length; i += 3) {
    lines.push(`vn ${[0, 1, 2].map((k) => normals[i + k].toFixed(4)).join(' ')}`);
  }
  for (const { name, first, count } of parts) {
    lines.push(`g ${name.replace(/\s+/g, '_')}`);
    for (let t = 3 * first; t < 3 * (first + count); t += 3) {
      const corner = (/** @type {number} */ c) => `${corners[c] + 1}/${c + 1}/${corners[c] + 1}`;
      lines.push(`f ${corner(triangles[t])} ${corner(triangles[t + 1])} ${corner(triangles[t + 2])}`);
    }
  }
  return new TextEncoder().encode(`${lines.join('\n')}\n`);
}
