import { GIFEncoder, applyPalette, quantize } from 'gifenc';
import { eachFrame } from './frames.js';

/**
 * A film as an animated GIF that repeats for ever. One palette for all frames, so that nothing
 * flickers.
 *
 * @param {import('./frames.js').Film} film
 * @returns {Promise<Blob>}
 */
export async function gif(film) {
  const { fps = 25 } = film;
  /** @type {Uint8ClampedArray[]} */
  const frames = [];
  let [width, height] = [0, 0];
  // Taking a frame and writing it are about as long.
  const half = { ...film, progress: (/** @type {number} */ x) => film.progress?.(x / 2) };
  await eachFrame(half, (context) => {
    ({ width, height } = context.canvas);
    frames.push(context.getImageData(0, 0, width, height).data);
  });
  const palette = quantize(sample(frames), 256);
  const encoder = GIFEncoder();
  for (const [at, frame] of frames.entries()) {
    film.signal?.throwIfAborted();
    encoder.writeFrame(applyPalette(frame, palette), width, height, {
      // The first frame's palette is the file's.
      ...(at === 0 && { palette }),
      delay: 1000 / fps,
    });
    film.progress?.((1 + (at + 1) / frames.length) / 2);
    await new Promise((next) => setTimeout(next));
  }
  encoder.finish();
  return new Blob([encoder.bytes()], { type: 'image/gif' });
}

/**
 * Pixels from all over the film, RGBA: enough to choose colours by.
 * @param {Uint8ClampedArray[]} frames
 */
function sample(frames) {
  const chosen = [0, 0.25, 0.5, 0.75, 1].map((t) => frames[Math.round(t * (frames.length - 1))]);
  // A step that shares no factor with a row, so that no column is favoured.
  const step = 7;
  const each = Math.floor(chosen[0].length / 4 / step);
  const pixels = new Uint8ClampedArray(4 * each * chosen.length);
  chosen.forEach((frame, f) => {
    for (let i = 0; i < each; i++) {
      pixels.set(frame.subarray(4 * step * i, 4 * step * i + 4), 4 * (f * each + i));
    }
  });
  return pixels;
}
