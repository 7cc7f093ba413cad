import { eachFrame } from './frames.js';

/** WebM wherever there is a recorder for it; Safari has MP4 only. */
const KINDS = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm', 'video/mp4'];

/** What frames may take while they wait, bytes. */
const ROOM = 768 * 1024 * 1024;

/** The kind of video that this browser records, or null. */
export function videoKind() {
  if (typeof MediaRecorder !== 'function') return null;
  return KINDS.find((kind) => MediaRecorder.isTypeSupported(kind)) ?? null;
}

/**
 * A film as a video. The recorder goes by the clock, so frames are drawn first and then played to it
 * at their rate: a slow machine takes longer and gives the same film.
 *
 * @param {import('./frames.js').Film & { bitsPerSecond?: number }} film
 * @returns {Promise<Blob>} of type `video/webm`, or `video/mp4` where there is no other
 */
export async function video(film) {
  const { fps = 25, bitsPerSecond = 6_000_000 } = film;
  const kind = videoKind();
  if (!kind) throw new Error('this browser records no video');
  /** @type {ImageBitmap[]} */
  const frames = [];
  try {
    const half = { ...film, progress: (/** @type {number} */ x) => film.progress?.(x / 2) };
    await eachFrame(half, async (context, _, count) => {
      const { width, height } = context.canvas;
      if (4 * width * height * count > ROOM) {
        throw new RangeError(`a film of ${count} frames of ${width} x ${height} pixels is too large`);
      }
      frames.push(await createImageBitmap(context.canvas));
    });
    return await record(frames, fps, { mimeType: kind, videoBitsPerSecond: bitsPerSecond }, film);
  } finally {
    for (const frame of frames) frame.close();
  }
}

/**
 * @param {ImageBitmap[]} frames @param {number} fps @param {MediaRecorderOptions} options
 * @param {Pick<import('./frames.js').Film, 'progress' | 'signal'>} film
 */
async function record(frames, fps, options, { progress, signal }) {
  const screen = document.createElement('canvas');
  screen.width = frames[0].width;
  screen.height = frames[0].height;
  const context = screen.getContext('2d');
  if (!context) throw new Error('this browser gives no 2D canvas');
  // No frame by itself: only what is asked for, when it is asked for.
  const stream = screen.captureStream(0);
  const [track] = /** @type {CanvasCaptureMediaStreamTrack[]} */ (stream.getVideoTracks());
  const recorder = new MediaRecorder(stream, options);
  /** @type {Blob[]} */
  const chunks = [];
  recorder.ondataavailable = ({ data }) => chunks.push(data);
  const stopped = new Promise((done, fail) => {
    recorder.onstop = done;
    recorder.onerror = (event) => fail(/** @type {any} */ (event).error ?? new Error('the recorder failed'));
  });
  const started = new Promise((done) => (recorder.onstart = done));
  try {
    recorder.start();
    // It starts with the first picture that comes.
    context.drawImage(frames[0], 0, 0);
    track.requestFrame();
    await started;
    const start = performance.now();
    for (const [at, frame] of frames.entries()) {
      signal?.throwIfAborted();
      context.drawImage(frame, 0, 0);
      track.requestFrame();
      progress?.((1 + (at + 1) / frames.length) / 2);
      // The last frame is shown as long as the others.
      await new Promise((next) => setTimeout(next, start + (1000 * (at + 1)) / fps - performance.now()));
    }
    // A recording lasts until its last frame comes: this one ends it.
    track.requestFrame();
  } finally {
    if (recorder.state !== 'inactive') recorder.stop();
    track.stop();
  }
  await stopped;
  return new Blob(chunks, { type: (options.mimeType ?? '').split(';')[0] });
}
