import { smoothstep } from '../groundwork/paint.js';

/** How far from the base of a nose its nostrils reach, and how far below it, mm. */
const REACH = 26;
export const BELOW = 4;
/** By this part a colour's green is less than the skin's where a nostril begins, and where it is one. Blood in the tip takes a tenth. */
const DARKER = /** @type {const} */ ([0.15, 0.6]);

/**
 * How deep in a nostril each vertex lies, 0 to 1, as the colours say that come with the model. No scan sees to the end of a nostril: what
 * is learned from scans is a dish, which light would fill.
 * @param {{ colours: Uint8Array, mirror: Uint32Array }} model
 * @param {Uint32Array} outside the vertices of the skin's triangles: the mouth is dark, too
 * @param {Float32Array} rest 3 a vertex, mm
 * @param {readonly [number, number, number] | undefined} base of the nose, mm; without it nothing is a nostril
 * @param {number} green of the skin, 0 to 1
 */
export function nostrils({ colours, mirror }, outside, rest, base, green) {
  const deep = new Float32Array(mirror.length);
  if (!base || green === 0) return deep;
  for (const v of outside) {
    const y = rest[3 * v + 1] - base[1];
    if (y < -BELOW || Math.hypot(rest[3 * v] - base[0], y, rest[3 * v + 2] - base[2]) > REACH) continue;
    deep[v] = smoothstep(...DARKER, 1 - colours[3 * v + 1] / (255 * green));
  }
  // What is prescribed was looked for in few directions, and more of it was found on one side.
  return deep.map((own, v) => Math.max(own, deep[mirror[v]]));
}
