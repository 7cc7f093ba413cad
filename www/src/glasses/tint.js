import { Color } from 'three';
import { REST, valueIn } from '../head/colouring.js';
import { mix, smooth } from './style.js';

// What frames and lenses are of.

/** Frames: metals first, then acetates. @type {readonly (readonly [place: number, colour: string, spots?: string])[]} */
const FRAMES = [
  [0, '#c6c9cc'],
  [0.14, '#cfa65c'],
  [0.26, '#9c5f45'],
  [0.36, '#8a5a2a', '#c98a3c'],
  [0.48, '#33190c', '#8a4e1e'],
  [REST.frameColour, '#0c0c0d'],
  [0.76, '#16244a'],
  [0.88, '#4f0f1d'],
  [1, '#a01a1c'],
];
/** Metal is polished up to here, and from there on there is none of it to be seen. */
const METAL = [0.28, 0.34];
/** From fair to dark, what a lens that is that dark lets through is of. */
const TINTS = ['#7d6f60', '#3a2c20', '#0b0a09'].map((colour) => new Color(colour));

/** The colour of a frame, linear, and of the spots in it. @param {number} at of the slider */
export function frameColour(at) {
  const next = Math.max(1, FRAMES.findIndex(([place]) => place >= at));
  const [[from, one, oneSpot = one], [to, other, otherSpot = other]] = [FRAMES[next - 1], FRAMES[next]];
  const t = (at - from) / (to - from);
  const between = (/** @type {string} */ a, /** @type {string} */ b) => new Color(a).lerp(new Color(b), t);
  return { colour: between(one, other), spots: between(oneSpot, otherSpot), metal: 1 - smooth(METAL[0], METAL[1], at) };
}

/** How much of the light a lens takes, from one that is hardly tinted to the darkest, and how that goes along the slider. */
const TAKEN = /** @type {const} */ ([0.06, 0.93]);
const BENT = 0.75;
/** How much of a frame's colour its spots are. */
export const SPOTTED = 0.35;

/**
 * What a lens does to what is behind it: how much of that it takes, and what it is of, linear.
 * @param {number} tint from clear to dark
 */
export function lensColour(tint) {
  const half = Math.min(1, 2 * tint);
  const colour = TINTS[0].clone().lerp(TINTS[1], half).lerp(TINTS[2], Math.max(0, 2 * tint - 1));
  return { colour: colour.multiplyScalar(0.35), taken: tint === 0 ? 0.015 : mix(...TAKEN, tint ** BENT) };
}
/** The tint of a lens that takes so much of the light. @param {number} taken */
export const tintOf = (taken) => Math.min(1, Math.max(0, (taken - TAKEN[0]) / (TAKEN[1] - TAKEN[0]))) ** (1 / BENT);

/** @param {import('../head/colouring.js').Colouring} colouring */
export const tintsOf = (colouring) => ({ frame: frameColour(valueIn(colouring, 'frameColour')), lens: lensColour(valueIn(colouring, 'tint')) });
