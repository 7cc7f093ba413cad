// Finds faces, with MediaPipe's face mesh, and what of a photo is a person, with its selfie segmentation,
// off the page's thread. A classic worker: these libraries know `importScripts` and no modules.
//
// They are half ready for workers (they forget their drawing context there), and whole in pages; so they
// are shown as much of a page as they look for: elements for a canvas and for scripts.
//
// The face mesh takes whatever it is sent for the next frame of a film and looks first where the last one had a
// face. Two black frames make it forget, so that a photo's points do not depend on the photo before.
// `minDetectionConfidence` is not set anywhere: setting it aborts the module.

const scope = /** @type {any} */ (self);
scope.window = self;
scope.document = {
  createElement(/** @type {string} */ name) {
    if (name === 'canvas') return Object.assign(new OffscreenCanvas(1, 1), { style: {} });
    /** @type {Record<string, any>} */
    const script = {
      setAttribute: (/** @type {string} */ key, /** @type {string} */ value) => (script[key] = value),
      addEventListener: (/** @type {string} */ event, /** @type {() => void} */ listener) => (script[`on${event}`] = listener),
    };
    return script;
  },
  body: {
    appendChild(/** @type {{ src: string, onload: () => void }} */ script) {
      scope.importScripts(script.src);
      script.onload();
    },
  },
  addEventListener() {},
  removeEventListener() {},
};
// What the library says of itself is not for people; what goes wrong is thrown.
console.log = console.info = console.warn = () => {};

/** @typedef {{ left: number, top: number, right: number, bottom: number }} Box px of the photo */
/** @typedef {{ x: number, y: number, side: number }} Square its left upper corner and its side, px */

/** Points of a face: those of the mesh, and five of each iris. */
const MESH = 478;
/** The middles of the subject's right and left iris among them: as in `points.js`, which a classic worker cannot import. */
const IRISES = [468, 473];
/** What is looked at is drawn at most so large, px, in a search and then closely: the detector itself sees 128, the mesh 192. */
const SEARCHED = 256;
const LOOKED_AT = 512;
/** A face is looked at so many times, closer each time. */
const LOOKS = 3;
/** A face in a crop this much larger than itself is where the library expects it. */
const AROUND = 1.9;
/** Smaller faces are not looked for: there would be no points to tell apart. */
const SMALLEST = 12;
/** The least tile, px: the detector sees faces from a tenth of a picture on, and better those of a fifth. */
const SMALLEST_TILE = 5 * SMALLEST;
/** Each tile's side is this part of the last one's: the detector sees faces of a fifth as it sees halves. */
const SMALLER = 0.4;
/** More tiles than this take longer than a person would wait for; fewer, when there is a face already. */
const MOST_TILES = 500;
const MOST_TILES_MORE = 60;

/** @type {any} */
let mesh = null;
/** @type {{ x: number, y: number }[][]} */
let seen = [];
const black = new OffscreenCanvas(128, 128);
black.getContext('2d')?.fillRect(0, 0, 128, 128);

/** @param {string} folder where the library's files are */
async function start(folder) {
  if (mesh) return;
  scope.importScripts(new URL('face_mesh.js', folder).href);
  mesh = new scope.FaceMesh({ locateFile: (/** @type {string} */ file) => new URL(file, folder).href });
  // On the CPU it gives the same points on every machine. WebGL 2 it needs all the same.
  mesh.setOptions({ maxNumFaces: 6, useCpuInference: true, refineLandmarks: true, selfieMode: false });
  mesh.onResults((/** @type {any} */ results) => (seen = results.multiFaceLandmarks ?? []));
  await mesh.initialize();
}

/** @param {OffscreenCanvas} canvas */
async function send(canvas) {
  seen = [];
  await mesh.send({ image: canvas });
  return seen;
}

/**
 * The faces in a square of the photo, in px of the photo.
 * @param {ImageBitmap} photo @param {Square} square @param {number} times it comes closer each time
 * @param {boolean} [mirrored] whether it is looked at in a mirror: sides are those of the mirror image
 */
async function look(photo, { x, y, side }, times, mirrored = false) {
  const size = Math.min(times > 1 ? LOOKED_AT : SEARCHED, Math.max(128, Math.round(side)));
  const canvas = new OffscreenCanvas(size, size);
  // Drawn by the processor: it is faster so, and the same on every machine.
  const context = canvas.getContext('2d', { willReadFrequently: true });
  if (!context) throw new Error('no canvas');
  context.imageSmoothingQuality = 'high';
  const scale = size / side;
  // Beside the photo it is black.
  context.fillRect(0, 0, size, size);
  if (mirrored) context.setTransform(-1, 0, 0, 1, size, 0);
  context.drawImage(photo, -x * scale, -y * scale, photo.width * scale, photo.height * scale);
  // Where nothing was seen there is nothing to forget; what counts is looked at from the same start always.
  if (times > 1 || seen.length > 0) {
    await send(black);
    await send(black);
  }
  for (let n = 0; n < times; n++) await send(canvas);
  const across = (/** @type {number} */ at) => x + (mirrored ? 1 - at : at) * side;
  return seen.map((face) => Float32Array.from(face.slice(0, MESH).flatMap((point) => [across(point.x), y + point.y * side])));
}

/**
 * Irises are seen off to one side, the same one in a mirror: their middles become the mean of both.
 * @param {ImageBitmap} photo @param {Float32Array} points of a face
 */
async function centreIrises(photo, points) {
  const box = boxOf(points);
  const [inMirror] = (await look(photo, squareAround(box, AROUND), LOOKS, true)).filter((other) => same(boxOf(other), box));
  if (!inMirror) return;
  IRISES.forEach((own, i) => {
    const there = IRISES[1 - i];
    for (const axis of [0, 1]) points[2 * own + axis] = (points[2 * own + axis] + inMirror[2 * there + axis]) / 2;
  });
}

/** @param {Float32Array} points @returns {Box} */
function boxOf(points) {
  const box = { left: Infinity, top: Infinity, right: -Infinity, bottom: -Infinity };
  for (let i = 0; i < points.length; i += 2) {
    box.left = Math.min(box.left, points[i]);
    box.right = Math.max(box.right, points[i]);
    box.top = Math.min(box.top, points[i + 1]);
    box.bottom = Math.max(box.bottom, points[i + 1]);
  }
  return box;
}
/** @param {Box} box */
const sizeOf = (box) => Math.max(box.right - box.left, box.bottom - box.top);
/** @param {Box} box @param {number} factor @returns {Square} */
function squareAround(box, factor) {
  const side = factor * sizeOf(box);
  return { x: (box.left + box.right - side) / 2, y: (box.top + box.bottom - side) / 2, side };
}
/** Whether two boxes are of one face. @param {Box} a @param {Box} b */
function same(a, b) {
  const away = Math.hypot(a.left + a.right - b.left - b.right, a.top + a.bottom - b.top - b.bottom) / 2;
  return away < 0.5 * Math.max(sizeOf(a), sizeOf(b));
}

/**
 * Squares that cover the photo with overlap, so that each face up to half of one lies whole in some.
 * @param {number} width @param {number} height @param {number} side
 */
function tiles(width, height, side) {
  const places = (/** @type {number} */ length) => {
    const count = Math.max(1, Math.ceil((length - side) / (side / 2)) + 1);
    return Array.from({ length: count }, (_, i) => (count === 1 ? (length - side) / 2 : (i * (length - side)) / (count - 1)));
  };
  return places(height).flatMap((y) => places(width).map((x) => ({ x, y, side })));
}

/**
 * All faces, the largest first.
 * @param {ImageBitmap} photo @param {(fraction: number) => void} progress
 */
async function find(photo, progress) {
  const { width, height } = photo;
  const short = Math.min(width, height);
  // The whole of it in one square, then smaller and smaller ones.
  const levels = [[{ x: (width - Math.max(width, height)) / 2, y: (height - Math.max(width, height)) / 2, side: Math.max(width, height) }]];
  for (let side = short; side >= SMALLEST_TILE; side *= SMALLER) {
    const level = tiles(width, height, side);
    if (level.length > MOST_TILES) break;
    if (side < short || width !== height) levels.push(level);
  }
  /** @type {Float32Array[]} */
  const found = [];
  for (let n = 0, last = levels.length; n < last; n++) {
    const before = found.length;
    for (const [i, tile] of levels[n].entries()) {
      progress((n + i / levels[n].length) / last);
      for (const rough of await look(photo, tile, 1)) {
        const box = boxOf(rough);
        if (sizeOf(box) < SMALLEST || found.some((known) => same(boxOf(known), box))) continue;
        const [close] = (await look(photo, squareAround(box, AROUND), LOOKS)).filter((points) => same(boxOf(points), box));
        if (!close || found.some((known) => same(boxOf(known), boxOf(close)))) continue;
        await centreIrises(photo, close);
        found.push(close);
      }
    }
    // A portrait has one face; where the largest is smaller, others may stand behind.
    if (found.some((points) => sizeOf(boxOf(points)) > 0.4 * short)) break;
    if (found.length > before) last = (levels[n + 1]?.length ?? 0) > MOST_TILES_MORE ? n + 1 : Math.min(last, n + 2);
  }
  return found.sort((a, b) => sizeOf(boxOf(b)) - sizeOf(boxOf(a)));
}

/** The mask has so many px a side, whatever it is of. */
const MASK = 256;

/** @type {any} */
let segmentation = null;
/** @type {ImageBitmap | null} */
let personSeen = null;

/** @param {string} folder where the library's files are */
async function startSegmentation(folder) {
  if (segmentation) return;
  scope.importScripts(new URL('selfie_segmentation.js', folder).href);
  segmentation = new scope.SelfieSegmentation({ locateFile: (/** @type {string} */ file) => new URL(file, folder).href });
  segmentation.setOptions({ modelSelection: 0, selfieMode: false });
  segmentation.onResults((/** @type {any} */ results) => (personSeen = results.segmentationMask));
  await segmentation.initialize();
}

/**
 * How much of each pixel of a square of the photo is a person's: red, of 255.
 * @param {string} folder where the library's files are
 * @param {ImageBitmap} photo @param {Square} square
 */
async function mask(folder, photo, { x, y, side }) {
  await startSegmentation(folder);
  const canvas = new OffscreenCanvas(MASK, MASK);
  const context = canvas.getContext('2d', { willReadFrequently: true });
  if (!context) throw new Error('no canvas');
  context.imageSmoothingQuality = 'high';
  const scale = MASK / side;
  context.drawImage(photo, -x * scale, -y * scale, photo.width * scale, photo.height * scale);
  await segmentation.send({ image: canvas });
  const found = personSeen;
  if (!found) throw new Error('no mask');
  // What it gives is red where the person is, and clear elsewhere: drawn over anything it would be no mask.
  context.fillStyle = 'black';
  context.fillRect(0, 0, MASK, MASK);
  context.drawImage(found, 0, 0, MASK, MASK);
  return createImageBitmap(canvas);
}

/** What is prepared, or failed to be: whoever asks waits for it. @type {Promise<void> | null} */
let prepared = null;

addEventListener('message', async ({ data: { prepare, folder, photo, square } }) => {
  if (prepare) {
    prepared = prepare === 'person' ? startSegmentation(folder) : start(folder);
    // Told when it is asked.
    prepared.catch(() => {});
    return;
  }
  try {
    await prepared;
    if (square) {
      const person = await mask(folder, photo, square);
      return postMessage({ answer: person }, { transfer: [person] });
    }
    await start(folder);
    const faces = await find(photo, (fraction) => postMessage({ progress: fraction }));
    photo.close();
    postMessage({ answer: faces });
  } catch (error) {
    postMessage({ error: error instanceof Error ? error.message : String(error) });
  }
});
