// Films as GIF and WebM. The modules run as they are, from Vite's development server, and Chromium's
// own decoders look at what they made.
import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { after, before, describe, test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { launch } from './site.js';

const require = createRequire(new URL('../../www/package.json', import.meta.url));

describe('films', () => {
  /** @type {import('vite').ViteDevServer} */
  let server;
  /** @type {import('playwright-core').Browser} */
  let browser;
  /** @type {import('playwright-core').Page} */
  let page;
  before(async () => {
    const { createServer } = await import(require.resolve('vite'));
    const root = fileURLToPath(new URL('../../www', import.meta.url));
    server = await createServer({
      root,
      configFile: false,
      logLevel: 'error',
      server: { port: 0, host: '127.0.0.1', hmr: false },
      optimizeDeps: { entries: [], include: ['gifenc', 'webm-muxer'] },
      cacheDir: fileURLToPath(new URL('../../target/vite', import.meta.url)),
    });
    await server.listen();
    browser = await launch();
    page = await browser.newPage();
    const { port } = /** @type {import('node:net').AddressInfo} */ (server.httpServer?.address());
    // An empty page of the server's origin: the modules are all that is needed of it.
    const empty = `http://127.0.0.1:${port}/empty`;
    await page.route(empty, (route) => route.fulfill({ contentType: 'text/html', body: '<!doctype html>' }));
    await page.goto(empty);
    // A white bar goes from left to right over red; 100 x 60 pixels.
    await page.evaluate(() => {
      window.film = () => {
        const canvas = document.createElement('canvas');
        [canvas.width, canvas.height] = [100, 60];
        const context = canvas.getContext('2d');
        /** @type {number[]} */
        const times = [];
        return {
          canvas,
          times,
          draw(/** @type {number} */ t) {
            times.push(t);
            context.fillStyle = '#c02010';
            context.fillRect(0, 0, 100, 60);
            context.fillStyle = '#ffffff';
            context.fillRect(80 * t, 0, 20, 60);
          },
        };
      };
      // Where the bar is, 0 to 1: the middle of all that is light.
      window.bar = (/** @type {CanvasImageSource} */ image, /** @type {number} */ width, /** @type {number} */ height) => {
        const canvas = new OffscreenCanvas(width, height);
        const context = canvas.getContext('2d');
        context.drawImage(image, 0, 0, width, height);
        const { data } = context.getImageData(0, Math.floor(height / 2), width, 1);
        let [sum, count] = [0, 0];
        for (let x = 0; x < width; x++) if (data[4 * x + 1] > 140) [sum, count] = [sum + x + 0.5, count + 1];
        return (sum / count / width - 0.1) / 0.8;
      };
    });
  });
  after(async () => {
    await browser?.close();
    await server?.close();
  });

  test('a GIF has every frame, in time and in its colours', async () => {
    const found = await page.evaluate(async () => {
      const { gif } = await import('/src/film/gif.js');
      const film = window.film();
      /** @type {number[]} */
      const progress = [];
      const blob = await gif({ ...film, seconds: 0.8, width: 100, progress: (x) => progress.push(x) });
      const decoder = new ImageDecoder({ data: await blob.arrayBuffer(), type: 'image/gif' });
      await decoder.tracks.ready;
      await decoder.completed;
      const { frameCount, repetitionCount } = decoder.tracks.selectedTrack;
      const frames = [];
      let corner = null;
      for (let i = 0; i < frameCount; i++) {
        const { image } = await decoder.decode({ frameIndex: i });
        frames.push({ milliseconds: image.duration / 1000, bar: window.bar(image, 100, 60) });
        if (i === frameCount - 1) {
          const context = new OffscreenCanvas(100, 60).getContext('2d');
          context.drawImage(image, 0, 0);
          corner = Array.from(context.getImageData(0, 0, 1, 1).data);
        }
        image.close();
      }
      return { type: blob.type, repetitionCount, frames, corner, times: film.times, progress };
    });
    assert.equal(found.type, 'image/gif');
    assert.equal(found.frames.length, 20, '0.8 s of 25 frames');
    assert.equal(found.repetitionCount, Infinity);
    found.frames.forEach(({ milliseconds, bar }, i) => {
      assert.equal(milliseconds, 40);
      // Half a pixel of a hundred, over the bar's way of eighty.
      assert.ok(Math.abs(bar - i / 19) < 0.01, `frame ${i}: ${bar}`);
    });
    // The palette's colours have five or six bits a channel.
    [0xc0, 0x20, 0x10, 255].forEach((value, k) => assert.ok(Math.abs(found.corner[k] - value) <= 8));
    assert.deepEqual([found.times[0], found.times.at(-1)], [0, 1]);
    assert.equal(found.progress.at(-1), 1);
    assert.ok(found.progress.every((x, i) => i === 0 || x >= found.progress[i - 1]));
  });

  // What a player shows of a video, and when.
  const played = (/** @type {{ encoder: 'whole' | 'other' | 'none' }} */ { encoder }) =>
    page.evaluate(async (encoder) => {
      const { video } = await import('/src/film/video.js');
      const { VideoEncoder } = window;
      // Some know only codecs that WebM does not hold.
      const other = { isConfigSupported: async () => ({ supported: false }) };
      if (encoder !== 'whole') window.VideoEncoder = encoder === 'none' ? undefined : Object.assign(() => {}, other);
      /** @type {number[]} */
      const progress = [];
      const blob = await video({ ...window.film(), seconds: 1.2, width: 200, progress: (x) => progress.push(x) });
      window.VideoEncoder = VideoEncoder;
      const player = document.createElement('video');
      player.muted = true;
      player.src = URL.createObjectURL(blob);
      /** @type {{ time: number, bar: number }[]} */
      const frames = [];
      const look = (/** @type {number} */ _, /** @type {VideoFrameCallbackMetadata} */ { mediaTime }) => {
        frames.push({ time: mediaTime, bar: window.bar(player, 200, 120) });
        player.requestVideoFrameCallback(look);
      };
      player.requestVideoFrameCallback(look);
      const ended = new Promise((done, fail) => {
        player.onended = done;
        player.onerror = () => fail(new Error(player.error?.message));
      });
      // Slowly, so that a busy machine shows its frames.
      player.playbackRate = 0.25;
      await player.play();
      await ended;
      return { type: blob.type, width: player.videoWidth, height: player.videoHeight, frames, duration: player.currentTime, progress };
    }, encoder);

  test('a video plays from the first frame to the last, each at its time', async () => {
    const found = await played({ encoder: 'whole' });
    assert.equal(found.type, 'video/webm');
    assert.deepEqual([found.width, found.height], [200, 120]);
    // 30 frames of 40 ms; times have milliseconds in the file.
    assert.ok(Math.abs(found.duration - 1.2) < 0.002, `${found.duration} s`);
    for (const { time, bar } of found.frames) {
      const due = Math.min(1, Math.round(time * 25) / 29);
      // A pixel and a half of 160, for the lossy edge.
      assert.ok(Math.abs(bar - due) < 0.01, `${time} s: ${bar}, not ${due}`);
    }
    assert.ok(found.frames[0].time < 0.1 && found.frames.at(-1).time > 1.1, `${found.frames.map(({ time }) => time)}`);
    assert.equal(found.progress.at(-1), 1);
  });

  for (const [what, encoder] of /** @type {const} */ ([['is no encoder', 'none'], ['is no encoder for it', 'other']])) {
    test(`where there ${what} a video is recorded, in order and whole`, async () => {
      const found = await played({ encoder });
      assert.equal(found.type, 'video/webm');
      assert.deepEqual([found.width, found.height], [200, 120]);
      // The recorder goes by the clock and holds the first frame until it is ready, for as long as the
      // machine is busy: it is longer than was asked for, never shorter.
      assert.ok(found.duration > 1.15, `${found.duration} s`);
      const bars = found.frames.map(({ bar }) => bar);
      assert.ok(bars[0] < 0.1 && bars.at(-1) > 0.95, `${bars}`);
      assert.ok(bars.every((bar, i) => i === 0 || bar >= bars[i - 1] - 0.01), 'in order');
      assert.equal(found.progress.at(-1), 1);
    });
  }

  test('what cannot be filmed is refused in a sentence, and a film can be stopped', async () => {
    const found = await page.evaluate(async () => {
      const { gif } = await import('/src/film/gif.js');
      const { video } = await import('/src/film/video.js');
      const why = (/** @type {Promise<unknown>} */ film) => film.then(() => 'made', (/** @type {Error} */ e) => `${e.name}: ${e.message}`);
      // As in a browser that has no encoder, or no recorder either.
      const recorded = async (/** @type {() => Promise<unknown>} */ film, neither = false) => {
        const { VideoEncoder, MediaRecorder } = window;
        window.VideoEncoder = undefined;
        if (neither) window.MediaRecorder = undefined;
        const said = await why(film());
        Object.assign(window, { VideoEncoder, MediaRecorder });
        return said;
      };
      // A recorder that fails before it starts, and one that never does.
      const silent = async (/** @type {(recorder: any) => void} */ begin, /** @type {AbortSignal} */ signal) => {
        const { MediaRecorder } = window;
        window.MediaRecorder = class {
          static isTypeSupported = () => true;
          state = 'inactive';
          start() {
            begin(this);
          }
        };
        const said = await recorded(() => Promise.race([video({ ...window.film(), seconds: 0.2, signal }), new Promise((_, late) => setTimeout(late, 20_000, new Error('it waits for ever')))]));
        window.MediaRecorder = MediaRecorder;
        return said;
      };
      const never = new AbortController();
      const stop = new AbortController();
      const film = window.film();
      const stopped = why(
        video({ ...film, seconds: 2, progress: (x) => x > 0.1 && stop.abort(), signal: stop.signal }),
      );
      return {
        short: await why(gif({ ...window.film(), seconds: 0 })),
        long: await why(video({ ...window.film(), seconds: 1e4 })),
        wide: await why(gif({ ...window.film(), seconds: 1, width: 1e5 })),
        large: await recorded(() => video({ ...window.film(), seconds: 60, width: 4096 })),
        failed: await silent((recorder) => setTimeout(() => recorder.onerror({ error: new Error('no room to record') })), never.signal),
        given: await silent(() => setTimeout(() => never.abort()), never.signal),
        none: await recorded(() => video({ ...window.film(), seconds: 1 }), true),
        stopped: await stopped,
        drawn: film.times.length,
      };
    });
    assert.match(found.short, /^RangeError: a film has 2 to 1500 frames, not 0/);
    assert.match(found.long, /^RangeError: a film has 2 to 1500 frames, not 250000/);
    assert.match(found.wide, /^RangeError: a film is 16 to 4096 pixels wide/);
    assert.match(found.large, /^RangeError: .* is too large/);
    assert.match(found.failed, /^Error: no room to record/);
    assert.match(found.given, /^AbortError/);
    assert.match(found.none, /^Error: this browser records no video/);
    assert.match(found.stopped, /^AbortError/);
    assert.ok(found.drawn < 30, `${found.drawn} of 50 frames were drawn`);
  });
});
