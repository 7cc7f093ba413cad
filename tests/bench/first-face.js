// How long the page's first face takes, beside a bare three.js page with a sphere of the same skin: from
// the address to the moment at which its pixels can be read. The page's is a head in plain colours; when
// its skin and its light are on the screen is told, too.

import { createRequire } from 'node:module';
import { fileURLToPath, pathToFileURL } from 'node:url';

import { launch, serve } from '../browser/site.js';

const require = createRequire(new URL('../../www/package.json', import.meta.url));
const ROUNDS = 7;

/**
 * The moments at which the pixels of the first large mesh on the screen are there to be read, and of the
 * first once the page says that its head is complete.
 */
function watch() {
  const draw = WebGL2RenderingContext.prototype.drawElements;
  WebGL2RenderingContext.prototype.drawElements = function (mode, count, ...rest) {
    draw.call(this, mode, count, ...rest);
    if (count < 50_000 || this.getParameter(this.FRAMEBUFFER_BINDING)) return;
    const what = document.documentElement.dataset.face === 'complete' ? 'complete' : 'shown';
    if (window[what] !== undefined) return;
    window[what] = 0;
    // After what else is drawn in this frame.
    queueMicrotask(() => {
      this.readPixels(0, 0, 1, 1, this.RGBA, this.UNSIGNED_BYTE, new Uint8Array(4));
      window[what] = performance.now();
    });
  };
}

/** @returns {Promise<Record<'page' | 'complete' | 'sphere', number[]>>} ms, sorted */
export async function firstFace() {
  const out = fileURLToPath(new URL('../../target/sphere', import.meta.url));
  const { build } = await import(pathToFileURL(require.resolve('vite')).href);
  await build({
    root: fileURLToPath(new URL('sphere', import.meta.url)),
    configFile: false,
    logLevel: 'error',
    base: './',
    resolve: { alias: [{ find: /^three$/, replacement: require.resolve('three').replace('three.cjs', 'three.module.js') }] },
    build: { outDir: out, emptyOutDir: true, target: 'es2022', modulePreload: { polyfill: false } },
  });
  const browser = await launch({ measured: true });
  const sites = { page: await serve(), sphere: await serve({ root: () => out }) };
  /** @type {Record<'page' | 'complete' | 'sphere', number[]>} */
  const times = { page: [], complete: [], sphere: [] };
  for (let round = 0; round < ROUNDS; round++) {
    for (const name of /** @type {const} */ (['page', 'sphere'])) {
      const context = await browser.newContext({ viewport: { width: 1000, height: 640 }, reducedMotion: 'reduce', serviceWorkers: 'block' });
      const page = await context.newPage();
      await page.addInitScript(watch);
      await page.goto(sites[name].url);
      await page.waitForFunction(() => window.shown > 0, null, { timeout: 60_000 });
      times[name].push(await page.evaluate(() => window.shown));
      if (name === 'page') {
        await page.waitForFunction(() => window.complete > 0, null, { timeout: 60_000 });
        times.complete.push(await page.evaluate(() => window.complete));
      }
      await context.close();
    }
  }
  await browser.close();
  await Promise.all(Object.values(sites).map((site) => site.close()));
  for (const list of Object.values(times)) list.sort((a, b) => a - b);
  return times;
}
