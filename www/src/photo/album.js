// The photos of one person, one of which is on the stage: what is known of each, and the row to choose from.
import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { text } from '../text.js';
import { around } from './points.js';

/** Each keeps its picture and takes a fit's time; that many sides of a head nobody has. */
export const MOST_PHOTOS = 8;

/** A picture's pixels a side in the row, and how much is around the face there, as a part of its height. */
const SIDE = 112;
const ROOM = 0.25;

/**
 * A photo that another one of the person is on the stage instead of: what was found in it, by what and how it was fitted, and the
 * points that somebody moved since.
 * @typedef {{
 *   photo: import('./read.js').Photo,
 *   faces: Float32Array[],
 *   person: import('./faces.js').Person | null,
 *   detected: ReturnType<typeof import('./detected.js').marksOf> | null,
 *   moved: Float64Array | null,
 *   points: Float64Array,
 *   pixels: ReturnType<import('./fitter.js').Fitter['pixels']>,
 *   detail: import('phiz').PhotoDetail | undefined,
 *   shot: import('phiz').PhotoShot,
 * }} Portrait
 */

/** How the photo that a fit is of was taken, as its `others` say it of theirs. @param {import('phiz').PhotoFit} fit @returns {import('phiz').PhotoShot} */
export const shotOf = ({ camera, expression, residuals, light, quality: { rmsPx, rmsMm } }) => ({ camera, expression, residuals, light, rmsPx, rmsMm });

/** The fit of a face as another of its photos has it. @param {import('phiz').PhotoFit} fit @param {Portrait} stage @param {Portrait[]} others @returns {import('phiz').PhotoFit} */
export function fitOn(fit, { shot: { rmsPx, rmsMm, ...shot } }, others) {
  return { ...fit, ...shot, quality: { ...fit.quality, rmsPx, rmsMm }, others: others.map(({ shot }) => shot) };
}

/** The page keeps expressions so; what photos show is the same then. @param {import('phiz').PhotoFit} fit @returns {import('phiz').PhotoFit} */
export function inWholePerCents(fit) {
  /** @template {import('phiz').PhotoShot | import('phiz').PhotoFit} T @param {T} shot */
  const rounded = (shot) => {
    const shown = Object.entries(shot.expression).filter(([, weight]) => weight >= 0.005);
    return { ...shot, expression: Object.fromEntries(shown.map(([name, weight]) => [name, Math.round(100 * weight) / 100])) };
  };
  return { ...rounded(fit), others: fit.others.map(rounded) };
}

/** What a fit takes of each. @param {Portrait[]} others @returns {import('phiz').PhotoBeside[]} */
export const besides = (others) =>
  others.map(({ pixels: { width, height, points, focal, noise, jawNoise, irises, rgba } }) => ({ width, height, points, focal, noise, jawNoise, irises, rgba }));

/** What the colours of the head take of each. @param {Portrait[]} others @returns {import('phiz').PhotoOther[]} */
export const seenIn = (others) => others.map(({ pixels: { width, height, rgba }, detail, shot }) => ({ width, height, rgba, detail, shot }));

/** The face in a small picture. @param {Pick<Portrait, 'photo' | 'points'>} of */
function pictureOf({ photo: { bitmap, width }, points }) {
  const canvas = element('canvas', { width: SIDE, height: SIDE, 'aria-hidden': 'true' });
  const [left, top, right, bottom] = around(points, ROOM);
  const kept = bitmap.width / width;
  const side = kept * Math.max(right - left, bottom - top);
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
  context.imageSmoothingQuality = 'high';
  context.drawImage(bitmap, (kept * (left + right) - side) / 2, (kept * (top + bottom) - side) / 2, side, side, 0, 0, SIDE, SIDE);
  return canvas;
}

/**
 * The row of them, where there is more than one.
 * @param {{ choose: (i: number) => void, takeAway: (i: number) => void }} on
 */
export function createAlbum({ choose, takeAway }) {
  const root = element('div', { class: 'photo-album', role: 'group', 'aria-label': text.photo.album, hidden: true });
  return {
    root,
    /** @param {Pick<Portrait, 'photo' | 'points'>[]} photos @param {number} place of the one that is on the stage */
    show(photos, place) {
      root.hidden = photos.length < 2;
      root.replaceChildren(
        ...photos.map((of, i) => {
          const { name } = of.photo;
          const words = text.photo.ofAlbum(i + 1, photos.length);
          const away = text.photo.takeAway(i + 1);
          const choice = element('button', { type: 'button', class: 'photo-of-album', 'aria-pressed': String(i === place), 'aria-label': words, title: name, onclick: () => choose(i) }, pictureOf(of));
          return element('div', {}, choice, element('button', { type: 'button', class: 'tool small', 'aria-label': away, title: away, onclick: () => takeAway(i) }, icon('close')));
        }),
      );
    },
    focus: () => /** @type {HTMLElement | null} */ (root.querySelector('[aria-pressed=true]'))?.focus(),
  };
}
