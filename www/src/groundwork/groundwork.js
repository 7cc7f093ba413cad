// What a head is drawn with that takes a processor a while: numbers alone, without three.js and without
// the page, so that it can be computed beside both.

import { ambientOcclusion } from './occlusion.js';
import { paintFace } from './paint.js';
import { poreRelief } from './pores.js';
import { studio } from './studio.js';

/** What is the same for every head. */
export function studioWork() {
  return { pores: poreRelief(), studio: studio() };
}

/**
 * @typedef {object} Rest a head at rest
 * @property {Float32Array} positions 3 a vertex, mm
 * @property {Float32Array} normals 3 a vertex
 * @property {Uint32Array} triangles 3 vertices a triangle
 * @property {import('./paint.js').Points} landmarks mm
 */

/** What is this head's own. @param {Rest} rest */
export function headWork({ positions, normals, triangles, landmarks }) {
  return { open: ambientOcclusion(positions, normals, triangles), paint: paintFace(landmarks) };
}

/** @typedef {ReturnType<typeof studioWork> & ReturnType<typeof headWork>} Groundwork */
