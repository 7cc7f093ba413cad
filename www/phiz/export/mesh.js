import { checkColours } from './checks.js';

/**
 * A face as it is now, copied out of wasm memory.
 *
 * @typedef {object} Mesh
 * @property {Float32Array} positions mm, three a vertex
 * @property {Float32Array} normals unit, three a vertex
 * @property {Uint8Array | Uint8ClampedArray} colours sRGB, three a vertex
 * @property {Float32Array} uvs two a corner, (0, 0) at the lower left
 * @property {Uint32Array} corners the vertex of each corner
 * @property {Uint32Array} triangles three corners a triangle
 * @property {readonly import('phiz').Part[]} parts
 */

/**
 * @param {import('phiz').Face} face
 * @param {Uint8Array | Uint8ClampedArray} [colours] sRGB, three a vertex: the model's own when absent
 * @returns {Mesh}
 */
export function meshOf(face, colours) {
  needFace(face);
  const { model } = face;
  if (colours !== undefined) checkColours(colours, model.vertexCount);
  return {
    positions: face.positions.slice(),
    normals: face.normals.slice(),
    colours: colours ?? model.colours,
    uvs: model.uvs,
    corners: model.uvVertices,
    triangles: model.triangles,
    parts: model.parts,
  };
}

/**
 * Faces come from another module, of which a page may have two: one is known by what it has.
 * @param {import('phiz').Face} face
 */
export function needFace(face) {
  if (typeof face !== 'object' || !face || !('positions' in face && 'model' in face)) throw new TypeError('what is exported must be a Face of phiz: `model.face()` makes one');
}

/** What a file says of where it comes from, a line each. @param {import('phiz').FaceModel} model */
export function provenance({ about }) {
  const sources = about.licences.map(({ source, by, licence }) => `${source}, ${by} (${licence})`);
  return [about.title, about.made_by, ...sources].map((line) => line.replace(/\s+/g, ' ').trim());
}
