// The worker that finds faces, and the person around one. It goes with what it was asked: what it holds is
// a hundred megabytes, and the next photo starts from the same state.
import { text } from '../text.js';
import { boxOf } from './points.js';

/** @typedef {{ bitmap: ImageBitmap, width: number, height: number }} Photo */
/** How much of each pixel of a square of the photo (px) is a person's: red, and opaque. @typedef {{ mask: ImageBitmap, x: number, y: number, side: number }} Person */

/** The photo is shown to it at most so large; it looks at faces with 192 px. */
const LONGEST = 2560;
/** And what is around a face, which it looks at with 256, so large. */
const CLOSE = 512;
/** A person is looked for in a square of so many times the face's height, the face above its middle: head and shoulders, as in the pictures that the library knows. */
const AROUND = 3;
const ABOVE = 0.42;
/** A mask that leaves out more than this part of the face's points is of somebody else, or of a drawing. */
const LEFT_OUT = 0.2;

/** What is asked, each of a worker of its own: one starts while the other works. @typedef {'faces' | 'person'} What */
/** @type {Map<What, Worker>} */
const workers = new Map();

/** Ends searches that nobody waits for any more. @param {What[]} which */
export function stopFinding(which = ['faces', 'person']) {
  for (const what of which) {
    workers.get(what)?.terminate();
    workers.delete(what);
  }
}

/** @param {What} what */
function workerFor(what) {
  let worker = workers.get(what);
  if (!worker) {
    const fresh = new Worker(new URL('./faces.worker.js', import.meta.url));
    // One that fails before it is asked is none: it would never answer. Who asks starts another, and is told.
    fresh.onerror = () => workers.get(what) === fresh && stopFinding([what]);
    workers.set(what, (worker = fresh));
  }
  return worker;
}

/** @param {What} what */
const folderOf = (what) => new URL(__MEDIAPIPE__[what], document.baseURI).href;

/** Loads what both searches need, which takes longer than they do. What goes wrong is told when they are asked. */
export function prepareFinding() {
  for (const what of /** @type {What[]} */ (['faces', 'person'])) workerFor(what).postMessage({ prepare: what, folder: folderOf(what) });
}

/**
 * @param {What} what @param {Record<string, unknown>} wish @param {Transferable[]} transfer
 * @param {(fraction: number) => void} [progress]
 */
async function ask(what, wish, transfer, progress) {
  const seeker = workerFor(what);
  try {
    return await new Promise((done, failed) => {
      seeker.onmessage = ({ data }) => {
        if (data.error !== undefined) failed(new Error(text.photo.noDetector(data.error)));
        else if (data.answer) done(data.answer);
        else progress?.(data.progress);
      };
      seeker.onerror = (event) => failed(new Error(text.photo.noDetector(event.message || text.needsConnection)));
      seeker.postMessage({ folder: folderOf(what), ...wish }, transfer);
    });
  } finally {
    if (workers.get(what) === seeker) stopFinding([what]);
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
 * The faces of a photo, the largest first: 478 points each as x, y pairs, px of the photo.
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
  // Only what is looked at is scaled: a large photo has much beside.
  const shown = [of.bitmap.width / of.width, of.bitmap.height / of.height];
  const [x, y] = [square.x * shown[0], square.y * shown[1]].map((first) => Math.max(0, Math.floor(first)));
  const wide = Math.max(1, Math.min(of.bitmap.width, Math.ceil((square.x + side) * shown[0])) - x);
  const high = Math.max(1, Math.min(of.bitmap.height, Math.ceil((square.y + side) * shown[1])) - y);
  const small = Math.min(1, CLOSE / Math.max(wide, high));
  const photo = await createImageBitmap(of.bitmap, x, y, wide, high, {
    resizeWidth: Math.max(1, Math.round(small * wide)),
    resizeHeight: Math.max(1, Math.round(small * high)),
    resizeQuality: 'high',
  });
  const scale = small * shown[0];
  const mask = await ask('person', { photo, square: { x: scale * square.x - small * x, y: scale * square.y - small * y, side: scale * side } }, [photo]);
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
