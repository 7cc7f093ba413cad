// A file becomes pixels, the right way up, or a sentence that says why not.
import { Failure } from '../frame/failure.js';
import { drawnByProcessor } from '../rendering/graphics.js';
import { text } from '../text.js';
import { focalOf, headerOf } from './exif.js';
import { spaceOf } from './profile.js';
import { saidIn } from './xmp.js';

/**
 * What is kept while a photo is edited is at most so many pixels a side: faces are found, points corrected and
 * changes shown on it (the screen of a processor gets fewer, but faces are looked for in as many). The photo
 * itself is decoded again from its file when it is saved.
 */
const WORKED_ON = drawnByProcessor() ? 2560 : 4096;
/** What is saved, pixels: decoded, drawn and encoded it takes some ten bytes a pixel for a moment. */
const SAVED = 51e6;
/** Decoding takes four bytes a pixel for a moment, whatever is made of it. */
const OPENED = 100e6;
/** No face fits into less, px. */
const SMALLEST = 32;
/** Canvases are not larger in some browsers. */
const LONGEST = 16384;
/** EXIF stands before the picture; JPEG's is at most 64 kB. */
const HEAD = 1 << 20;
/**
 * What a photo says of who made it and of how, in EXIF or, as those do that were saved here, in XMP; and whether that is that it
 * was edited here.
 * @param {import('./exif.js').Credits} exif @param {string} xmp
 */
function saidOf(exif, xmp) {
  const said = saidIn(xmp);
  const lines = (exif.description || said.description).split('\n');
  return {
    credits: {
      artist: exif.artist || said.artist,
      copyright: exif.copyright || said.copyright,
      // It is said anew.
      description: lines.filter((line) => line !== text.photo.editedNote).join('\n'),
      source: said.source,
    },
    edited: lines.includes(text.photo.editedNote),
  };
}

/** @typedef {Awaited<ReturnType<typeof readPhoto>>} Photo */

/**
 * The size in which a photo is saved, which is the file's if that can be.
 * @param {number} width @param {number} height
 * @throws Failure when none can
 */
function saved(width, height) {
  const pixels = width * height;
  if (pixels > OPENED) throw new Failure(text.photo.tooLarge(pixels / 1e6, OPENED / 1e6));
  const scale = Math.min(1, Math.sqrt(SAVED / pixels), LONGEST / Math.max(width, height));
  const size = { width: Math.round(scale * width), height: Math.round(scale * height) };
  // What is very long is as low as that in the end.
  if (Math.min(size.width, size.height) < SMALLEST) throw new Failure(text.photo.tooSmall);
  return size;
}

/** What makes the picture to work on of one of this size; null when that is small enough. @param {number} width @param {number} height */
function smaller(width, height) {
  const scale = Math.min(1, WORKED_ON / Math.max(width, height));
  // The height follows from the width.
  return scale < 1 ? { resizeWidth: Math.max(1, Math.round(scale * width)), resizeQuality: /** @type {const} */ ('high') } : null;
}

/**
 * @param {Blob} file
 * @param {string} name
 * @throws Failure with a sentence
 */
export async function readPhoto(file, name) {
  if (file.size === 0) throw new Failure(text.photo.empty);
  // A folder that was dropped is a file to the page, too.
  const head = await file.slice(0, HEAD).arrayBuffer().catch(() => Promise.reject(new Failure(text.photo.notRead)));
  const { kind, size, focal35, profile, credits, xmp } = headerOf(head);
  // What is too large or too small is not even decoded.
  if (size) saved(...size);
  /** @param {ReturnType<typeof smaller>} [less] */
  const decode = (less) => createImageBitmap(file, { imageOrientation: 'from-image', ...less });
  const less = size && smaller(...size);
  let bitmap;
  try {
    bitmap = await decode(less);
    // The browser says which way up it is: where it takes the other side for the width, that was scaled for the height.
    if (size && less && (bitmap.width - bitmap.height) * (size[0] - size[1]) < 0) {
      bitmap.close();
      size.reverse();
      bitmap = await decode(smaller(...size));
    }
  } catch {
    throw new Failure(kind === null ? text.photo.unreadable : kind === 'avif or heif' ? text.photo.undecodable : text.photo.damaged);
  }
  /** @type {readonly [number, number]} */
  const whole = size && less ? size : [bitmap.width, bitmap.height];
  let width, height;
  try {
    ({ width, height } = saved(...whole));
  } catch (error) {
    bitmap.close();
    throw error;
  }
  const later = less ? null : smaller(...whole);
  if (later) {
    const large = bitmap;
    bitmap = await createImageBitmap(large, later).finally(() => large.close());
  }
  return {
    name,
    file,
    /** The picture to work on, as large as the photo or smaller. */
    bitmap,
    /** px of the photo as it is saved, in which all else is told. */
    width,
    height,
    /** The file's own size, where it is saved smaller; else null. */
    reduced: width < whole[0] ? { width: whole[0], height: whole[1] } : null,
    ...saidOf(credits, xmp),
    /** Of the canvas that loses none of its colours. */
    colorSpace: await spaceOf(profile),
    /** px, or undefined: then it is estimated. */
    focal: focalOf(width, height, focal35),
  };
}

/**
 * All pixels of a photo, from its file again when what is worked on has fewer. Who asks closes it.
 * @param {Photo} photo
 * @throws Failure with a sentence
 */
export async function decodeAgain({ file, bitmap, width, height, reduced }) {
  if (bitmap.width === width && bitmap.height === height) return createImageBitmap(bitmap);
  const resize = reduced && { resizeWidth: width, resizeHeight: height, resizeQuality: /** @type {const} */ ('high') };
  let whole;
  try {
    whole = await createImageBitmap(file, { imageOrientation: 'from-image', ...resize });
  } catch {
    throw new Failure(text.photo.gone);
  }
  if (whole.width === width && whole.height === height) return whole;
  whole.close();
  throw new Failure(text.photo.gone);
}
