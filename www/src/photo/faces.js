// The worker that finds faces. It goes with the search: what it holds is a hundred megabytes, and the next
// photo starts from the same state.
import { text } from '../text.js';

/** The photo is shown to it at most so large; it looks at faces with 192 px. */
const LONGEST = 2560;

/** @type {Worker | null} */
let worker = null;

/** Ends a search that nobody waits for any more. */
export function stopFinding() {
  worker?.terminate();
  worker = null;
}

/**
 * The faces of a photo, the largest first: 468 points each as x, y pairs, px of the photo.
 * @param {{ bitmap: ImageBitmap, width: number, height: number }} of
 * @param {(fraction: number) => void} progress
 * @returns {Promise<Float32Array[]>}
 */
export async function findFaces({ bitmap, width, height }, progress) {
  const scale = Math.min(1, LONGEST / Math.max(bitmap.width, bitmap.height));
  const photo = await createImageBitmap(bitmap, {
    resizeWidth: Math.round(scale * bitmap.width),
    resizeHeight: Math.round(scale * bitmap.height),
    resizeQuality: 'high',
  });
  const [sx, sy] = [width / photo.width, height / photo.height];
  stopFinding();
  const seeker = (worker = new Worker(new URL('./faces.worker.js', import.meta.url)));
  try {
    return await new Promise((done, failed) => {
      seeker.onmessage = ({ data }) => {
        if (data.error !== undefined) failed(new Error(text.photo.noDetector(data.error)));
        else if (data.faces) done(data.faces.map((/** @type {Float32Array} */ face) => face.map((value, i) => value * (i % 2 ? sy : sx))));
        else progress(data.progress);
      };
      seeker.onerror = (event) => failed(new Error(text.photo.noDetector(event.message || 'a script is missing')));
      const folder = new URL(__FACE_MESH__, document.baseURI).href;
      seeker.postMessage({ folder, photo }, [photo]);
    });
  } finally {
    if (worker === seeker) stopFinding();
  }
}
