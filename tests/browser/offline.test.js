// The page without a network, as a new version, installed, and under a strict policy.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { cp, mkdtemp, readdir, readFile, rename, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { createContext, runInContext } from 'node:vm';

import { DIST, decodePng, differing, launch, moveSlider, open, picture, serve } from './site.js';

const WORKER = new URL('../../www/worker/service-worker.js', import.meta.url);
const PRECACHE = fileURLToPath(new URL('../../www/precache.js', import.meta.url));

/** @type {import('playwright-core').Browser} */
let browser;
before(async () => {
  browser = await launch();
});
after(async () => {
  await browser?.close();
});

/** Until the worker has everything and the page is its own. @param {import('playwright-core').Page} page */
const kept = (page) =>
  page.waitForFunction(() => navigator.serviceWorker.controller?.state === 'activated', null, { timeout: 60_000 });

/**
 * A site as the next build would have it: a part has another digest in its name, and whatever asks for it asks for that.
 * @param {string} folder @param {string} part
 */
async function renamePart(folder, part) {
  const assets = join(folder, 'assets');
  const all = await readdir(assets);
  // Of several the one that the designer asks for.
  const designer = await readFile(join(assets, all.find((name) => /^designer-.*\.js$/.test(name)) ?? ''), 'utf8');
  const old = all.find((name) => name.startsWith(`${part}-`) && name.endsWith('.js') && designer.includes(name)) ?? '';
  assert.ok(old, `${part} is a part of its own`);
  const next = `${part}-nextnext.js`;
  await rename(join(assets, old), join(assets, next));
  for (const name of await readdir(assets)) {
    if (!name.endsWith('.js')) continue;
    const source = await readFile(join(assets, name), 'utf8');
    if (source.includes(old)) await writeFile(join(assets, name), source.replaceAll(old, next));
  }
  return { old, next };
}

const ready = (/** @type {import('playwright-core').Page} */ page) =>
  page.waitForFunction(() => document.documentElement.dataset.ready === 'true', null, { timeout: 60_000 });

describe('offline', () => {
  test('after one visit the page works with the server gone, under a sub-path', async () => {
    const site = await serve({ base: '/people/ada/faces/' });
    const { context, page, complaints } = await open(browser, site, { kept: true, sharp: true, fine: true });
    await kept(page);
    await moveSlider(page, 'nose 1', 0.9);
    const before = await picture(page, 'offline-before');
    const url = page.url();
    await site.close();

    const again = await context.newPage();
    again.on('pageerror', (error) => complaints.push(error.message));
    await again.goto(url);
    await ready(again);
    assert.equal(differing(before, await picture(again, 'offline-after')), 0, 'the same face');
    // What is loaded only when it is needed is there as well.
    await again.getByRole('button', { name: 'Take the face with you' }).click();
    const [file] = await Promise.all([
      again.waitForEvent('download'),
      again.getByRole('dialog').getByRole('button', { name: 'PLY', exact: true }).click(),
    ]);
    assert.ok((await readFile(await file.path())).toString('latin1').startsWith('ply\n'));
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('what photos take is not loaded before a photo, and is kept after one', async () => {
    const site = await serve();
    const { context, page } = await open(browser, site, { kept: true });
    await kept(page);
    const has = async (/** @type {number} */ more) => {
      const urls = [];
      for (const name of await caches.keys()) for (const { url } of await (await caches.open(name)).keys()) urls.push(url);
      return urls.filter((url) => /face_mesh|astronaut|photo_bg/.test(url)).length > more;
    };
    assert.equal(await page.evaluate(has, 0), false);
    const fitted = async (/** @type {import('playwright-core').Page} */ on) => {
      await on.getByRole('tab', { name: 'Photo' }).click();
      await on.getByRole('button', { name: 'An example' }).click();
      await on.getByText('The face is fitted.').waitFor({ timeout: 60_000 });
      return on.evaluate(() => window.designer.face.code);
    };
    const code = await fitted(page);
    // They are stored beside what is done with them.
    await page.waitForFunction(has, 5);
    await site.close();
    const again = await context.newPage();
    await again.goto(site.url);
    await ready(again);
    assert.equal(await fitted(again), code);
    await context.close();
  });

  test('a new version waits, is offered, and replaces the old one', async () => {
    const folder = await mkdtemp(join(tmpdir(), 'phiz-site-'));
    const site = await serve({ root: () => folder });
    try {
      await cp(DIST, folder, { recursive: true });
      const { context, page, complaints } = await open(browser, site, { kept: true });
      await kept(page);
      const names = () =>
        page.evaluate(async () => {
          const urls = [];
          for (const name of await caches.keys()) {
            for (const { url } of await (await caches.open(name)).keys()) urls.push(url.split('?')[0]);
          }
          return urls.sort();
        });
      const first = await names();
      await moveSlider(page, 'nose 1', 0.2);
      const url = page.url();
      const beside = await context.newPage();
      await beside.goto(site.url);
      await ready(beside);
      await moveSlider(beside, 'nose 2', 0.8);
      const code = await beside.evaluate(() => {
        window.designer.stays = true;
        return window.designer.face.code;
      });

      // The page changes and a file of it goes.
      const html = await readFile(join(folder, 'index.html'), 'utf8');
      await writeFile(join(folder, 'index.html'), html.replace(/<title>[^<]*/, '<title>phiz, the next'));
      await rm(join(folder, 'icon-512.png'));
      const [sheet] = [await renamePart(folder, 'sheet'), await renamePart(folder, 'room')];
      execFileSync(process.execPath, [PRECACHE, folder]);
      await page.reload();
      await ready(page);
      assert.equal(await page.title(), 'phiz: face designer', 'the old version is whole until it is given up');
      await page.getByText('A new version of phiz is available.').waitFor({ timeout: 60_000 });
      await Promise.all([page.waitForEvent('load'), page.getByRole('button', { name: 'Update' }).click()]);
      await ready(page);
      assert.equal(await page.title(), 'phiz, the next');
      assert.equal(page.url(), url, 'with the same face');
      // Whoever works in another tab goes on there, and takes it when it suits.
      const update = beside.getByRole('button', { name: 'Update' });
      await update.waitFor();
      assert.equal(await beside.evaluate(() => window.designer.stays), true, 'the other tab was loaded again');
      assert.ok(await beside.getByRole('button', { name: 'Undo', exact: true }).isEnabled());
      // What comes late comes still, though the site has it no longer; what was never kept says why it does not.
      await beside.getByRole('tab', { name: 'Faces' }).click();
      await beside.getByRole('button', { name: 'Save', exact: true }).click();
      await Promise.all([beside.waitForEvent('download'), beside.getByRole('button', { name: 'Picture of all' }).click()]);
      await beside.getByRole('tab', { name: 'Photo' }).click();
      await beside.getByText('there is a newer version of this page; reload it to go on').waitFor();
      await Promise.all([beside.waitForEvent('load'), update.click()]);
      await ready(beside);
      assert.equal(await beside.title(), 'phiz, the next');
      assert.equal(await beside.evaluate(() => window.designer.face.code), code);
      await beside.close();
      await page.waitForFunction(async () => {
        for (const name of await caches.keys()) {
          if (name.startsWith('phiz earlier')) return false;
          for (const { url } of await (await caches.open(name)).keys()) if (url.includes('icon-512')) return false;
        }
        return true;
      });
      const wanted = first.filter((name) => !name.endsWith('icon-512.png')).map((name) => name.replace(sheet.old, sheet.next));
      assert.deepEqual(await names(), wanted.sort());
      assert.deepEqual(complaints, []);
      await context.close();
    } finally {
      await site.close();
      await rm(folder, { recursive: true });
    }
  });

  test('where storage is full, and before anything is stored, an answer is as good', async () => {
    const photo = 'a photo';
    const digest = createHash('sha256').update(photo).digest('hex');
    const scope = 'https://faces.example/phiz/';
    /** @type {Record<string, (event: any) => void>} */
    const on = {};
    let stored = 0;
    const worker = {
      registration: { scope },
      addEventListener: (/** @type {string} */ name, /** @type {(event: any) => void} */ listener) => (on[name] = listener),
      caches: {
        open: async () => ({
          match: async () => undefined,
          put: async () => {
            stored += 1;
            throw new DOMException('', 'QuotaExceededError');
          },
        }),
        match: async () => undefined,
      },
      fetch: async () => new Response(photo),
      crypto: globalThis.crypto,
      URL,
    };
    const source = (await readFile(WORKER, 'utf8')).replace('/* later */ {}', JSON.stringify({ 'astronaut.jpg': digest }));
    runInContext(source, createContext({ ...worker, self: worker }));
    for (const name of ['astronaut.jpg', 'synthetic.phiz']) {
      /** @type {Promise<any>[]} */
      const works = [];
      /** @type {Promise<Response> | undefined} */
      let answer;
      on.fetch({
        request: { url: scope + name, method: 'GET' },
        respondWith: (/** @type {Promise<Response>} */ response) => (answer = response),
        waitUntil: (/** @type {Promise<any>} */ work) => works.push(work),
      });
      assert.equal(await (await answer)?.text(), photo, name);
      assert.equal(works.length, 1);
      await Promise.all(works);
    }
    assert.equal(stored, 2);
  });

  test('a site that is half replaced is not kept', async () => {
    const folder = await mkdtemp(join(tmpdir(), 'phiz-site-'));
    const site = await serve({ root: () => folder });
    try {
      await cp(DIST, folder, { recursive: true });
      // Another icon than the worker knows of.
      await cp(join(folder, 'icon-192.png'), join(folder, 'icon-512.png'));
      const { context, page } = await open(browser, site, { kept: true });
      const state = await page.evaluate(async () => {
        const registration = await navigator.serviceWorker.register('service-worker.js').catch((error) => error.message);
        if (typeof registration === 'string') return registration;
        const worker = registration.installing ?? registration.waiting ?? registration.active;
        if (!worker) return 'none';
        while (worker.state === 'installing') await new Promise((done) => worker.addEventListener('statechange', done, { once: true }));
        return worker.state;
      });
      assert.ok(['redundant', 'none'].includes(state), state);
      await context.close();
    } finally {
      await site.close();
      await rm(folder, { recursive: true });
    }
  });
});

describe('installable', () => {
  test('the manifest is sound, and so are its icons', async () => {
    const site = await serve();
    const { context, page } = await open(browser, site, { kept: true });
    await kept(page);
    const session = await context.newCDPSession(page);
    const { errors, data } = await session.send('Page.getAppManifest');
    assert.deepEqual(errors, []);
    const manifest = JSON.parse(data ?? '');
    for (const { src, sizes, type } of manifest.icons) {
      const answer = await page.request.get(new URL(src, site.url).href);
      assert.ok(answer.ok(), src);
      if (type !== 'image/png') continue;
      const { width, height } = decodePng(await answer.body());
      assert.equal(`${width}x${height}`, sizes);
    }
    // A test's profile is thrown away after it; nothing else may be in the way.
    const { installabilityErrors } = await session.send('Page.getInstallabilityErrors');
    assert.deepEqual(installabilityErrors.map((error) => error.errorId).filter((id) => id !== 'in-incognito'), []);
    await context.close();
    await site.close();
  });
});

describe('a strict content security policy', () => {
  const policy = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; img-src 'self' data:; object-src 'none'; base-uri 'none'; frame-ancestors 'none'";
  for (const [name, path, done] of /** @type {const} */ ([
    ['the page', '', () => document.documentElement.dataset.ready === 'true'],
    ['the element in a plain page', 'examples/plain/', () => document.querySelector('phiz-designer')?.model],
    ['the three.js scene', 'examples/three/', () => document.documentElement.dataset.ready === 'true'],
    ['the crowd', 'examples/crowd/', () => document.documentElement.dataset.ready === 'true'],
  ])) {
    test(`${name} keeps it`, async () => {
      const site = await serve({ headers: { 'content-security-policy': policy }, base: '/a/b/' });
      const context = await browser.newContext({ viewport: { width: 900, height: 600 }, reducedMotion: 'reduce' });
      const page = await context.newPage();
      await page.addInitScript(() => {
        window.violations = [];
        document.addEventListener('securitypolicyviolation', (event) => window.violations.push(`${event.violatedDirective}: ${event.blockedURI} ${event.sourceFile}`));
      });
      /** @type {string[]} */
      const complaints = [];
      page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
      page.on('pageerror', (error) => complaints.push(error.message));
      await page.goto(site.url + path);
      await page.waitForFunction(done, null, { timeout: 60_000 });
      if (path === '') {
        await page.getByRole('button', { name: 'Take the face with you' }).click();
        const dialog = page.getByRole('dialog');
        // One of the size that is offered takes half a minute to draw where there is no graphics card.
        for (const side of ['Width', 'Height']) await dialog.getByRole('spinbutton', { name: side }).fill('400');
        for (const format of ['STL', 'PNG']) {
          const [file] = await Promise.all([
            page.waitForEvent('download'),
            dialog.getByRole('button', { name: format, exact: true }).click(),
          ]);
          assert.ok((await readFile(await file.path())).length > 10_000);
        }
        await page.keyboard.press('Escape');
        // Presets have portraits.
        await page.getByRole('tab', { name: 'Mix' }).click();
        await page.waitForFunction(() => [...document.querySelectorAll('img.portrait')].some((image) => image.naturalWidth > 0));
        // Workers take the policy of their answers, which here is the page's.
        await page.getByRole('tab', { name: 'Photo' }).click();
        await page.getByRole('button', { name: 'An example' }).click();
        await page.getByText('The face is fitted.').waitFor({ timeout: 60_000 });
        await kept(page);
      }
      assert.deepEqual(await page.evaluate(() => window.violations), []);
      assert.deepEqual(complaints, []);
      await context.close();
      await site.close();
    });
  }
});
