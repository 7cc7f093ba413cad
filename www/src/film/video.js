import { ArrayBufferTarget, Muxer } from 'webm-muxer';

import { eachFrame, sizeOf } from './frames.js';

/** What an encoder is asked for by, the better first. VP9 of level 6.1: its frames have up to 4096 pixels a side. */
const ENCODED = [
  { codec: 'vp09.00.61.08', id: 'V_VP9' },
  { codec: 'vp8', id: 'V_VP8' },
];

/** What a recorder is asked for, where there is no encoder: Safari has MP4 only. */
const RECORDED = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm', 'video/mp4'];

/** What frames may take while they wait for the recorder, bytes. */
const ROOM = 768 * 1024 * 1024;

/** Frames from one that stands alone to the next: how finely a player can jump. */
const KEY_FRAME = 25;

/** What a busy machine takes to hand a frame to the recorder, ms. */
const DELIVERED = 100;

/** Frames that may wait for the encoder. */
const QUEUE = 8;

/** @typedef {import('./frames.js').Film & { bitsPerSecond?: number }} VideoFilm */

/**
 * A film as a video: encoded frame by frame, each at its own time, as fast as the machine can. Where
 * there is no encoder, or none for WebM, it is recorded while it plays.
 *
 * @param {VideoFilm} film
 * @returns {Promise<Blob>} of type `video/webm`, or `video/mp4` where there is no other
 */
export async function video(film) {
  const found = await encoding(film);
  return found ? encoded(film, found) : recorded(film);
}

/**
 * How this browser encodes a film; null when it does not.
 * @param {VideoFilm} film
 */
async function encoding({ fps = 25, bitsPerSecond = 6_000_000, ...film }) {
  if (typeof VideoEncoder !== 'function') return null;
  const [width, height] = sizeOf(film);
  for (const { codec, id } of ENCODED) {
    const wanted = { codec, width, height, bitrate: bitsPerSecond, framerate: fps };
    const { supported, config } = await VideoEncoder.isConfigSupported(wanted);
    if (supported && config) return { id, config };
  }
  return null;
}

/** @param {VideoFilm} film @param {{ id: string, config: VideoEncoderConfig }} encoding */
async function encoded(film, { id, config }) {
  const { fps = 25, signal } = film;
  const { width, height } = config;
  const target = new ArrayBufferTarget();
  const muxer = new Muxer({ target, video: { codec: id, width, height, frameRate: fps } });
  /** @type {unknown} */
  let failure = null;
  const encoder = new VideoEncoder({
    output: (chunk, meta) => muxer.addVideoChunk(chunk, meta),
    error: (error) => (failure = error),
  });
  const take = (/** @type {HTMLCanvasElement} */ canvas, /** @type {number} */ frame) => {
    const picture = new VideoFrame(canvas, { timestamp: Math.round((1e6 * frame) / fps) });
    encoder.encode(picture, { keyFrame: frame % KEY_FRAME === 0 });
    picture.close();
  };
  try {
    encoder.configure(config);
    await eachFrame(film, async ({ canvas }, frame, count) => {
      take(canvas, frame);
      // The file says when frames begin, and the last would be gone as soon as it comes.
      if (frame === count - 1) take(canvas, count);
      while (!failure && encoder.encodeQueueSize > QUEUE) await new Promise((next) => setTimeout(next, 1));
      if (failure) throw failure;
    });
    await encoder.flush();
    signal?.throwIfAborted();
    muxer.finalize();
  } catch (error) {
    // What the encoder said of itself tells more than that it is closed.
    throw failure ?? error;
  } finally {
    if (encoder.state !== 'closed') encoder.close();
  }
  return new Blob([target.buffer], { type: 'video/webm' });
}

/**
 * The recorder goes by the clock, so frames are drawn first and then played to it at their rate. It
 * holds the first while it gets ready.
 * @param {VideoFilm} film
 */
async function recorded(film) {
  const { fps = 25, bitsPerSecond = 6_000_000 } = film;
  const kind = typeof MediaRecorder === 'function' && RECORDED.find((kind) => MediaRecorder.isTypeSupported(kind));
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
  // It may fail while frames are played, and is waited for after them.
  stopped.catch(() => {});
  const started = new Promise((done) => (recorder.onstart = done));
  const aborted = new Promise((_, fail) => signal?.addEventListener('abort', () => fail(signal.reason), { once: true }));
  aborted.catch(() => {});
  try {
    signal?.throwIfAborted();
    recorder.start();
    // It starts with the first picture that comes.
    context.drawImage(frames[0], 0, 0);
    track.requestFrame();
    // One that cannot start never says so.
    await Promise.race([started, stopped, aborted]);
    const start = performance.now();
    for (const [at, frame] of frames.entries()) {
      signal?.throwIfAborted();
      context.drawImage(frame, 0, 0);
      track.requestFrame();
      progress?.((1 + (at + 1) / frames.length) / 2);
      // The last frame is shown as long as the others.
      await new Promise((next) => setTimeout(next, start + (1000 * (at + 1)) / fps - performance.now()));
    }
    // A recording lasts until its last frame comes: this one ends it, where it comes before the end of the recorder.
    context.drawImage(frames[frames.length - 1], 0, 0);
    track.requestFrame();
    await new Promise((next) => setTimeout(next, DELIVERED));
  } finally {
    if (recorder.state !== 'inactive') recorder.stop();
    track.stop();
  }
  await stopped;
  return new Blob(chunks, { type: (options.mimeType ?? '').split(';')[0] });
}
