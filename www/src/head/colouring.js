import { mixedMarks, readMarks } from './marks.js';

// What colours a face has beside its shape: of skin, lips, brows and eyes. Each is a number from 0 to 1 with a
// rest, at which the head is painted in the model's own colour; a colouring holds those that are elsewhere, and the marks of the skin, if
// there are any, as `marks.js` writes them.

/** @typedef {{ readonly marks?: string, readonly [name: string]: number | string | undefined }} Colouring */

/** Where each is at rest, in the order of the panel. What an address keeps goes by this order: append only. */
export const REST = /** @type {Readonly<Record<string, number>>} */ ({
  skin: 0.3,
  blood: 0.3,
  lips: 0.4,
  brows: 0.5,
  hair: 0.7,
  red: 0,
  grey: 0,
  iris: 0.7,
  crop: 0,
  beard: 0,
  length: 0,
  comb: 0.4,
  parting: 0.4,
  curl: 0.15,
  lines: 0,
  freckles: 0,
  beardLength: 0,
  thin: 0,
  beardThin: 0,
  hairline: 0,
  moustache: 1,
  chinBeard: 1,
  cheekBeard: 1,
  browBreadth: 0.5,
  browArch: 0.5,
  browSlant: 0.5,
  browApart: 0.5,
  browRaise: 0.5,
  glasses: 0,
  lensForm: 0.5,
  lensSize: 0.5,
  lensHeight: 0.5,
  lensSweep: 0.5,
  rim: 0.7,
  halfRim: 0,
  noseBar: 0,
  frameColour: 0.66,
  tint: 0,
  beardShade: 0.5,
  beardRed: 0.5,
  beardGrey: 0.5,
  browShade: 0.5,
  browGrey: 0.5,
});

export const COLOURS = Object.keys(REST);

/** Which form brows have. */
export const BROW_FORM = /** @type {const} */ (['browBreadth', 'browArch', 'browSlant', 'browApart', 'browRaise']);

/** What a pair of glasses is of; the first tells whether some is worn. */
export const GLASSES = /** @type {const} */ (['glasses', 'lensForm', 'lensSize', 'lensHeight', 'lensSweep', 'rim', 'halfRim', 'noseBar', 'frameColour', 'tint']);

/** One of a colouring, from 0 to 1. @param {Colouring} colouring @param {string} name */
export function valueIn(colouring, name) {
  const value = colouring[name];
  return typeof value === 'number' ? value : REST[name];
}

/** Whether a face has glasses on. @param {Colouring} colouring */
export const wearsGlasses = (colouring) => valueIn(colouring, 'glasses') >= 0.5;

/** What of a colouring stays with a face whatever else it looks like: its glasses, and its marks. @param {Colouring} colouring @returns {Colouring} */
export function carriedOf(colouring) {
  const { marks } = colouring;
  return { ...Object.fromEntries(GLASSES.flatMap((name) => (name in colouring ? [[name, valueIn(colouring, name)]] : []))), ...(marks && { marks }) };
}

/** All numbers of it. @param {Colouring} colouring @returns {Record<string, number>} */
export const whole = (colouring) => Object.fromEntries(COLOURS.map((name) => [name, valueIn(colouring, name)]));

/**
 * What of some values is a colouring: whole per cents that are not at rest, and marks that can be read.
 * @param {Record<string, unknown>} values @returns {Colouring}
 */
export function readColouring(values) {
  const numbers = COLOURS.flatMap((name) => {
    const value = values[name];
    if (typeof value !== 'number' || !Number.isFinite(value)) return [];
    const kept = Math.round(100 * Math.min(1, Math.max(0, value))) / 100;
    return kept === REST[name] ? [] : [[name, kept]];
  });
  const marks = readMarks(values.marks);
  return { ...Object.fromEntries(numbers), ...(marks && { marks }) };
}

/**
 * Of several colourings so much of each; the amounts sum to 1.
 * @param {readonly (readonly [colouring: Colouring, amount: number])[]} parts
 */
export function mixture(parts) {
  const mean = (/** @type {string} */ name) => parts.reduce((sum, [colouring, amount]) => sum + amount * valueIn(colouring, name), 0);
  // Half a pair of glasses is none: those who have some on have them between them.
  const wearing = parts.filter(([colouring]) => wearsGlasses(colouring));
  const worn = wearing.reduce((sum, [, amount]) => sum + amount, 0);
  const glasses = GLASSES.map((name) => [name, worn < 0.5 ? REST[name] : wearing.reduce((sum, [colouring, amount]) => sum + (amount / worn) * valueIn(colouring, name), 0)]);
  const marks = mixedMarks(parts.map(([colouring, amount]) => [colouring.marks, amount]));
  return readColouring({ ...Object.fromEntries(COLOURS.map((name) => [name, mean(name)])), ...Object.fromEntries(glasses), marks });
}

/**
 * A colouring that was kept somewhere.
 * @param {unknown} kept @returns {Colouring | undefined} undefined when nothing was kept
 */
export function readKept(kept) {
  if (typeof kept !== 'object' || kept === null || Array.isArray(kept)) return undefined;
  return readColouring(/** @type {Record<string, unknown>} */ (kept));
}
