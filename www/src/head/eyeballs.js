import { Vector3 } from 'three';
import { fitSphere } from './eyes.js';

/** The vertices of a model's eyeballs, the subject's right one's first. @param {import('phiz').FaceModel} model @param {ArrayLike<number>} positions of any of its faces */
export function eyeVerticesOf(model, positions) {
  const corners = model.uvVertices;
  const triangles = model.triangles;
  return model.parts
    .filter(({ name }) => EYEBALL.test(name))
    .map(({ first, count }) => [...new Set(Array.from(triangles.subarray(3 * first, 3 * (first + count)), (corner) => corners[corner]))])
    .sort((a, b) => positions[3 * a[0]] - positions[3 * b[0]]);
}

/** The parts of a model that are those. */
export const EYEBALL = /eyeball/;

/** Where they are on a face, mm. @param {number[][]} vertices of each @param {Float32Array} positions */
export function eyeballsOn(vertices, positions) {
  return vertices.map((own) => {
    const centre = new Vector3();
    return { centre, radius: fitSphere(positions, own, centre) };
  });
}
