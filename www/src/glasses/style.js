import { valueIn } from '../head/colouring.js';

// What the numbers of a colouring say of a pair of glasses, in mm.

/** From this width on a rim is one of plastic, up to the second of these it is one of metal: of the slider. */
const PLASTIC = [0.32, 0.5];
/** Thinner than this there is none: of the slider. */
const RIMLESS = 0.05;
/** How broad rims are, mm, and how the slider's way between is bent. */
export const THINNEST = 0.9;
export const BROADEST = 5.6;
const BENT = 1.3;
/** Lenses, mm, and how high they are as a part of that. */
export const LENS_WIDTHS = /** @type {const} */ ([44, 58]);
export const LENS_HEIGHTS = /** @type {const} */ ([0.5, 1.02]);
/** What a lens and its frame are made of is thinner where less is seen of it. */
const mix = (/** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ t) => a + t * (b - a);
const smooth = (/** @type {number} */ from, /** @type {number} */ to, /** @type {number} */ x) => {
  const t = Math.min(1, Math.max(0, (x - from) / (to - from)));
  return t * t * (3 - 2 * t);
};

/**
 * @param {import('../head/colouring.js').Colouring} colouring
 * `width` and `height` are the lens's; `form` goes from round to rectangular, `sweep` from drops, -1, to the upswept, 1; `rim` is as broad
 * as it is seen from the front, and `deep` from the side; `plastic` is 0 for metal and 1 for acetate; `half` tells how much of the rim is
 * missing below, `bar` how thick a second bridge is, 0 to 1
 */
export function styleOf(colouring) {
  const of = (/** @type {string} */ name) => valueIn(colouring, name);
  const rim = of('rim');
  const plastic = smooth(PLASTIC[0], PLASTIC[1], rim);
  const width = mix(...LENS_WIDTHS, of('lensSize'));
  return {
    width,
    height: width * mix(...LENS_HEIGHTS, of('lensHeight')),
    form: of('lensForm'),
    sweep: 2 * of('lensSweep') - 1,
    rim: rim <= RIMLESS ? (THINNEST * rim) / RIMLESS : mix(THINNEST, BROADEST, ((rim - RIMLESS) / (1 - RIMLESS)) ** BENT),
    isRimless: rim < RIMLESS,
    plastic,
    deep: mix(1.9, 3.9, plastic),
    half: of('halfRim'),
    bar: of('noseBar'),
  };
}

/** @typedef {ReturnType<typeof styleOf>} Style */
/** What of one the outline of its lenses is of. @typedef {Pick<Style, 'width' | 'height' | 'form' | 'sweep'>} Lens */

/** The numbers of a colouring for lenses and rims of these, mm. @param {Lens} lens */
export const lensesOf = ({ width, height, form, sweep }) => ({
  lensSize: part(width, LENS_WIDTHS),
  lensHeight: part(height / width, LENS_HEIGHTS),
  lensForm: form,
  lensSweep: (sweep + 1) / 2,
});
/** @param {number} rim mm */
export const rimOf = (rim) => RIMLESS + (1 - RIMLESS) * Math.max(0, part(rim, [THINNEST, BROADEST])) ** (1 / BENT);
const part = (/** @type {number} */ value, /** @type {readonly [number, number]} */ [from, to]) => (value - from) / (to - from);

export { mix, smooth };
