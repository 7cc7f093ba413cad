import { Vector3 } from 'three';
import { standOn } from '../glasses/fit.js';
import { eyeballsOn, eyeVerticesOf } from '../head/eyeballs.js';
import { weighted } from '../head/head.js';

/**
 * How glasses stand on a face of the model.
 * @param {import('phiz').FaceModel} model @param {string} code of the face
 * @returns {import('../glasses/fit.js').Stand | null} null for a model without eyes, or without what is beside them
 */
export function standOnFace(model, code) {
  const face = model.fromCode(code);
  try {
    const positions = face.positions.slice();
    const vertices = eyeVerticesOf(model, positions);
    const [right, left, nose] = ['ibug_00', 'ibug_16', 'ibug_27'].map((name) => model.landmarks.find((one) => one.name === name));
    if (vertices.length !== 2 || !right || !left || !nose) return null;
    const aside = (/** @type {typeof right} */ { stencil }) => weighted(positions, stencil, new Vector3()).x;
    return standOn(eyeballsOn(vertices, positions), aside(left) - aside(right), aside(nose));
  } finally {
    face.free();
  }
}
