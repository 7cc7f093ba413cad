// The built page on a server of its own, and Chromium to open it.

import { execFileSync } from 'node:child_process';
import { createReadStream, existsSync, mkdirSync, statSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { extname, join, normalize, sep } from 'node:path';
import { after, before } from 'node:test';
import { fileURLToPath } from 'node:url';
import { inflateSync } from 'node:zlib';

import { TOGETHER } from '../../www/src/editing/history.js';

const require = createRequire(new URL('../../www/package.json', import.meta.url));
/** @type {typeof import('playwright-core')} */
const { chromium } = require('playwright-core');

export const DIST = fileURLToPath(new URL('../../www/dist', import.meta.url));
export const SCREENSHOTS = fileURLToPath(new URL('../../target/screenshots', import.meta.url));

const TYPES = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript',
  '.css': 'text/css',
  '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm',
  '.phiz': 'application/octet-stream',
  '.png': 'image/png',
  '.webmanifest': 'application/manifest+json',
};

/**
 * Serves `www/dist` under a path that is not the root: the site must work anywhere.
 * @param {{ model?: Buffer | null, root?: () => string, headers?: Record<string, string>, base?: string }} [options]
 *   `model` replaces the model; null makes it missing. `root` gives the folder that is served,
 *   `headers` go with every answer.
 */
export async function serve({ model, root = () => DIST, headers = {}, base = '/some/where/' } = {}) {
  const server = createServer((request, response) => {
    const { pathname } = new URL(request.url ?? '/', 'http://localhost');
    if (!pathname.startsWith(base)) return void response.writeHead(404).end();
    const name = normalize(pathname.slice(base.length).replace(/(^|\/)$/, '$1index.html'));
    if (name === 'model.phiz' && model !== undefined) {
      if (model === null) return void response.writeHead(404).end();
      return void response.writeHead(200, { 'content-length': model.length }).end(model);
    }
    const file = join(root(), name);
    if (!file.startsWith(root() + sep) || !existsSync(file)) return void response.writeHead(404).end();
    response.writeHead(200, {
      ...headers,
      'content-type': TYPES[extname(file)] ?? 'application/octet-stream',
      'content-length': statSync(file).size,
    });
    createReadStream(file).pipe(response);
  });
  // A test that fails leaves it open: nobody waits for it.
  server.unref();
  await new Promise((ready) => server.listen(0, '127.0.0.1', () => ready(undefined)));
  const address = server.address();
  if (!address || typeof address === 'string') throw new Error('the server has no port');
  return {
    url: `http://127.0.0.1:${address.port}${base}`,
    origin: `http://127.0.0.1:${address.port}`,
    close: () => {
      server.closeAllConnections();
      return new Promise((done) => server.close(done));
    },
  };
}

function findChromium() {
  const named = process.env.PHIZ_CHROMIUM;
  if (named) return named;
  if (existsSync('/usr/bin/chromium')) return '/usr/bin/chromium';
  for (const name of ['chromium', 'google-chrome']) {
    try {
      return execFileSync('which', [name], { encoding: 'utf8' }).trim();
    } catch {
      // Try the next name.
    }
  }
  throw new Error('no Chromium found: install Debian\'s "chromium" or set PHIZ_CHROMIUM');
}

/**
 * What a browser is not to have, beside what Playwright takes away and we need: of two lists it heeds the last. With each profile
 * it loads three pages for what is typed into its address bar, which takes a third of what opening ours takes.
 */
const WITHOUT = [
  'WebUIOmniboxPopup',
  'WebUIOmniboxAimPopup',
  'WebUIOmniboxFullPopup',
  // As in Playwright's.
  'DestroyProfileOnBrowserClose',
  'HttpsUpgrades',
  'LensOverlay',
  'MediaRouter',
  'OptimizationHints',
  'PaintHolding',
  'ThirdPartyStoragePartitioning',
];

/**
 * A browser without a graphics card. Where nobody measures how fast it draws, its page is put together without one, too: software
 * that plays one would take half of the time that a test's drawing takes for that.
 * @param {{ measured?: boolean }} [options]
 */
export async function launch({ measured = false } = {}) {
  mkdirSync(SCREENSHOTS, { recursive: true });
  const options = {
    executablePath: findChromium(),
    args: [
      '--headless',
      '--no-sandbox',
      '--use-gl=angle',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      '--no-first-run',
      `--disable-features=${WITHOUT}`,
      ...(measured ? [] : ['--disable-gpu-compositing']),
    ],
  };
  try {
    return await chromium.launch(options);
  } catch (error) {
    // Of some thousand starts one ends in a fault of Chromium's own, before there is a page.
    if (!`${error}`.includes('signal=SIG')) throw error;
    console.error(`Chromium is started again, as it fell while it started: ${`${error}`.split('\n')[0]}`);
    return chromium.launch(options);
  }
}

/** The page on its server and a browser, for the tests of one file: both end with them. */
export async function siteAndBrowser() {
  const [site, browser] = await Promise.all([serve(), launch()]);
  after(async () => {
    await browser.close();
    await site.close();
  });
  return { site, browser };
}

/**
 * Hears what a page complains of: errors, warnings, and what nobody caught.
 * @param {import('playwright-core').Page} page
 */
export function complaintsOf(page) {
  /** @type {string[]} */
  const complaints = [];
  page.on('console', (message) => {
    // That the canvas is fetched is how a page is put together without a graphics card.
    if (message.text().includes('GPU stall due to ReadPixels')) return;
    if (['error', 'warning'].includes(message.type())) complaints.push(message.text());
  });
  page.on('pageerror', (error) => complaints.push(error.stack ?? error.message));
  return complaints;
}

/** For who looks at what is small. */
export const TALL = { width: 1000, height: 640 };

/**
 * A graphics card that has no large textures: the skin of a GLB is painted as large as it has them, which takes a processor ten
 * seconds for those that are common.
 * @param {import('playwright-core').Page} page
 */
export function smallTextures(page) {
  return page.addInitScript(() => {
    const { prototype } = WebGL2RenderingContext;
    const { getParameter } = prototype;
    prototype.getParameter = function (name) {
      return name === this.MAX_TEXTURE_SIZE ? 2048 : getParameter.call(this, name);
    };
  });
}

/** Pixels a side for each of CSS where nobody looks at pictures. */
const UNSHARP = 0.25;

/**
 * Until somebody looks, what comes to the screen is a triangle of each thing, and so are shadows: a processor that draws all of it takes
 * most of a test's time for pictures that nobody sees. All else is as always, also what a browser has to say of what is drawn. What is
 * painted for a file has no depth, and is drawn whole.
 */
function glance() {
  window.looking = false;
  const { prototype } = WebGL2RenderingContext;
  const { drawElements } = prototype;
  prototype.drawElements = function (mode, count, ...rest) {
    const isPainted =
      this.getParameter(this.FRAMEBUFFER_BINDING) &&
      this.getFramebufferAttachmentParameter(this.FRAMEBUFFER, this.DEPTH_ATTACHMENT, this.FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) === this.NONE;
    drawElements.call(this, mode, window.looking || isPainted ? count : Math.min(count, 3), ...rest);
  };
}

/** Pages that have so few. @type {WeakSet<import('playwright-core').Page>} */
const unsharp = new WeakSet();

/**
 * Opens the page in a fresh profile and watches what it says and asks for.
 * @param {import('playwright-core').Browser} browser
 * @param {Awaited<ReturnType<typeof serve>>} site
 * @param {import('playwright-core').BrowserContextOptions & {
 *   hash?: string, prepare?: (page: import('playwright-core').Page) => Promise<unknown>, sharp?: boolean, fine?: boolean, drawn?: boolean, kept?: boolean,
 * }} [options] `prepare` is called before the page is there. `fine` pictures have smooth edges, as people see them, and take
 *   five times as long. On `drawn` pages all is drawn each time, for who looks at it otherwise than by `picture`.
 *   `sharp` is for who looks at pictures: most of a test's time a processor draws, and others have a quarter as many pixels a side.
 *   `kept` pages are kept for use without a connection; elsewhere the browser forbids it, as some do: for each test anew that
 *   would be a tenth of what opening it takes.
 */
export async function open(browser, site, { hash = '', prepare, sharp = false, fine = false, drawn = fine, kept = false, ...options } = {}) {
  const context = await browser.newContext({
    viewport: sharp ? { width: 1000, height: 540 } : TALL,
    deviceScaleFactor: sharp ? 1 : UNSHARP,
    reducedMotion: 'reduce',
    colorScheme: 'light',
    ...options,
  });
  // Of actions that wait for the page: a busy machine takes its time.
  context.setDefaultTimeout(60_000);
  const page = await context.newPage();
  if (!sharp && options.deviceScaleFactor === undefined) unsharp.add(page);
  const complaints = complaintsOf(page);
  /** @type {string[]} */
  const requests = [];
  page.on('request', (request) => requests.push(request.url()));
  if (!kept) {
    await page.addInitScript(() => {
      const { ServiceWorkerContainer } = window;
      // Not on a blank page.
      if (ServiceWorkerContainer) ServiceWorkerContainer.prototype.register = () => Promise.reject(new Error('the test forbids it'));
    });
  }
  if (!drawn) await page.addInitScript(glance);
  await prepare?.(page);
  await page.goto(site.url + hash);
  await page.waitForFunction(
    () => document.documentElement.dataset.ready === 'true' || document.querySelector('[role=alert]'),
    null,
    { timeout: 60_000 },
  );
  if (!fine) await page.evaluate(() => window.designer?.refine(false));
  return { context, page, complaints, requests };
}

/**
 * One page for all tests of a `describe`, which leave it as the next can use it: opening one takes longer than all that is
 * done on it.
 * @param {Parameters<typeof open>} asked as of `open`
 */
export function onePage(...asked) {
  /** @type {Awaited<ReturnType<typeof open>>} */
  let opened;
  before(async () => void (opened = await open(...asked)));
  after(() => opened.context.close());
  return {
    get page() {
      return opened.page;
    },
    get context() {
      return opened.context;
    },
    get complaints() {
      return opened.complaints;
    },
  };
}

/**
 * Turns the head, as the backdrop does that is dragged, and waits until that is drawn.
 * @param {import('playwright-core').Page} page @param {number[]} from how far it is turned aside and down, degrees @param {number[]} to
 */
export async function turnHead(page, from, to) {
  const box = await page.locator('canvas').first().boundingBox();
  const by = to.map((angle, axis) => ((angle - from[axis]) * box.height) / (360 * 0.75));
  const [x, y] = [box.x + 14, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + by[0], y + by[1], { steps: 2 });
  await page.mouse.up();
  await settled(page);
}

/** Waits until the page has drawn what it had to draw. */
export function settled(page) {
  return page.evaluate(
    () =>
      new Promise((done) => {
        let quiet = 0;
        let drawn = -1;
        const look = () => {
          const now = window.designer.frames;
          quiet = now === drawn ? quiet + 1 : 0;
          drawn = now;
          if (quiet > 6 && window.designer.isFine) done(undefined);
          else requestAnimationFrame(look);
        };
        look();
      }),
  );
}

/**
 * What a look at the page gives, when all of it is drawn.
 * @template T
 * @param {import('playwright-core').Page} page @param {() => Promise<T>} look
 */
async function looked(page, look) {
  if (unsharp.has(page)) throw new Error('open a page that is looked at with `sharp`');
  await settled(page);
  await page.evaluate(() => {
    if (window.looking !== false) return;
    window.looking = true;
    // Draws what was only glanced at.
    window.designer.refine(false);
  });
  await settled(page);
  const seen = await look();
  await page.evaluate(() => {
    if (window.looking) window.looking = false;
  });
  return seen;
}

/**
 * The stage as pixels.
 * @param {import('playwright-core').Page} page
 * @param {string} name the file's name among the screenshots
 */
export function picture(page, name) {
  return looked(page, async () => {
    // What lies over the stage is not the face. (A style sheet for the screenshot would be refused
    // by the page's own policy.)
    const cover = (/** @type {string} */ visibility) =>
      page.evaluate((value) => {
        for (const over of document.querySelectorAll('.hint, .toast, .views, .invitation, .pins')) over.style.visibility = value;
      }, visibility);
    await cover('hidden');
    const png = await page.locator('canvas').screenshot({ path: join(SCREENSHOTS, `${name}.png`) });
    await cover('');
    return decodePng(png);
  });
}

/**
 * The page among the screenshots, for who looks at them.
 * @param {import('playwright-core').Page} page @param {string} name
 */
export function pictureOfPage(page, name) {
  return looked(page, () => page.screenshot({ path: join(SCREENSHOTS, `${name}.png`) }));
}

/** @typedef {{ width: number, height: number, rgb: Buffer, alpha: Buffer | null }} Picture */

/**
 * The pixels of an 8-bit PNG without interlacing, which is what Chromium writes.
 * @param {Buffer} png
 */
export function decodePng(png) {
  const width = png.readUInt32BE(16);
  const height = png.readUInt32BE(20);
  const [bits, kind] = [png[24], png[25]];
  if (bits !== 8 || (kind !== 2 && kind !== 6)) throw new Error(`a PNG of kind ${kind}, ${bits} bits`);
  const size = kind === 6 ? 4 : 3;
  const parts = [];
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
    if (png.toString('latin1', at + 4, at + 8) === 'IDAT') {
      parts.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
    }
  }
  const raw = inflateSync(Buffer.concat(parts));
  const stride = width * size;
  const lines = Buffer.alloc(stride * height);
  const rgb = Buffer.alloc(3 * width * height);
  const alpha = size === 4 ? Buffer.alloc(width * height) : null;
  for (let y = 0; y < height; y++) {
    const filter = raw[y * (stride + 1)];
    const row = lines.subarray(y * stride, (y + 1) * stride);
    row.set(raw.subarray(y * (stride + 1) + 1, (y + 1) * (stride + 1)));
    const above = y > 0 ? lines.subarray((y - 1) * stride, y * stride) : new Uint8Array(stride);
    // What is left of the first pixel, and above the first row, is 0.
    if (filter === 1) for (let i = size; i < stride; i++) row[i] += row[i - size];
    else if (filter === 2) for (let i = 0; i < stride; i++) row[i] += above[i];
    else if (filter === 3) for (let i = 0; i < stride; i++) row[i] += ((i < size ? 0 : row[i - size]) + above[i]) >> 1;
    else if (filter === 4) {
      for (let i = 0; i < stride; i++) {
        const [left, corner] = i < size ? [0, 0] : [row[i - size], above[i - size]];
        const up = above[i];
        const a = Math.abs(up - corner);
        const b = Math.abs(left - corner);
        const c = Math.abs(left + up - 2 * corner);
        row[i] += a <= b && a <= c ? left : b <= c ? up : corner;
      }
    }
    for (let x = 0, from = 0, to = 3 * y * width; x < width; x++, from += size, to += 3) {
      rgb[to] = row[from];
      rgb[to + 1] = row[from + 1];
      rgb[to + 2] = row[from + 2];
      if (alpha) alpha[y * width + x] = row[from + 3];
    }
  }
  return { width, height, rgb, alpha };
}

/**
 * How many pixels of a box (fractions of the picture) differ by more than a grey step of 6.
 * @param {{ width: number, height: number, rgb: Buffer }} a
 * @param {{ width: number, height: number, rgb: Buffer }} b
 * @param {[number, number, number, number]} box left, top, right, bottom
 */
export function differing(a, b, [left, top, right, bottom] = [0, 0, 1, 1]) {
  let count = 0;
  for (let y = Math.floor(top * a.height); y < Math.floor(bottom * a.height); y++) {
    for (let x = Math.floor(left * a.width); x < Math.floor(right * a.width); x++) {
      const o = 3 * (y * a.width + x);
      const step = Math.max(
        Math.abs(a.rgb[o] - b.rgb[o]),
        Math.abs(a.rgb[o + 1] - b.rgb[o + 1]),
        Math.abs(a.rgb[o + 2] - b.rgb[o + 2]),
      );
      if (step > 6) count++;
    }
  }
  return count;
}

/**
 * Where a landmark of the present face is on the screen, CSS pixels.
 * @param {import('playwright-core').Page} page @param {string} name
 */
export function landmarkOnScreen(page, name) {
  return page.evaluate((landmark) => window.designer.onScreen(landmark), name);
}

/**
 * The graphics card is lost, and comes back.
 * @param {import('playwright-core').Locator} canvas
 */
export function loseCard(canvas) {
  return canvas.evaluate(async (canvas) => {
    const card = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
    for (const [does, event] of [['loseContext', 'webglcontextlost'], ['restoreContext', 'webglcontextrestored']]) {
      const done = new Promise((resolve) => canvas.addEventListener(event, resolve, { once: true }));
      // It comes back only once what is lost was told.
      await new Promise((resolve) => setTimeout(resolve));
      card[does]();
      await done;
    }
  });
}

/**
 * Takes a slider to a value as a person would: focus, then the event that dragging sends.
 * @param {import('playwright-core').Page} page @param {string} name @param {number} value
 */
export async function moveSlider(page, name, value) {
  const slider = page.getByRole('slider', { name, exact: true });
  await slider.fill(String(value));
  await slider.dispatchEvent('change');
}

/** Waits until what is done next is a step of its own. @param {import('playwright-core').Page} page */
export const later = (page) => page.waitForTimeout(TOGETHER + 100);

/**
 * A slow line.
 * @param {import('playwright-core').Page} page @param {string} what it asks for and does not get yet
 * @returns {Promise<() => void>} lets it come
 */
export async function holdBack(page, what) {
  let come = () => {};
  /** @type {Promise<void>} */
  const late = new Promise((done) => (come = done));
  await page.route(what, async (route) => {
    await late;
    await route.continue();
  });
  return come;
}

/**
 * A run of presses of a key, which is one step when they follow each other soon: sent one by one they may not, where a processor
 * draws between them.
 * @param {import('playwright-core').Locator} on @param {string} key @param {number} times @param {boolean} [shiftKey]
 */
export async function pressQuickly(on, key, times, shiftKey = false) {
  await on.evaluate(
    (element, [key, times, shiftKey]) => {
      for (let i = 0; i < times; i++) {
        for (const type of ['keydown', 'keyup']) element.dispatchEvent(new KeyboardEvent(type, { key, shiftKey, bubbles: true, cancelable: true }));
      }
    },
    /** @type {const} */ ([key, times, shiftKey]),
  );
}

/**
 * A file that the dialog of exports gives.
 * @param {import('playwright-core').Page} page @param {string} button
 */
export async function download(page, button) {
  const [file] = await Promise.all([
    page.waitForEvent('download', { timeout: 180_000 }),
    page.getByRole('dialog').getByRole('button', { name: button, exact: true }).click(),
  ]);
  return { name: file.suggestedFilename(), bytes: await readFile(await file.path()) };
}

/**
 * A finger: it goes down at the first point and along the others, and up at the last.
 * @param {import('playwright-core').BrowserContext} context
 * @param {import('playwright-core').Page} page
 */
export async function fingerOn(context, page) {
  const session = await context.newCDPSession(page);
  /** @param {...[number, number]} points */
  return async (...points) => {
    const touch = (type, at) =>
      session.send('Input.dispatchTouchEvent', { type, touchPoints: at ? [{ x: at[0], y: at[1] }] : [] });
    await touch('touchStart', points[0]);
    for (let i = 1; i < points.length; i++) {
      const [from, to] = [points[i - 1], points[i]];
      for (let s = 1; s <= 6; s++) {
        await touch('touchMove', [from[0] + ((to[0] - from[0]) * s) / 6, from[1] + ((to[1] - from[1]) * s) / 6]);
      }
    }
    await touch('touchEnd');
  };
}
