import { element } from '../frame/element.js';
import { OUTLINE } from '../stage/display.js';
import { heatColours } from '../stage/heat.js';
import { text } from '../text.js';

// What the page lays over the stage while it shows two faces or a distance, painted into a picture of it.

/**
 * @typedef {{
 *   other: string,
 *   split: { aside: number, left: string, right: string } | null,
 *   outline: string | null,
 *   heat: { title: string, least: string, most: string } | null,
 * }} Legend what the other face is called; how far right of the middle the line between two is, in heights, and whose sides are whose;
 *   whose the outline is; what the colours are
 */

/** Letters are such a part of the shorter side: as large as on a page. */
const LETTER = 1 / 42;
const PAPER = 'rgb(255 255 255 / 92%)';
const INK = '#1e2124';
const STEPS = 32;

/**
 * As much of the words as there is room for.
 * @param {CanvasRenderingContext2D} context @param {string} words @param {number} room px
 */
export function fitting(context, words, room) {
  if (context.measureText(words).width <= room) return words;
  let some = [...words];
  while (some.length > 0 && context.measureText(`${some.join('')}…`).width > room) some = some.slice(0, -1);
  return `${some.join('').trimEnd()}…`;
}

/**
 * @param {Blob} picture @param {Legend} legend
 * @returns {Promise<Blob>} a PNG
 */
export async function withLegend(picture, { split, outline, heat }) {
  const image = await createImageBitmap(picture);
  const { width, height } = image;
  const canvas = element('canvas', { width, height });
  const context = canvas.getContext('2d');
  if (!context) throw new Error(text.noPicture);
  context.drawImage(image, 0, 0);
  image.close();
  const letter = LETTER * Math.min(width, height);
  const gap = letter / 2;
  context.font = `${letter}px ui-sans-serif, system-ui, sans-serif`;
  context.textBaseline = 'middle';

  /** @param {number} left @param {number} top @param {number} wide @param {number} high */
  const sheet = (left, top, wide, high) => {
    context.fillStyle = PAPER;
    context.beginPath();
    context.roundRect(left, top, wide, high, gap);
    context.fill();
    context.fillStyle = INK;
  };

  if (split) {
    const line = Math.min(width, Math.max(0, Math.round(width / 2 + split.aside * height)));
    // A picture that is narrower than the stage may have one of them alone.
    if (line > 0 && line < width) {
      const thick = Math.max(2, Math.round(letter / 8));
      context.fillStyle = INK;
      context.fillRect(line - thick, 0, 2 * thick, height);
      context.fillStyle = '#ffffff';
      context.fillRect(line - thick / 2, 0, thick, height);
    }
    for (const [name, side] of /** @type {const} */ ([[split.left, -1], [split.right, 1]])) {
      const room = (side < 0 ? line : width - line) - 4 * gap;
      if (room < letter) continue;
      const words = fitting(context, name, room - 2 * gap);
      const wide = context.measureText(words).width + 2 * gap;
      const left = side < 0 ? line - 2 * gap - wide : line + 2 * gap;
      sheet(left, gap, wide, 1.7 * letter);
      context.fillText(words, left + gap, gap + 0.9 * letter);
    }
  }
  if (outline) {
    const stroke = 1.6 * letter;
    const words = fitting(context, outline, 0.5 * width);
    const [wide, high] = [context.measureText(words).width + stroke + 3 * gap, 1.7 * letter];
    const top = height - high - gap;
    sheet(gap, top, wide, high);
    context.fillText(words, stroke + 3 * gap, top + 0.9 * letter);
    context.fillStyle = OUTLINE;
    context.fillRect(2 * gap, top + high / 2 - letter / 16, stroke, letter / 8);
  }
  if (heat) {
    const title = fitting(context, heat.title, 0.6 * width);
    const [wide, high] = [Math.max(context.measureText(title).width, 6 * letter) + 2 * gap, 10 * letter];
    const [left, top] = [width - wide - gap, split ? 3 * letter : gap];
    sheet(left, top, wide, high);
    context.fillText(title, left + gap, top + letter);
    const [bar, from, to] = [left + gap, top + 2 * letter, top + high - gap];
    const colours = new Float32Array(3 * (STEPS + 1));
    heatColours(Float32Array.from({ length: STEPS + 1 }, (_, i) => i), STEPS, colours);
    const ramp = context.createLinearGradient(0, to, 0, from);
    for (let i = 0; i <= STEPS; i++) {
      const [r, g, b] = [0, 1, 2].map((k) => Math.round(255 * colours[3 * i + k]));
      ramp.addColorStop(i / STEPS, `rgb(${r} ${g} ${b})`);
    }
    context.fillText(heat.most, bar + 2 * letter, from + letter / 2);
    context.fillText(heat.least, bar + 2 * letter, to - letter / 2);
    context.fillStyle = ramp;
    context.fillRect(bar, from, letter, to - from);
  }
  return new Promise((done, fail) => {
    canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error(text.noPicture))), 'image/png');
  });
}
