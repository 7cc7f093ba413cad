// The worker that fits photos, as promises. To cancel is to end it: the next photo starts another, also when it has ended by itself.
import { text } from '../text.js';
import { boxOf } from './points.js';

/**
 * The worker sees a photo at most as large as the first of these, px: a portrait's face has enough pixels there. Where that of one
 * among many would be lower than `ENOUGH`, it sees more, up to the second.
 */
const LONGEST = [1024, 2048];
const ENOUGH = 256;
/** Colours are of finer pixels where there are some, by this factor at least: of the face and so much of its size around it, at most so large, px. */
const FINER = 1.2;
const AROUND_FACE = 0.3;
const FINEST = 1024;

/**
 * px of the worker for one of a photo with a face at these points.
 * @param {{ width: number, height: number }} photo @param {Float64Array} points px of the photo
 */
function scaleOf({ width, height }, points) {
  const [left, top, right, bottom] = boxOf(points);
  const [least, most] = LONGEST.map((longest) => longest / Math.max(width, height));
  return Math.min(1, Math.max(least, Math.min(most, ENOUGH / Math.max(right - left, bottom - top))));
}

/** Thrown into whatever was waiting when the worker was ended. */
export class Cancelled extends Error {}
/** The same when it has ended by itself. */
export class Over extends Error {}

/**
 * @param {{ modelUrl: URL, expressionsUrl: URL | null }} files
 * @param {(why: string) => void} lost it has ended by itself, with what it knew of the photo that is edited
 */
export function createFitter({ modelUrl, expressionsUrl }, lost) {
  /** @type {Worker | null} */
  let worker = null;
  let count = 0;
  const urls = { modelUrl: modelUrl.href, expressionsUrl: expressionsUrl?.href ?? null };
  /** @type {Map<number, { done: (answer: any) => void, failed: (error: Error) => void, progress?: (part: number) => void }>} */
  const waiting = new Map();

  /** @param {Error} error */
  function end(error) {
    worker?.terminate();
    worker = null;
    for (const { failed } of waiting.values()) failed(error);
    waiting.clear();
  }

  /** @param {string} why */
  function fail(why) {
    lost(why);
    end(new Over(why));
  }

  /**
   * @param {string} task @param {Record<string, unknown>} wish
   * @param {(part: number) => void} [progress]
   * @returns {Promise<any>} rejected, too, where no worker may begin: nobody who asks is thrown at
   */
  async function ask(task, wish, progress) {
    if (!worker) {
      worker = new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
      worker.onmessage = ({ data }) => {
        const asked = waiting.get(data.id);
        if (data.progress !== undefined) return asked?.progress?.(data.progress);
        if (data.isOver) return fail(text.photo.toolsLost);
        waiting.delete(data.id);
        if (data.error !== undefined) asked?.failed(new Error(data.error));
        else asked?.done(data.answer);
      };
      // Of one that did not come there is no message.
      worker.onerror = (event) => fail(event.message ? text.photo.toolsLost : text.needsConnection);
    }
    const id = (count += 1);
    return new Promise((done, failed) => {
      waiting.set(id, { done, failed, progress });
      worker?.postMessage({ id, task, ...wish });
    });
  }

  return {
    /**
     * The pixels and points as the worker sees them; alpha is how much of a pixel is the person's, if that is
     * known.
     * @param {{ bitmap: ImageBitmap, width: number, height: number, focal?: number }} photo
     * @param {{ points: Float64Array, noise?: number, jawNoise?: number, irises?: Float64Array }} marks px of the photo
     * @param {import('./faces.js').Person | null} person
     */
    pixels({ bitmap, width, height, focal }, { points, noise, jawNoise, irises }, person) {
      const scale = scaleOf({ width, height }, points);
      const size = { width: Math.max(1, Math.round(scale * width)), height: Math.max(1, Math.round(scale * height)) };
      const canvas = new OffscreenCanvas(size.width, size.height);
      const context = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext('2d', { willReadFrequently: true }));
      context.imageSmoothingQuality = 'high';
      context.drawImage(bitmap, 0, 0, size.width, size.height);
      const { data: rgba } = context.getImageData(0, 0, size.width, size.height);
      let red = null;
      if (person) {
        // Beside the square nobody knows: there all is the person's.
        context.fillStyle = 'white';
        context.fillRect(0, 0, size.width, size.height);
        const side = scale * person.side;
        context.drawImage(person.mask, scale * person.x, scale * person.y, side, side);
        red = context.getImageData(0, 0, size.width, size.height).data;
      }
      // A photo's own transparency is none of a person's: where nobody is something is, which tells how dark the photo is.
      for (let i = 0; i < rgba.length; i += 4) rgba[i + 3] = red ? Math.max(1, red[i]) : 255;
      return {
        ...size,
        points: points.map((value) => value * scale),
        focal: focal && focal * scale,
        noise: noise && noise * scale,
        jawNoise: jawNoise && jawNoise * scale,
        irises: irises?.map((value) => value * scale),
        rgba,
        /** From the worker's px to the photo's. */
        scale: 1 / scale,
      };
    },
    /**
     * The face in the photo's own pixels, where `pixels` has fewer.
     * @param {{ bitmap: ImageBitmap, width: number, height: number }} photo
     * @param {Float64Array} points px of the photo
     * @returns {import('phiz').PhotoDetail | null}
     */
    detail({ bitmap, width, height }, points) {
      const fitted = scaleOf({ width, height }, points);
      const [left, top, right, bottom] = boxOf(points);
      const beside = AROUND_FACE * Math.max(right - left, bottom - top);
      const [x, y] = [Math.max(0, Math.floor(left - beside)), Math.max(0, Math.floor(top - beside))];
      const size = [Math.min(width, Math.ceil(right + beside)) - x, Math.min(height, Math.ceil(bottom + beside)) - y];
      // The bitmap of a large photo has fewer than its px itself.
      const kept = bitmap.width / width;
      const scale = Math.min(kept, FINEST / Math.max(...size));
      if (!(Math.min(...size) > 0) || scale < FINER * fitted) return null;
      const [wide, high] = size.map((side) => Math.max(1, Math.round(scale * side)));
      const context = /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(wide, high).getContext('2d', { willReadFrequently: true }));
      context.imageSmoothingQuality = 'high';
      context.drawImage(bitmap, kept * x, kept * y, kept * size[0], kept * size[1], 0, 0, wide, high);
      const { data: rgba } = context.getImageData(0, 0, wide, high);
      for (let i = 3; i < rgba.length; i += 4) rgba[i] = 255;
      return { rgba, width: wide, height: high, left: x * fitted, top: y * fitted, scale: scale / fitted };
    },
    /** Loads what fits need, ahead of the first. @returns {Promise<unknown>} */
    prepare: () => ask('prepare', urls),
    /**
     * @param {object} photo of `pixels`, and `others` of the same person
     * @param {(part: number) => void} progress the part of the steps that are done
     * @returns {Promise<import('phiz').PhotoFit>}
     */
    fit: (photo, progress) => ask('fit', { ...urls, photo }, progress),
    /**
     * From then on this photo is edited, until another is.
     * @param {{ width: number, height: number, rgba: Uint8ClampedArray, irises?: Float64Array }} photo of `pixels` @param {import('phiz').PhotoFit} fit
     * @param {import('phiz').PhotoOther[]} others of the same person, that the fit is of, too
     */
    edit: ({ width, height, rgba, irises }, fit, others) => ask('edit', { ...urls, photo: { width, height, rgba, irises }, fit, others }),
    /**
     * The head's colours as the photo has them.
     * @param {number} size texels a side
     * @param {import('phiz').PhotoDetail | null} detail
     * @returns {Promise<{ size: number, rgba: Uint8ClampedArray } | null>}
     */
    texture: (size, detail) => ask('texture', { size, detail }),
    /**
     * What the photo tells of the person beside the shape: the skin's albedo at some places, and glasses.
     * @param {import('./browtold.js').Places | undefined} places @param {import('../glasses/fit.js').Stand | null} stand of glasses on the fitted face
     * @returns {Promise<{ looks: import('phiz').PhotoLooks, albedos?: Float32Array, glasses: import('./glassestold.js').Glasses | null } | null>}
     */
    looks: (places, stand) => ask('looks', { places, stand }),
    /** @param {{ code: string, expression: Record<string, number> }} state */
    field: (state) => ask('field', { state }),
    cancel: () => end(new Cancelled()),
  };
}

/** @typedef {ReturnType<typeof createFitter>} Fitter */
