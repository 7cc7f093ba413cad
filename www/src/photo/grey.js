import { Color } from 'three';
import { LINEAR, brightnessOf } from './light.js';
import { skinAsBright } from './looks.js';

// Photos without colours, as old ones are: what of a person's colours brightness tells.

/** Texels that are this much the photo's count, of 255. */
const OWN = 200;
/** One in so many is looked at. */
const APART = 61;
/** Red, green and blue of a texel that has no hue are this close, of 255: what compression leaves. */
const CLOSE = 3;
/** So much of the skin of a photo without colours has no hue. */
const MOST = 0.95;

/** The sRGB value of a byte that so much light is, of 4096 steps. */
const BYTES = Uint8Array.from({ length: 4097 }, (_, i) => Math.round(255 * new Color(i / 4096, 0, 0).convertLinearToSRGB().r));

/**
 * The colours that a head takes from a photo; skin of one that has none gets those of skin as bright.
 * @param {{ size: number, rgba: Uint8ClampedArray }} colours
 * @param {import('three').Color} tone of the head's skin at rest
 */
export function coloured({ size, rgba }, tone) {
  /** @type {number[]} */
  const lights = [];
  let grey = 0;
  for (let o = 0; o < rgba.length; o += 4 * APART) {
    if (rgba[o + 3] < OWN) continue;
    const [r, g, b] = [rgba[o], rgba[o + 1], rgba[o + 2]];
    if (Math.max(r, g, b) - Math.min(r, g, b) <= CLOSE) grey += 1;
    lights.push(LINEAR[g]);
  }
  if (lights.length === 0 || grey < MOST * lights.length) return { size, rgba };
  const median = lights.sort((a, b) => a - b)[lights.length >> 1];
  const own = skinAsBright(median, tone);
  const brightness = brightnessOf(own);
  const tables = own.map((value) => Uint8Array.from(LINEAR, (light) => BYTES[Math.min(4096, Math.round((4096 * light * value) / brightness))]));
  const tinted = new Uint8ClampedArray(rgba.length);
  for (let o = 0; o < rgba.length; o += 4) {
    for (let k = 0; k < 3; k++) tinted[o + k] = tables[k][rgba[o + k]];
    tinted[o + 3] = rgba[o + 3];
  }
  return { size, rgba: tinted };
}
