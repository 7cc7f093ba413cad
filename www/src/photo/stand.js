import { standOn } from '../glasses/fit.js';
import { eyeballsOn, eyeVerticesOf } from '../head/eyeballs.js';
import { atRest } from '../head/head.js';

/**
 * How glasses stand on a face of the model.
 * @param {import('phiz').FaceModel} model @param {string} code of the face
 * @returns {import('../glasses/fit.js').Stand | null} null for a model without eyes, or without what is beside them
 */
export function standOnFace(model, code) {
  const face = model.fromCode(code);
  const { positions, landmarks } = atRest(model, face);
  face.free();
  const eyes = eyeVerticesOf(model, positions);
  const [right, left, nose] = ['ibug_00', 'ibug_16', 'ibug_27'].map((name) => landmarks.get(name));
  if (eyes.length !== 2 || !right || !left || !nose) return null;
  return standOn(eyeballsOn(eyes, positions), left[0] - right[0], nose[0]);
}
