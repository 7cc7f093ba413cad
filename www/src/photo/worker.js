// The face in a photo: the fit, and the fields of what is edited, off the page's thread. It has a model
// of its own.
import { load } from 'phiz';
import { tellGlasses } from './glassestold.js';

/** @typedef {{ width: number, height: number, points: Float64Array, focal?: number, noise?: number, jawNoise?: number, irises?: Float64Array, others: import('phiz').PhotoBeside[], rgba: Uint8ClampedArray<ArrayBuffer> }} Pixels */
/** @typedef {{ code: string, expression: Record<string, number> }} State */

/** @type {Promise<import('phiz').FaceModel> | null} */
let model = null;
/** @type {import('phiz').PhotoEdit | null} */
let edit = null;

/**
 * What it was opened from, and the other photos of the person.
 * @type {{ model: import('phiz').FaceModel, photo: Pick<Pixels, 'width' | 'height' | 'rgba'> & { fit: import('phiz').PhotoFit }, irises?: Float64Array, others: import('phiz').PhotoOther[] } | null}
 */
let edited = null;

/** @param {string} url */
async function bytesOf(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${response.status} ${response.statusText}`.trim());
  return response.arrayBuffer();
}

/** @param {string} url @param {string | null} expressions */
async function loadModel(url, expressions) {
  const [bytes, more] = await Promise.all([bytesOf(url), expressions && bytesOf(expressions)]);
  const loaded = await load(bytes);
  if (more) await loaded.loadExpressions(more);
  await loaded.preparePhotos();
  return loaded;
}

/** What fits photos: loaded once, and once more when it did not come. @param {{ modelUrl: string, expressionsUrl: string | null }} urls */
function prepared({ modelUrl, expressionsUrl }) {
  model ??= loadModel(modelUrl, expressionsUrl).catch((error) => {
    model = null;
    throw error;
  });
  return model;
}

/** @type {Record<string, (wish: any, tell: (progress: number) => void) => Promise<{ answer: unknown, transfer?: Transferable[] }>>} */
const TASKS = {
  async prepare(wish) {
    await prepared(wish);
    return { answer: true };
  },
  async fit({ photo: { width, height, points, focal, noise, jawNoise, irises, others, rgba }, ...wish }, progress) {
    const loaded = await prepared(wish);
    return { answer: await loaded.fitPhoto({ width, height, points, focal, noise, jawNoise, irises, others, rgba, progress }) };
  },
  async edit({ photo: { width, height, rgba, irises }, fit, others, ...wish }) {
    const loaded = await prepared(wish);
    edit?.free();
    edit = edited = null;
    const photo = { width, height, fit, rgba };
    edit = await loaded.editPhoto(photo);
    edited = { model: loaded, photo, irises, others };
    return { answer: true };
  },
  async texture({ size, detail }) {
    if (!edit || !edited) return { answer: null };
    const { model, photo, others } = edited;
    // Others take as long as the photo, each, and nothing but the head's colours needs them.
    const all = others.length > 0 ? await model.editPhoto({ ...photo, others }) : edit;
    try {
      const rgba = all.texture(photo.rgba, size, detail ?? undefined);
      return { answer: { size, rgba }, transfer: [rgba.buffer] };
    } finally {
      if (others.length > 0) all.free();
    }
  },
  async looks({ places, stand }) {
    if (!edit || !edited) return { answer: null };
    const { photo, irises } = edited;
    const { rgba, fit } = photo;
    const looks = edit.looks(rgba, irises);
    return { answer: { looks, albedos: places && edit.albedos(rgba, places.corners, places.shares), glasses: stand && tellGlasses(photo, fit.camera, stand) } };
  },
  async field({ state }) {
    const field = edit?.field(state) ?? null;
    return { answer: field, transfer: field ? [field.motion.buffer, field.gain.buffer] : [] };
  },
};

addEventListener('message', async ({ data: { id, task, ...wish } }) => {
  try {
    const { answer, transfer = [] } = await TASKS[task](wish, (progress) => postMessage({ id, progress }));
    postMessage({ id, answer }, { transfer });
  } catch (error) {
    // What a module was at when it ran out of memory is left half done: it is of no use any more.
    const isOver = error instanceof WebAssembly.RuntimeError || (error instanceof Error && error.cause instanceof WebAssembly.RuntimeError);
    postMessage({ id, isOver, error: error instanceof Error ? error.message : String(error) });
  }
});
