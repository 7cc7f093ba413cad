import { REST } from '../head/colouring.js';
import { THROUGH_BLOOD, pigments } from '../head/pigments.js';
import { logarithms } from './light.js';

// How red lips are in a photo: by their albedo beside the skin's.

/** Points of the inner edge of a lip, each with the one across on its outer edge (`ibug_`). */
const ACROSS = [[61, 50], [62, 51], [63, 52], [65, 56], [66, 57], [67, 58]];
/** Where between the two is looked at: edges are none too well known. */
const BETWEEN = [0.35, 0.5, 0.65];
/** Where fewer of the places are seen nothing is told. */
const FEWEST = 0.3;
/** How bright lips are is a matter of gloss and shadow: it tells so much of what their hue does. */
const BRIGHTNESS = 0.1;
/** Lips at an end of the slider have to explain so much more: on 36 drawn heads it is within 0.06 then, where all at rest would be off by 0.13. */
const USUAL = 0.3;
const STEPS = 50;

/**
 * Where a photo's albedo is asked for lips.
 * @param {import('../groundwork/groundwork.js').Rest} rest of the head
 * @returns {import('./browtold.js').Places} none for a head without the landmarks
 */
export function lipPlaces({ positions, landmarks }) {
  /** @type {number[]} */
  const vertices = [];
  for (const [inner, outer] of ACROSS) {
    const [from, to] = [inner, outer].map((n) => landmarks.get(`ibug_${n}`));
    if (!from || !to) continue;
    for (const t of BETWEEN) vertices.push(nearest(positions, from.map((value, k) => value + t * (to[k] - value))));
  }
  return { corners: Uint32Array.from(vertices.flatMap((vertex) => [vertex, vertex, vertex])), shares: Float32Array.from(vertices.flatMap(() => [1, 0, 0])) };
}

/** @param {Float32Array} positions @param {readonly number[]} point */
function nearest(positions, [x, y, z]) {
  let [best, least] = [0, Infinity];
  for (let o = 0; o < positions.length; o += 3) {
    const away = (positions[o] - x) ** 2 + (positions[o + 1] - y) ** 2 + (positions[o + 2] - z) ** 2;
    if (away < least) [best, least] = [o / 3, away];
  }
  return best;
}

/**
 * @param {Float32Array} albedos of `lipPlaces`, four numbers a place: linear light, and how well it is seen
 * @param {readonly number[]} skin the photo's, linear
 * @param {import('three').Color} tone of the head's skin at rest
 * @param {import('../head/colouring.js').Colouring} own the skin's sliders
 * @returns {number | null} where the slider of lips is; null where too little is seen
 */
export function lipsTold(albedos, skin, tone, own) {
  const sum = [0, 0, 0];
  let seen = 0;
  for (let o = 0; o < albedos.length; o += 4) {
    const sight = albedos[o + 3];
    if (!(sight > 0)) continue;
    seen += sight;
    logarithms(Array.from(albedos.subarray(o, o + 3))).forEach((value, k) => (sum[k] += sight * value));
  }
  if (!(seen > (FEWEST * albedos.length) / 4)) return null;
  const ofSkin = logarithms(skin);
  const beside = sum.map((value, k) => value / seen - ofSkin[k]);
  let [best, least] = [REST.lips, Infinity];
  for (let i = 0; i <= STEPS; i++) {
    const lips = i / STEPS;
    const off = wouldBe(tone, { ...own, lips }).map((value, k) => beside[k] - value);
    const bright = (off[0] + off[1] + off[2]) / 3;
    const cost = off.reduce((all, value) => all + (value - bright) ** 2, 0) + BRIGHTNESS * bright ** 2 + USUAL * (lips - REST.lips) ** 2;
    if (cost < least) [best, least] = [lips, cost];
  }
  return best;
}

/** What lips have of the skin around them, as the skin's shader shows both: logarithms. @param {import('three').Color} tone @param {import('../head/colouring.js').Colouring} colouring */
function wouldBe(tone, colouring) {
  const { lips, skin, lipCover } = pigments(tone, colouring);
  const [of, beside] = [lips.toArray(), skin.toArray()];
  return logarithms(THROUGH_BLOOD.map((under, k) => 1 - lipCover + (lipCover * of[k]) / beside[k] / under));
}
