import { atRest } from './targets.js';

/**
 * The model's texture coordinates, but around the gaze for the corners of eyeballs: away from the middle by the angle to +z.
 * @param {import('phiz').Face} face @param {number} reach the angle at the edge, radians
 */
export function aroundGaze(face, reach) {
  const { model } = face;
  const still = atRest(face);
  const rest = still.positions.slice();
  still.free();
  const [uvs, corners, triangles] = [model.uvs.slice(), model.uvVertices, model.triangles];
  for (const part of model.parts.filter(isEyeball)) layAround(uvs, rest, corners, triangles.subarray(3 * part.first, 3 * (part.first + part.count)), reach);
  return uvs;
}

/** @param {{ name: string }} part */
export function isEyeball(part) {
  if (typeof part?.name !== 'string') throw new TypeError('what isEyeball is given must be one of the `parts` of a FaceModel');
  return /eyeball/.test(part.name);
}

/**
 * @param {Float32Array} uvs changed @param {Float32Array} rest positions of the face at rest @param {Uint32Array} corners
 * @param {ArrayLike<number>} triangles of the eyeball @param {number} reach
 */
function layAround(uvs, rest, corners, triangles, reach) {
  const used = [...new Set(Array.from(triangles))];
  const at = (/** @type {number} */ corner) => [0, 1, 2].map((k) => rest[3 * corners[corner] + k]);
  // A ball may be open behind: it is as deep as it is wide.
  const points = used.map(at);
  const least = [0, 1, 2].map((k) => Math.min(...points.map((p) => p[k])));
  const most = [0, 1, 2].map((k) => Math.max(...points.map((p) => p[k])));
  const radius = (most[0] - least[0] + most[1] - least[1]) / 4;
  const centre = [(least[0] + most[0]) / 2, (least[1] + most[1]) / 2, most[2] - radius];
  for (const corner of used) {
    const [x, y, z] = at(corner).map((value, k) => value - centre[k]);
    const across = Math.hypot(x, y);
    const away = Math.min(1, Math.atan2(across, z) / reach) / 2;
    uvs[2 * corner] = 0.5 + (across > 0 ? (x / across) * away : 0);
    uvs[2 * corner + 1] = 0.5 + (across > 0 ? (y / across) * away : 0);
  }
}
