import { createBrowTeller } from './browtold.js';
import { lipPlaces } from './liptold.js';

/**
 * What the skin's albedo tells beside its colour, by where it is asked: brows, and lips.
 * @param {import('../groundwork/groundwork.js').Rest} rest of the head
 */
export function createTeller(rest) {
  const brows = createBrowTeller(rest);
  const lips = lipPlaces(rest);
  const of = brows?.places ?? { corners: new Uint32Array(), shares: new Float32Array() };
  const begin = (4 * of.corners.length) / 3;
  return {
    /** Where it is asked. @type {import('./browtold.js').Places} */
    places: { corners: Uint32Array.from([...of.corners, ...lips.corners]), shares: Float32Array.from([...of.shares, ...lips.shares]) },
    /** @param {Float32Array} albedos four numbers a place: linear light, and how well it is seen */
    told: (albedos) => ({ brows: brows?.told(albedos.subarray(0, begin)) ?? {}, lips: albedos.subarray(begin) }),
  };
}
