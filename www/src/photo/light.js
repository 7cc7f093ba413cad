// What photos' numbers are as light. A worker that has nothing to draw reads it, too.

/** How much light an sRGB value of a byte is. */
export const LINEAR = Float32Array.from({ length: 256 }, (_, i) => (i / 255 <= 0.04045 ? i / 255 / 12.92 : ((i / 255 + 0.055) / 1.055) ** 2.4));

/** Below this, light is noise. */
export const BLACK = 0.01;

/** @param {readonly number[]} colour linear */
export const logarithms = (colour) => colour.map((value) => Math.log(Math.max(BLACK, value)));

/** @param {readonly number[]} colour red, green and blue, linear */
export const brightnessOf = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
