import { beardGround, beardLength } from './beard.js';
import { scalpGround } from './hairstyle.js';
import { createHull } from './hull.js';
import { hairLength } from './length.js';
import { growOn } from './strands.js';
import { createTresses } from './tresses.js';

/**
 * Longer hair and a longer beard on a head.
 *
 * @param {{ positions: Float32Array, normals: Float32Array, triangles: Uint32Array, landmarks: import('../groundwork/paint.js').Points }} rest
 *   the skin's vertices, mm
 * @param {ReturnType<typeof import('./growth.js').growth>} grows where
 * @param {Parameters<typeof createTresses>[1]} uniforms of the skin
 * @param {readonly [number, number]} fade heights between which the neck runs out, mm
 */
export function growHair({ positions, normals, triangles, landmarks }, grows, uniforms, fade) {
  /** @type {import('./hull.js').Hull | null | undefined} */
  let hull;
  /**
   * @template {import('./strands.js').Curled} S
   * @param {(hull: import('./hull.js').Hull) => import('./strands.js').Ground<S> | null} ground
   */
  function on(ground) {
    if (hull === undefined) hull = createHull(positions, triangles, landmarks);
    const from = hull && ground(hull);
    return hull && from ? growOn(positions, normals, triangles, hull, from) : null;
  }
  return [
    createTresses(
      { name: 'hair', rest: positions, grow: () => on((hull) => scalpGround(grows.scalp, landmarks, hull)), style: (paints) => paints.style, long: hairLength, half: 1.35, stride: ({ curl }) => (curl > 0.3 ? 2 : 3) },
      uniforms,
      // Before the neck does, which would cover it.
      fade.map((y) => y + 18),
    ),
    createTresses(
      { name: 'beard', rest: positions, grow: () => on(() => beardGround(grows.beard, landmarks)), style: (paints) => paints.whiskers, long: beardLength, half: 0.95, stride: () => 6 },
      uniforms,
      fade.map((y) => y - 40),
    ),
  ];
}
