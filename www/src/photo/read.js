// A file becomes pixels, the right way up, or a sentence that says why not.
import { Failure } from '../failure.js';
import { text } from '../text.js';
import { headerOf } from './exif.js';

/** What is worked on, pixels: with its copies for the screen and for the file, below half a gigabyte. */
const WORKED_ON = 24e6;
/** Decoding takes four bytes a pixel for a moment, whatever is worked on afterwards. */
const OPENED = 100e6;
/** No face fits into less, px. */
const SMALLEST = 32;
/** Textures are not larger on most graphics cards. */
const LONGEST = 8192;
/** EXIF stands before the picture; JPEG's is at most 64 kB. */
const HEAD = 1 << 20;
/** The shapes of what sensors give; anything else was cut, and then its focal length is another's. */
const WHOLE = [4 / 3, 3 / 2, 16 / 9];

/** @typedef {Awaited<ReturnType<typeof readPhoto>>} Photo */

/** Of what is decoded; null when it has as many pixels as can be worked on. @param {number} width @param {number} height */
function smaller(width, height) {
  const pixels = width * height;
  if (pixels > OPENED) throw new Failure(text.photo.tooLarge(pixels / 1e6, OPENED / 1e6));
  const scale = Math.min(1, Math.sqrt(WORKED_ON / pixels), LONGEST / Math.max(width, height));
  // The height follows from the width.
  return scale < 1 ? { resizeWidth: Math.round(scale * width), resizeQuality: /** @type {const} */ ('high') } : null;
}

/**
 * @param {Blob} file
 * @param {string} name
 * @throws Failure with a sentence
 */
export async function readPhoto(file, name) {
  if (file.size === 0) throw new Failure(text.photo.empty);
  const { kind, size, focal35 } = headerOf(await file.slice(0, HEAD).arrayBuffer());
  // What is too large is not even decoded.
  const resize = size && smaller(...size);
  let bitmap;
  try {
    bitmap = await createImageBitmap(file, { imageOrientation: 'from-image', ...resize });
  } catch {
    throw new Failure(kind === null ? text.photo.unreadable : kind === 'avif or heif' ? text.photo.undecodable : text.photo.damaged);
  }
  const whole = size ?? [bitmap.width, bitmap.height];
  const later = size ? null : smaller(bitmap.width, bitmap.height);
  if (later) {
    const large = bitmap;
    bitmap = await createImageBitmap(large, later).finally(() => large.close());
  }
  if (Math.min(...whole) < SMALLEST) {
    bitmap.close();
    throw new Failure(text.photo.tooSmall);
  }
  const { width, height } = bitmap;
  const ratio = Math.max(width, height) / Math.min(width, height);
  const uncut = WHOLE.some((shape) => Math.abs(ratio / shape - 1) < 0.02);
  return {
    name,
    bitmap,
    width,
    height,
    /** The file's own size, where it is worked on smaller; else null. */
    reduced: resize || later ? { width: whole[0], height: whole[1] } : null,
    /** px, or undefined: then it is estimated. */
    focal: uncut && focal35 !== null ? (Math.max(width, height) * focal35) / 36 : undefined,
  };
}
