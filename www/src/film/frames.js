/**
 * What a film is made of: `draw(t)` shows the moment t, from 0 to 1, on `canvas` before it returns.
 *
 * @typedef {object} Film
 * @property {HTMLCanvasElement} canvas what is filmed
 * @property {(t: number) => void} draw
 * @property {number} seconds
 * @property {number} [fps] frames a second; 25 by default, which a GIF keeps exactly
 * @property {number} [width] pixels; the height follows the canvas. 480 by default, even in a video
 * @property {(fraction: number) => void} [progress] from 0 to 1
 * @property {AbortSignal} [signal] stops with its reason
 */

const MOST_FRAMES = 1500;

/**
 * How many pixels a film is wide and high: video encoders take even sizes only.
 * @param {Pick<Film, 'canvas' | 'width'>} film @returns {[number, number]}
 */
export function sizeOf({ canvas, width = 480 }) {
  const even = (/** @type {number} */ x) => 2 * Math.max(1, Math.round(x / 2));
  return [even(width), even((width * canvas.height) / canvas.width)];
}

/**
 * The frames of a film, one after the other: each is on the given context's canvas when its turn
 * comes. Between frames the page gets to run.
 *
 * @param {Film} film
 * @param {(context: CanvasRenderingContext2D, frame: number, count: number) => void | Promise<void>} take
 */
export async function eachFrame({ canvas, draw, seconds, fps = 25, width = 480, progress, signal }, take) {
  const count = Math.round(seconds * fps);
  if (!(count >= 2 && count <= MOST_FRAMES)) {
    throw new RangeError(`a film has 2 to ${MOST_FRAMES} frames, not ${count}`);
  }
  if (!(width >= 16 && width <= 4096)) throw new RangeError(`a film is 16 to 4096 pixels wide, not ${width}`);
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = sizeOf({ canvas, width });
  const context = copy.getContext('2d', { willReadFrequently: true });
  if (!context) throw new Error('this browser gives no 2D canvas');
  context.imageSmoothingQuality = 'high';
  const shape = canvas.width / canvas.height;
  for (let frame = 0; frame < count; frame++) {
    signal?.throwIfAborted();
    draw(frame / (count - 1));
    // By more than the rounding of its pixels.
    if (Math.abs(canvas.width / canvas.height / shape - 1) > 0.01) throw new Error('what is filmed has changed its shape');
    // A WebGL canvas keeps its picture until this task ends.
    context.drawImage(canvas, 0, 0, copy.width, copy.height);
    await take(context, frame, count);
    progress?.((frame + 1) / count);
    await new Promise((next) => setTimeout(next));
  }
}
