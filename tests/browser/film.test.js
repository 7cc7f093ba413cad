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
      optimizeDeps: { entries: [], include: ['gifenc'] },
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

  test('a video plays from the first frame to the last, as long as it was asked to be', async () => {
    const found = await page.evaluate(async () => {
      const { video, videoKind } = await import('/src/film/video.js');
      const blob = await video({ ...window.film(), seconds: 1.2, width: 200 });
      const player = document.createElement('video');
      player.muted = true;
      player.src = URL.createObjectURL(blob);
      /** @type {number[]} */
      const bars = [];
      /** @type {number[]} */
      const times = [];
      const look = (/** @type {number} */ _, /** @type {VideoFrameCallbackMetadata} */ { mediaTime }) => {
        times.push(mediaTime);
        bars.push(window.bar(player, 200, 120));
        player.requestVideoFrameCallback(look);
      };
      player.requestVideoFrameCallback(look);
      const ended = new Promise((done, fail) => {
        player.onended = done;
        player.onerror = () => fail(new Error(player.error?.message));
      });
      // Slowly, so that a busy machine shows every frame.
      player.playbackRate = 0.25;
      await player.play();
      await ended;
      return { kind: videoKind(), type: blob.type, width: player.videoWidth, height: player.videoHeight, bars, times, duration: player.currentTime };
    });
    assert.match(found.kind, /^video\/webm/);
    assert.equal(found.type, 'video/webm');
    assert.deepEqual([found.width, found.height], [200, 120]);
    // The first frame is held while the encoder gets ready, which takes longer on a busy machine.
    const held = found.duration - 1.2;
    assert.ok(held > -0.05 && held < 0.5, `${found.duration} s`);
    assert.ok(found.bars[0] < 0.1 && found.bars.at(-1) > 0.95, `${found.bars}`);
    assert.ok(found.bars.every((bar, i) => i === 0 || bar >= found.bars[i - 1] - 0.01), 'in order');
    // From then on the bar is where the clock says, to three frames and the lossy edge.
    found.bars.forEach((bar, i) => {
      const due = Math.min(1, Math.max(0, (found.times[i] - held) / 1.16));
      assert.ok(Math.abs(bar - due) < 0.14, `${found.times[i]} s: ${bar}, not ${due}`);
    });
    assert.ok(found.bars.length >= 15, `${found.bars.length} frames of 30 were seen`);
  });

  test('what cannot be filmed is refused in a sentence, and a film can be stopped', async () => {
    const found = await page.evaluate(async () => {
      const { gif } = await import('/src/film/gif.js');
      const { video } = await import('/src/film/video.js');
      const why = (/** @type {Promise<unknown>} */ film) => film.then(() => 'made', (/** @type {Error} */ e) => `${e.name}: ${e.message}`);
      const stop = new AbortController();
      const film = window.film();
      const stopped = why(
        video({ ...film, seconds: 2, progress: (x) => x > 0.1 && stop.abort(), signal: stop.signal }),
      );
      return {
        short: await why(gif({ ...window.film(), seconds: 0 })),
        long: await why(video({ ...window.film(), seconds: 1e4 })),
        wide: await why(gif({ ...window.film(), seconds: 1, width: 1e5 })),
        large: await why(video({ ...window.film(), seconds: 60, width: 4096 })),
        stopped: await stopped,
        drawn: film.times.length,
      };
    });
    assert.match(found.short, /^RangeError: a film has 2 to 1500 frames, not 0/);
    assert.match(found.long, /^RangeError: a film has 2 to 1500 frames, not 250000/);
    assert.match(found.wide, /^RangeError: a film is 16 to 4096 pixels wide/);
    assert.match(found.large, /^RangeError: .* is too large/);
    assert.match(found.stopped, /^AbortError/);
    assert.ok(found.drawn < 30, `${found.drawn} of 50 frames were drawn`);
  });
});
