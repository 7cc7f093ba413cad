// A file becomes pixels, the right way up, or a sentence that says why not.
import { Failure } from '../failure.js';
import { text } from '../text.js';
import { focal35 } from './exif.js';

/** What is worked on, pixels: with its copies for the screen and for the file, below half a gigabyte. */
const WORKED_ON = 24e6;
/** Decoding takes four bytes a pixel for a moment, whatever is worked on afterwards. */
const OPENED = 100e6;
/** Textures are not larger on most graphics cards. */
const LONGEST = 8192;
/** EXIF stands before the picture; JPEG's is at most 64 kB. */
const HEAD = 1 << 20;
/** The shapes of what sensors give; anything else was cut, and then its focal length is another's. */
const WHOLE = [4 / 3, 3 / 2, 16 / 9];

/** @typedef {Awaited<ReturnType<typeof readPhoto>>} Photo */

/** @param {Blob} file @returns {Promise<{ width: number, height: number }>} */
async function sizeOf(file) {
  const url = URL.createObjectURL(file);
  try {
    const image = new Image();
    await new Promise((loaded, failed) => {
      image.onload = loaded;
      image.onerror = () => failed(new Failure(text.photo.unreadable));
      image.src = url;
    });
    return { width: image.naturalWidth, height: image.naturalHeight };
  } finally {
    URL.revokeObjectURL(url);
  }
}

/**
 * @param {Blob} file
 * @param {string} name
 * @throws Failure with a sentence
 */
export async function readPhoto(file, name) {
  if (file.size === 0) throw new Failure(text.photo.empty);
  const whole = await sizeOf(file);
  const pixels = whole.width * whole.height;
  if (pixels > OPENED) throw new Failure(text.photo.tooLarge(pixels / 1e6, OPENED / 1e6));
  if (Math.min(whole.width, whole.height) < 32) throw new Failure(text.photo.tooSmall);
  const scale = Math.min(1, Math.sqrt(WORKED_ON / pixels), LONGEST / Math.max(whole.width, whole.height));
  const resize = /** @type {const} */ ({
    resizeWidth: Math.max(1, Math.round(scale * whole.width)),
    resizeHeight: Math.max(1, Math.round(scale * whole.height)),
    resizeQuality: 'high',
  });
  let bitmap;
  try {
    bitmap = await createImageBitmap(file, { imageOrientation: 'from-image', ...(scale < 1 ? resize : {}) });
  } catch {
    throw new Failure(text.photo.damaged);
  }
  const { width, height } = bitmap;
  const ratio = Math.max(width, height) / Math.min(width, height);
  const f35 = WHOLE.some((shape) => Math.abs(ratio / shape - 1) < 0.02) ? focal35(await file.slice(0, HEAD).arrayBuffer()) : null;
  return {
    name,
    bitmap,
    width,
    height,
    /** The file's own size, where it is worked on smaller; else null. */
    reduced: scale < 1 ? whole : null,
    /** px, or undefined: then it is estimated. */
    focal: f35 === null ? undefined : (Math.max(width, height) * f35) / 36,
  };
}
