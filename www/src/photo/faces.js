// The worker that finds faces, and the person around one. It goes with what it was asked: what it holds is
// a hundred megabytes, and the next photo starts from the same state.
import { text } from '../text.js';
import { boxOf } from './points.js';

/** @typedef {{ bitmap: ImageBitmap, width: number, height: number }} Photo */
/** How much of each pixel of a square of the photo (px) is a person's: red, and opaque. @typedef {{ mask: ImageBitmap, x: number, y: number, side: number }} Person */

/** The photo is shown to it at most so large; it looks at faces with 192 px. */
const LONGEST = 2560;
/** A person is looked for in a square of so many times the face's height, the face above its middle: head and shoulders, as in the pictures that the library knows. */
const AROUND = 3;
const ABOVE = 0.42;
/** A mask that leaves out more than this part of the face's points is of somebody else, or of a drawing. */
const LEFT_OUT = 0.2;

/** @type {Worker | null} */
let worker = null;

/** Ends a search that nobody waits for any more. */
export function stopFinding() {
  worker?.terminate();
  worker = null;
}

/**
 * @param {'faces' | 'person'} what @param {Record<string, unknown>} wish @param {Transferable[]} transfer
 * @param {(fraction: number) => void} [progress]
 */
async function ask(what, wish, transfer, progress) {
  stopFinding();
  const seeker = (worker = new Worker(new URL('./faces.worker.js', import.meta.url)));
  try {
    return await new Promise((done, failed) => {
      seeker.onmessage = ({ data }) => {
        if (data.error !== undefined) failed(new Error(text.photo.noDetector(data.error)));
        else if (data.answer) done(data.answer);
        else progress?.(data.progress);
      };
      seeker.onerror = (event) => failed(new Error(text.photo.noDetector(event.message || 'a script is missing')));
      const folder = new URL(__MEDIAPIPE__[what], document.baseURI).href;
      seeker.postMessage({ folder, ...wish }, transfer);
    });
  } finally {
    if (worker === seeker) stopFinding();
  }
}

/** @param {Photo} of @param {number} longest px @returns {Promise<ImageBitmap>} */
function copy({ bitmap }, longest) {
  const scale = Math.min(1, longest / Math.max(bitmap.width, bitmap.height));
  return createImageBitmap(bitmap, {
    resizeWidth: Math.max(1, Math.round(scale * bitmap.width)),
    resizeHeight: Math.max(1, Math.round(scale * bitmap.height)),
    resizeQuality: 'high',
  });
}

/**
 * The faces of a photo, the largest first: 468 points each as x, y pairs, px of the photo.
 * @param {Photo} of
 * @param {(fraction: number) => void} progress
 * @returns {Promise<Float32Array[]>}
 */
export async function findFaces(of, progress) {
  const photo = await copy(of, LONGEST);
  const [sx, sy] = [of.width / photo.width, of.height / photo.height];
  /** @type {Float32Array[]} */
  const faces = await ask('faces', { photo }, [photo], progress);
  return faces.map((face) => face.map((value, i) => value * (i % 2 ? sy : sx)));
}

/**
 * The person whose face has these 68 points, px of the photo; null when no person is seen there.
 * @param {Photo} of @param {Float64Array} points
 * @returns {Promise<Person | null>}
 */
export async function findPerson(of, points) {
  const [left, top, right, bottom] = boxOf(points);
  const side = AROUND * Math.max(bottom - top, right - left);
  const square = { x: (left + right - side) / 2, y: (top + bottom) / 2 - ABOVE * side, side };
  const photo = await copy(of, LONGEST);
  const scale = photo.width / of.width;
  const mask = await ask('person', { photo, square: { x: scale * square.x, y: scale * square.y, side: scale * side } }, [photo]);
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(mask.width, mask.height).getContext('2d', { willReadFrequently: true }));
  context.drawImage(mask, 0, 0);
  const { data } = context.getImageData(0, 0, mask.width, mask.height);
  const at = (/** @type {number} */ place, /** @type {number} */ first, /** @type {number} */ size) =>
    Math.min(size - 1, Math.max(0, Math.floor(((place - first) / side) * size)));
  let out = 0;
  for (let i = 0; i < points.length; i += 2) {
    const pixel = at(points[i + 1], square.y, mask.height) * mask.width + at(points[i], square.x, mask.width);
    if (data[4 * pixel] < 128) out += 1;
  }
  if (out > (LEFT_OUT * points.length) / 2) {
    mask.close();
    return null;
  }
  return { mask, ...square };
}
