// <phiz-designer> as pages and frameworks treat it: hidden, assigned to early, asked for what is none, small, and taken away.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';

import { load } from '../../pkg/index.js';
import { DIST, complaintsOf, decodePng, differing, fingerOn, siteAndBrowser } from './site.js';

const { site, browser } = await siteAndBrowser();

/** Elements by names, with what they said was wrong. */
function prepare() {
  window.all = {};
  window.errors = {};
  /** @param {string} name @param {Record<string, string>} attributes @param {Record<string, unknown>} [properties] */
  window.add = (name, attributes, properties = {}) => {
    const made = document.createElement('phiz-designer');
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    Object.assign(made, properties);
    made.style.cssText = 'width: 320px; height: 320px';
    window.all[name] = made;
    window.errors[name] = [];
    made.addEventListener('error', (event) => {
      window.errors[name].push(event.detail.message);
      event.preventDefault();
    });
    document.querySelector('main').append(made);
  };
  /** @param {string} name @param {string} type */
  window.heard = (name, type) =>
    new Promise((done) => {
      if (type === 'ready' && window.all[name].model) done(undefined);
      window.all[name].addEventListener(type, () => done(undefined), { once: true });
    });
  window.define = () => import(new URL('../designer/phiz-designer.js', document.baseURI).href);
}

/** A page of few pixels; it stays for all tests of a suite. @param {import('playwright-core').BrowserContextOptions} [options] */
async function visit(options) {
  const context = await browser.newContext({ viewport: { width: 900, height: 620 }, reducedMotion: 'reduce', deviceScaleFactor: 0.25, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  await page.addInitScript(prepare);
  await page.goto(`${site.url}examples/`);
  return page;
}

/**
 * What an element shows, as its canvas has it.
 * @param {import('playwright-core').Page} page @param {string} name
 */
async function look(page, name) {
  const canvas = page.locator('phiz-designer').and(page.locator(`[data-name=${name}]`)).locator('canvas');
  await page.evaluate((name) => (window.all[name].dataset.name = name), name);
  await canvas.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(undefined)))));
  return decodePng(await canvas.screenshot());
}

/** The same when nothing of it changes any more: what rests is refined, and when that begins depends on what else the machine does. */
async function lookAtRest(page, name) {
  for (let last = await look(page, name); ; ) {
    await page.waitForTimeout(500);
    const next = await look(page, name);
    if (differing(last, next) === 0) return next;
    last = next;
  }
}

/** @param {{ rgb: Buffer }} picture */
const shades = ({ rgb }) => new Set(rgb).size;

describe('<phiz-designer> in any page', () => {
  /** @type {import('playwright-core').Page} */
  let page;
  /** @type {string[]} */
  let complaints;
  let code = '';
  before(async () => {
    const model = await load(await readFile(join(DIST, 'model.phiz')));
    const face = model.face();
    face.randomize({ seed: 7 });
    code = face.code;
    model.free();
    page = await visit();
    complaints = complaintsOf(page);
  });
  after(() => page.context().close());

  test('what is assigned before the class or the model is there is shown when they are, also in what was hidden', async () => {
    const found = await page.evaluate(async (code) => {
      window.add('upgraded', { code: 'zzz', controls: 'none' }, { src: '../model.phiz', code, colours: { skin: 0.9 } });
      await window.define();
      window.add('hidden', { src: '../model.phiz', controls: 'none' });
      const { upgraded, hidden } = window.all;
      hidden.style.display = 'none';
      hidden.code = null;
      hidden.code = code;
      hidden.colours = 'skin: 0.9';
      const early = [upgraded.code, upgraded.colours, hidden.code, hidden.colours];
      await Promise.all([window.heard('upgraded', 'ready'), window.heard('hidden', 'ready')]);
      return { early, late: [upgraded.code, upgraded.colours, hidden.code, hidden.colours], errors: window.errors };
    }, code);
    const wanted = [code, { skin: 0.9 }, code, { skin: 0.9 }];
    assert.deepEqual(found.early, wanted);
    assert.deepEqual(found.late, wanted);
    assert.deepEqual(found.errors, { upgraded: [], hidden: [] });
    const seen = await look(page, 'upgraded');
    assert.ok(shades(seen) > 100, 'a face is there');
    await page.evaluate(() => (window.all.hidden.style.display = ''));
    assert.equal(differing(seen, await look(page, 'hidden')), 0, 'the same face at the same distance');
  });

  test('a narrow or low element keeps most of its height for the face', async () => {
    const sizes = await page.evaluate(() => {
      const { hidden } = window.all;
      hidden.removeAttribute('controls');
      const measured = [[300, 150], [480, 400], [340, 240], [700, 160]].map(([width, height]) => {
        hidden.style.cssText = `width: ${width}px; height: ${height}px`;
        const [canvas, panel] = ['canvas', '.panel'].map((part) => hidden.shadowRoot.querySelector(part));
        return { part: canvas.clientHeight / height, wide: canvas.clientWidth, panel: panel.offsetHeight, scrolls: panel.scrollHeight > panel.clientHeight };
      });
      hidden.style.cssText = 'width: 320px; height: auto';
      return [...measured, { auto: hidden.clientHeight, frame: hidden.shadowRoot.querySelector('.frame').clientHeight }];
    });
    const [tiny, low, small, flat, auto] = sizes;
    assert.deepEqual(tiny, { part: 1, wide: 300, panel: 0, scrolls: false });
    for (const { part, scrolls } of [low, small]) assert.ok(part >= 0.59 && part < 1 && scrolls, `${part}`);
    assert.ok(flat.part === 1 && flat.panel > 100 && flat.wide > 350);
    assert.deepEqual(auto, { auto: 480, frame: 480 });
  });

  test('a row and a dialog leave it a width, and it leaves others theirs', async () => {
    const widths = await page.evaluate(() => {
      const { hidden } = window.all;
      const main = document.querySelector('main');
      const within = (/** @type {HTMLElement} */ box, /** @type {string} */ css, /** @type {Node[]} */ ...beside) => {
        box.style.cssText = css;
        hidden.style.cssText = '';
        main.append(box);
        box.append(...beside, hidden);
        if (box instanceof HTMLDialogElement) box.showModal();
        const { offsetWidth } = hidden;
        const spills = box.scrollWidth > box.clientWidth;
        main.append(hidden);
        box.remove();
        return { offsetWidth, spills };
      };
      const aside = document.createElement('aside');
      aside.style.cssText = 'flex: none; width: 200px';
      return [
        within(document.createElement('div'), 'display: flex; width: 880px', aside),
        within(document.createElement('div'), 'display: flex; width: 400px', aside),
        within(document.createElement('div'), 'display: grid; width: 300px; grid-template-columns: 1fr 2fr', document.createElement('p')),
        within(document.createElement('dialog'), ''),
      ];
    });
    assert.deepEqual(widths, [640, 200, 200, 640].map((offsetWidth) => ({ offsetWidth, spills: false })));
  });

  test('a page stretches it, sizes it by a ratio, and displays it as it likes', async () => {
    const heights = await page.evaluate(() => {
      const { hidden } = window.all;
      hidden.controls = 'nose';
      const main = document.querySelector('main');
      const within = (/** @type {string} */ css, /** @type {string} */ own) => {
        const box = document.createElement('div');
        box.style.cssText = css;
        hidden.style.cssText = own;
        main.append(box);
        box.append(hidden);
        const [canvas, panel] = ['canvas', '.panel'].map((name) => hidden.shadowRoot.querySelector(name));
        const heights = [hidden.offsetHeight, canvas.offsetHeight + (hidden.offsetWidth > 560 ? 0 : panel.offsetHeight)];
        if (panel.offsetHeight < 150) throw new Error(`a panel of ${panel.offsetHeight} pixels`);
        main.append(hidden);
        box.remove();
        return heights;
      };
      const heights = [
        within('position: relative; width: 700px; height: 700px', 'position: absolute; inset: 0'),
        within('display: flex; width: 700px; height: 700px', 'flex: 1'),
        within('display: flex; flex-direction: column; width: 700px; height: 300px', 'flex: 1; min-height: 0'),
        within('', 'width: 600px; aspect-ratio: 2; min-height: 0'),
        within('display: flex; width: 700px; align-items: start', 'flex: 1'),
        within('width: 360px', ''),
        ...['block', 'flex', 'inline-block'].map((display) => within('width: 700px', `display: ${display}`)),
      ];
      hidden.style.cssText = 'width: 320px; height: 320px';
      hidden.controls = 'none';
      return heights;
    });
    assert.deepEqual(heights, [700, 700, 300, 300, 480, 480, 480, 480, 480].map((height) => [height, height]));
  });

  test('all of a head is in view and in the middle from each side, where there is little width', async () => {
    const margins = await page.evaluate(async () => {
      const { hidden } = window.all;
      hidden.style.cssText = 'width: 240px; height: 320px';
      /** @type {Record<string, [left: number, right: number]>} */
      const found = {};
      for (const view of /** @type {const} */ (['profile', 'quarter', 'front'])) {
        hidden.view(view);
        for (let i = 0; i < 4; i++) await new Promise((done) => requestAnimationFrame(() => done(undefined)));
        const bitmap = await createImageBitmap(await hidden.toPng({ width: 240, transparent: true }));
        const context = new OffscreenCanvas(240, 320).getContext('2d');
        context.drawImage(bitmap, 0, 0);
        // The head, without the neck.
        const { data } = context.getImageData(0, 0, 240, 240);
        const covered = Array.from({ length: 240 }, (_, x) => Array.from({ length: 240 }, (_, y) => data[4 * (240 * y + x) + 3]).some((alpha) => alpha > 200));
        found[view] = [covered.indexOf(true), 239 - covered.lastIndexOf(true)];
      }
      return found;
    });
    for (const [view, [left, right]] of Object.entries(margins)) {
      assert.ok(left >= 8 && right >= 8, `${view}: margins of ${left} and ${right} of 240 pixels`);
      // A nose is nearer than the back of a head from half of the side, and so larger.
      assert.ok(Math.abs(left - right) <= 12, `${view}: margins of ${left} and ${right} of 240 pixels`);
    }
  });

  test('a long beard is in view, keys come closer, and what the canvas says of itself is true', async () => {
    const found = await page.evaluate(async () => {
      const { hidden } = window.all;
      hidden.style.cssText = 'width: 320px; height: 320px';
      const canvas = hidden.shadowRoot.querySelector('canvas');
      /** How much of the lowest row but one of a picture is covered, of a picture that is as high as the canvas. */
      const below = async () => {
        const bitmap = await createImageBitmap(await hidden.toPng({ width: 160, transparent: true }));
        const context = new OffscreenCanvas(160, 160).getContext('2d');
        context.drawImage(bitmap, 0, 0);
        return context.getImageData(0, 158, 160, 1).data.filter((alpha, i) => i % 4 === 3 && alpha > 200).length;
      };
      const frames = async () => {
        for (let i = 0; i < 4; i++) await new Promise((done) => requestAnimationFrame(() => done(undefined)));
      };
      const before = hidden.colours;
      hidden.colours = { beard: 1, beardLength: 1, crop: 1 };
      await hidden.toPng({ width: 16 });
      await frames();
      const bearded = await below();
      const press = (/** @type {string} */ key) => canvas.dispatchEvent(new KeyboardEvent('keydown', { key, cancelable: true }));
      for (let i = 0; i < 4; i++) press('+');
      await frames();
      const closer = await below();
      hidden.view('front');
      hidden.colours = before;
      await frames();
      return { bearded, closer, taken: !press('-'), left: press('h'), label: canvas.getAttribute('aria-label') };
    });
    assert.equal(found.bearded, 0, 'no part of the beard reaches the edge');
    assert.ok(found.closer > 5, `${found.closer} pixels of beard at the edge once it is closer`);
    assert.ok(found.taken && found.left);
    assert.match(found.label, /plus and minus zoom/);
    assert.doesNotMatch(found.label, /\bH hides|click a feature/);
  });

  test('a picture is of the view that was asked for just now, with all of the hair that was', async () => {
    const found = await page.evaluate(async () => {
      const { hidden } = window.all;
      const frames = async () => {
        for (let i = 0; i < 4; i++) await new Promise((done) => requestAnimationFrame(() => done(undefined)));
      };
      const shot = async () => {
        const bitmap = await createImageBitmap(await hidden.toPng({ width: 120, transparent: true }));
        const context = new OffscreenCanvas(120, 120).getContext('2d');
        context.drawImage(bitmap, 0, 0);
        return context.getImageData(0, 0, 120, 120).data;
      };
      const apart = (/** @type {Uint8ClampedArray} */ a, /** @type {Uint8ClampedArray} */ b) => a.filter((value, i) => Math.abs(value - b[i]) > 6).length;
      const pictures = [await shot()];
      hidden.view('profile');
      for (const colours of [{}, { length: 1, crop: 1, beard: 1, beardLength: 1 }]) {
        hidden.colours = colours;
        const atOnce = await shot();
        await frames();
        pictures.push(atOnce, await shot());
      }
      hidden.view('front');
      hidden.colours = null;
      await frames();
      const [front, profile, later, haired, haired2] = pictures;
      return { turned: apart(front, profile), view: apart(profile, later), hair: apart(profile, haired), reach: apart(haired, haired2) };
    });
    assert.ok(found.turned > 1000 && found.hair > 1000, JSON.stringify(found));
    assert.deepEqual([found.view, found.reach], [0, 0], 'the same as some frames later');
  });

  test('a file is of the face at the call, by what it needs; none is written of what is gone', async () => {
    /** @type {string[]} */
    const requests = [];
    const hear = (/** @type {import('playwright-core').Request} */ request) => void requests.push(request.url());
    page.on('request', hear);
    const found = await page.evaluate(async () => {
      const { hidden } = window.all;
      const { code } = hidden;
      const same = (/** @type {Uint8Array} */ a, /** @type {Uint8Array} */ b) => a.length === b.length && a.every((byte, i) => byte === b[i]);
      const before = hidden.toMesh('stl');
      hidden.randomize({ seed: 3 });
      const after = hidden.toMesh('stl');
      hidden.code = code;
      const files = await Promise.all([before, after, hidden.toMesh('stl')]);
      return { kept: same(files[0], files[2]), other: same(files[0], files[1]) };
    });
    page.off('request', hear);
    assert.deepEqual(found, { kept: true, other: false });
    assert.ok(requests.some((url) => /\/export-/.test(url)), 'what writes files comes');
    assert.deepEqual(requests.filter((url) => /\/appearance-/.test(url)), [], 'STL has no colours');

    const gone = await page.evaluate(async () => {
      const { hidden } = window.all;
      const { toBlob } = HTMLCanvasElement.prototype;
      const canvas = hidden.shadowRoot.querySelector('canvas');
      const card = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
      const come = (/** @type {string} */ type) => new Promise((done) => canvas.addEventListener(type, () => setTimeout(done), { once: true }));
      const said = (/** @type {Promise<unknown>} */ file) => file.then(() => '', (error) => error.message);
      const loseCard = async () => {
        const lost = come('webglcontextlost');
        card.loseContext();
        await lost;
        const back = come('webglcontextrestored');
        card.restoreContext();
        await back;
      };
      // One that is back is a small one, or the skin takes its time.
      const { getParameter } = WebGL2RenderingContext.prototype;
      WebGL2RenderingContext.prototype.getParameter = function (name) {
        return name === this.MAX_TEXTURE_SIZE ? 2048 : getParameter.call(this, name);
      };
      await loseCard();
      const whole = await hidden.toMesh('glb', { targets: false });
      // It goes and is back while the first picture is written, and the second would be black.
      HTMLCanvasElement.prototype.toBlob = function (done, ...rest) {
        HTMLCanvasElement.prototype.toBlob = toBlob;
        void loseCard().then(() => toBlob.call(this, done, ...rest));
      };
      const again = await hidden.toMesh('glb', { targets: false });
      const same = whole.length === again.length && whole.every((byte, i) => byte === again[i]);
      WebGL2RenderingContext.prototype.getParameter = getParameter;
      const file = said(hidden.toMesh('obj'));
      hidden.remove();
      const removed = await file;
      document.querySelector('main').append(hidden);
      await window.heard('hidden', 'ready');
      window.errors.hidden.length = 0;
      return { same, removed };
    });
    assert.ok(gone.same, 'the pictures are made again');
    assert.match(gone.removed, /^the element was taken away/);
  });

  test('what a page does to all of its texts leaves its panel as it is', async () => {
    const found = await page.evaluate(() => {
      const { hidden } = window.all;
      hidden.style.cssText = 'width: 700px; height: 320px';
      hidden.controls = 'nose';
      const places = () =>
        Array.from(hidden.shadowRoot.querySelectorAll('canvas, .panel *'), (part) => {
          const [at, from] = [part.getBoundingClientRect(), hidden.getBoundingClientRect()];
          return [at.left - from.left, at.top - from.top, at.width, at.height, getComputedStyle(part).textTransform].join(' ');
        });
      const before = places();
      const box = document.createElement('div');
      box.dir = 'rtl';
      box.style.cssText = 'text-align: center; white-space: nowrap; letter-spacing: 5px; word-spacing: 30px; text-transform: uppercase; text-indent: 40px';
      document.querySelector('main').append(box);
      box.append(hidden);
      const after = places();
      document.querySelector('main').append(hidden);
      box.remove();
      hidden.controls = 'none';
      hidden.style.cssText = 'width: 320px; height: 320px';
      return { before, after };
    });
    assert.ok(found.before.length > 20);
    assert.deepEqual(found.after, found.before);
  });

  test('one that is put back shows who was there', async () => {
    const found = await page.evaluate(async () => {
      const { hidden } = window.all;
      hidden.style.cssText = 'width: 320px; height: 320px';
      hidden.set('nose 1', 0.97);
      hidden.colours = { iris: 0 };
      const bytes = await (await fetch('../expressions.phiz')).arrayBuffer();
      await hidden.model.loadExpressions(bytes.slice(0));
      hidden.face.expression = { jawOpen: 0.5 };
      hidden.refresh();
      const state = () => [hidden.code, hidden.colours];
      const before = state();
      hidden.remove();
      await new Promise((done) => setTimeout(done, 100));
      const away = state();
      document.querySelector('main').append(hidden);
      await window.heard('hidden', 'ready');
      const back = state();
      await hidden.model.loadExpressions(bytes);
      hidden.refresh();
      return { before, away, back, expression: hidden.face.expression, errors: window.errors.hidden };
    });
    assert.deepEqual(found.away, found.before);
    assert.deepEqual(found.back, found.before);
    assert.ok(Math.abs(found.expression.jawOpen - 0.5) < 1e-3);
    assert.deepEqual(found.errors, []);
  });

  test('what is none is refused with a sentence that says what there is', async () => {
    const found = await page.evaluate(async () => {
      const { hidden } = window.all;
      const refused = async (/** @type {() => unknown} */ call) => {
        try {
          return await call();
        } catch (error) {
          return error.message;
        }
      };
      const picture = await hidden.toPng();
      return {
        format: await refused(() => hidden.toMesh('toString')),
        view: await refused(() => hidden.view('nope')),
        size: await refused(() => hidden.toPng({ width: 8 })),
        ...(() => {
          const before = [hidden.code, hidden.colours];
          window.errors.hidden.length = 0;
          // Whoever renders what somebody typed goes on.
          hidden.colours = 3;
          hidden.code = 'zzz';
          return { before, after: [hidden.code, hidden.colours], errors: [...window.errors.hidden] };
        })(),
        picture: [(await createImageBitmap(picture)).width, picture.type],
      };
    });
    assert.match(found.format, /no format "toString": take glb/);
    assert.match(found.view, /no view "nope": take front, quarter, profile/);
    assert.match(found.size, /16 to \d+ pixels a side/);
    assert.deepEqual(found.after, found.before);
    assert.equal(found.errors.length, 2);
    assert.match(found.errors.join('\n'), /colours are an object[^]*code/);
    assert.deepEqual(found.picture, [1024, 'image/png']);
  });

  test('wrong attributes leave a face, and right ones bring theirs', async () => {
    const found = await page.evaluate(async (code) => {
      const { upgraded } = window.all;
      upgraded.remove();
      window.add('wrong', { src: '../model.phiz', code: 'zzz', colours: 'skn: 0.8', controls: 'nose, nostril' });
      const { wrong } = window.all;
      await window.heard('wrong', 'ready');
      const before = { errors: [...window.errors.wrong], colours: wrong.colours, sliders: wrong.shadowRoot.querySelectorAll('input').length };
      wrong.setAttribute('code', code);
      wrong.setAttribute('colours', 'skin: 0.8');
      wrong.setAttribute('controls', 'nose 1');
      return { before, code: wrong.code, colours: wrong.colours, sliders: wrong.shadowRoot.querySelectorAll('input').length, errors: window.errors.wrong.length };
    }, code);
    assert.equal(found.before.errors.length, 3);
    assert.match(found.before.errors.join('\n'), /code[^]*no colour "skn"[^]*no feature "nostril"/);
    assert.deepEqual(found.before.colours, {});
    assert.equal(found.before.sliders, 18, 'three of each of six features');
    assert.deepEqual([found.code, found.colours, found.sliders, found.errors], [code, { skin: 0.8 }, 1, 3]);
    assert.ok(shades(await look(page, 'wrong')) > 100);
    // Sliders that were there are not those without the attribute.
    const again = await page.evaluate(() => {
      const { wrong } = window.all;
      wrong.setAttribute('controls', 'nostril');
      const sliders = wrong.shadowRoot.querySelectorAll('input').length;
      wrong.setAttribute('controls', 'nose 1');
      return { sliders, error: window.errors.wrong.at(-1) };
    });
    assert.equal(again.sliders, 18);
    assert.match(again.error, /no feature "nostril"/);
  });

  test('what it has already is no change, however it is assigned', async () => {
    const found = await page.evaluate((code) => {
      const { wrong } = window.all;
      let changes = 0;
      const count = () => (changes += 1);
      wrong.addEventListener('change', count);
      /** @param {() => void} assign */
      const after = (assign) => {
        changes = 0;
        assign();
        return changes;
      };
      const found = {
        same: after(() => {
          wrong.code = wrong.code;
          wrong.setAttribute('code', wrong.code);
          wrong.colours = { ...wrong.colours };
          wrong.setAttribute('colours', 'skin: 0.8');
        }),
        median: after(() => (wrong.code = '')),
        again: after(() => (wrong.code = null)),
        plain: after(() => (wrong.colours = null)),
        still: after(() => (wrong.colours = '')),
        back: after(() => Object.assign(wrong, { code, colours: 'skin: 0.8' })),
      };
      wrong.removeEventListener('change', count);
      return found;
    }, code);
    assert.deepEqual(found, { same: 0, median: 1, again: 0, plain: 1, still: 0, back: 2 });
  });

  test('a key moves a slider by what it shows', async () => {
    const slider = page.locator('phiz-designer').and(page.locator('[data-name=wrong]')).locator('input[type=range]');
    await page.evaluate(() => {
      window.heardOf = [];
      for (const type of ['input', 'change']) window.all.wrong.addEventListener(type, () => window.heardOf.push(type));
      window.all.wrong.set('nose 1', 0.5);
      window.heardOf.length = 0;
    });
    await slider.focus();
    const told = [];
    for (const key of ['ArrowRight', 'Shift+ArrowUp', 'PageDown', 'ArrowLeft', 'Home', 'End']) {
      await page.keyboard.press(key);
      told.push(await slider.getAttribute('aria-valuetext'));
    }
    assert.deepEqual(told, ['51st', '61st', '51st', '50th', '0th', '100th']);
    assert.deepEqual(await page.evaluate(() => window.heardOf), Array(6).fill(['input', 'change']).flat());
    const at = await page.evaluate(() => [window.all.wrong.get('nose 1'), window.all.wrong.model.controls.find(({ name }) => name === 'nose 1').limits[1]]);
    assert.ok(Math.abs(at[0] - at[1]) < 1e-3, at.join());
  });

  test('what no page hears of is said on the console, and a card that was lost in its place; a second copy stands back', async () => {
    const known = complaints.length;
    const found = await page.evaluate(async () => {
      const { wrong } = window.all;
      const unheard = document.createElement('phiz-designer');
      unheard.colours = 'skin: 0.5';
      document.querySelector('main').append(unheard);
      unheard.setAttribute('src', 'nowhere.phiz');
      await new Promise((done) => unheard.addEventListener('error', done, { once: true }));
      unheard.remove();
      const second = await import(new URL('../designer/phiz-designer.js?copy', document.baseURI).href).then(() => '', String);

      const canvas = wrong.shadowRoot.querySelector('canvas');
      const card = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
      const alert = () => wrong.shadowRoot.querySelector('[role=alert]')?.textContent ?? null;
      /** @param {string} type */
      const come = (type) => new Promise((done) => canvas.addEventListener(type, () => setTimeout(done), { once: true }));
      const lost = come('webglcontextlost');
      card.loseContext();
      await lost;
      const said = [alert(), window.errors.wrong.at(-1)];
      const back = come('webglcontextrestored');
      card.restoreContext();
      await back;
      return { second, said, after: alert() };
    });
    const noCard = 'the graphics card is not available at the moment';
    assert.deepEqual(found, { second: '', said: [noCard, noCard], after: null });
    const own = complaints.splice(known).filter((line) => line.includes('<phiz-designer>'));
    assert.equal(own.length, 2, own.join('\n'));
    assert.match(own[0], /^<phiz-designer>: .*nowhere\.phiz: 404/);
    assert.match(own[1], /is there already: .*\?copy is not used$/);
  });

  test('the page scrolls over it until it is taken up', async () => {
    await page.evaluate(() => {
      document.querySelector('main').style.paddingBottom = '3000px';
      window.all.wrong.scrollIntoView();
      document.activeElement?.blur();
    });
    const canvas = page.locator('phiz-designer').and(page.locator('[data-name=wrong]')).locator('canvas');
    const top = () => page.evaluate(() => window.scrollY);
    const wheel = async (/** @type {number} */ by) => {
      const box = await canvas.boundingBox();
      assert.ok(box);
      await page.mouse.move(box.x + box.width / 2, box.y + 60);
      await page.mouse.wheel(0, by);
    };
    const before = await look(page, 'wrong');
    const start = await top();
    await wheel(30);
    await page.waitForFunction((start) => window.scrollY >= start + 30, start);
    await page.evaluate((start) => window.scrollTo(0, start), start);
    assert.equal(differing(before, await look(page, 'wrong')), 0, 'it is as near as before');
    await page.keyboard.down('Control');
    await wheel(-200);
    await page.keyboard.up('Control');
    const nearer = await look(page, 'wrong');
    assert.ok(differing(before, nearer) > 100, 'with Ctrl it comes nearer');
    await canvas.click();
    await wheel(200);
    assert.ok(differing(nearer, await look(page, 'wrong')) > 100, 'and once it was clicked');
    assert.equal(await top(), start);
    await page.evaluate(() => {
      document.querySelector('main').style.paddingBottom = '';
      window.all.wrong.view('front');
    });
  });

  test('attributes are properties, a slider is there once, colours are a copy, and an option is known by its name', async () => {
    const found = await page.evaluate(async () => {
      window.add('proper', {}, { src: '../model.phiz', controls: 'nose 2, nose,', theme: 'dark', head: undefined });
      const { proper } = window.all;
      await window.heard('proper', 'ready');
      const nose = proper.model.controls.filter(({ group }) => group === 'nose').map(({ name }) => name);
      const sliders = [...proper.shadowRoot.querySelectorAll('input')];
      proper.set('nose 2', 0.9);
      const at = sliders.map(({ value }) => Number(value));
      const told = [proper.src, proper.head, proper.controls, proper.theme, getComputedStyle(proper).colorScheme, proper.getAttributeNames().join()];
      proper.controls = null;
      const many = proper.shadowRoot.querySelectorAll('input').length;
      proper.controls = '';
      const none = proper.shadowRoot.querySelectorAll('input').length;

      proper.colours = { skin: 0.8 };
      const { colours } = proper;
      colours.skin = 0.2;
      let changes = 0;
      const count = () => (changes += 1);
      proper.addEventListener('change', count);
      proper.colours = colours;
      const skin = proper.colours.skin;
      const refused = async (/** @type {Promise<unknown>} */ call) => call.then(() => '', ({ message }) => message);
      return {
        nose,
        at,
        told,
        many,
        none,
        changes,
        skin,
        refused: [
          await refused(proper.toPng({ size: 300 })),
          await refused(proper.toMesh('glb', { target: false })),
          await refused(proper.toPng(300)),
          await refused(proper.toPng({ width: '300' })),
        ],
        plain: (await proper.toMesh('stl', null)).length > 84 && (await proper.toPng(null)).type,
        errors: window.errors.proper,
      };
    });
    assert.deepEqual(found.told, ['../model.phiz', '', 'nose 2, nose,', 'dark', 'dark', found.told.at(-1)]);
    // Pages have attributes of their own, by which their styles go.
    assert.deepEqual(found.told.at(-1).split(',').sort(), ['controls', 'src', 'style', 'theme'], 'of which the style is the page\'s');
    assert.equal(found.at.length, found.nose.length, 'each slider once');
    assert.deepEqual(found.at.map((value) => value > 0.89), [true, ...found.nose.slice(1).map(() => false)], 'the one that is there follows');
    assert.deepEqual([found.many, found.none], [18, 0]);
    assert.deepEqual([found.changes, found.skin], [1, 0.2]);
    assert.deepEqual(found.refused.slice(0, 3), ['toPng knows no option "size"', 'toMesh knows no option "target"', 'what toPng is given must be an object, not 300']);
    assert.match(found.refused[3], /pixels a side here, not "300"$/);
    assert.equal(found.plain, 'image/png');
    assert.deepEqual(found.errors, []);
  });

  test('a picture is of the face and the view at the call, whatever has to come first', async () => {
    await page.route('**/glasses-*.js', async (route) => {
      await new Promise((done) => setTimeout(done, 700));
      await route.continue();
    });
    const found = await page.evaluate(async () => {
      const { proper } = window.all;
      const pixels = async (/** @type {Promise<Blob>} */ picture) => {
        const bitmap = await createImageBitmap(await picture);
        const context = new OffscreenCanvas(120, 120).getContext('2d');
        context.drawImage(bitmap, 0, 0);
        return context.getImageData(0, 0, 120, 120).data;
      };
      const apart = (/** @type {Uint8ClampedArray} */ a, /** @type {Uint8ClampedArray} */ b) => a.filter((value, i) => Math.abs(value - b[i]) > 6).length;
      const { code } = proper;
      proper.colours = { glasses: 1 };
      proper.view('front');
      const asked = proper.toPng({ width: 120 });
      proper.randomize({ seed: 5 });
      proper.colours = { glasses: 1, skin: 0.9 };
      proper.view('profile');
      const [other, colours] = [proper.code, proper.colours];
      const picture = await pixels(asked);
      const kept = [proper.code === other, proper.colours.skin === colours.skin];
      const later = await pixels(proper.toPng({ width: 120 }));
      proper.code = code;
      proper.colours = { glasses: 1 };
      proper.view('front');
      const again = await pixels(proper.toPng({ width: 120 }));
      proper.colours = null;
      return { kept, same: apart(picture, again), other: apart(picture, later) };
    });
    await page.unroute('**/glasses-*.js');
    assert.deepEqual(found.kept, [true, true], 'what shows goes on');
    assert.ok(found.other > 2000, JSON.stringify(found));
    assert.equal(found.same, 0, JSON.stringify(found));
  });

  test('another model has what the page assigned, unless that was changed since; without an address there is none', async () => {
    const found = await page.evaluate(async () => {
      const { proper } = window.all;
      const errors = window.errors.proper;
      const own = proper.model.face().code;
      const to = async (/** @type {string} */ src) => {
        proper.src = src;
        await window.heard('proper', 'ready');
        return [proper.code === own, proper.colours.skin];
      };
      const one = proper.model.face();
      one.randomize({ seed: 8 });
      const { code } = one;
      proper.code = code;
      proper.colours = { skin: 0.7 };
      await to('../model.phiz?2');
      const kept = [proper.code === code, proper.colours.skin];
      proper.randomize({ seed: 9 });
      proper.colours = { skin: 0.4 };
      const changed = await to('../model.phiz?3');
      proper.code = code;
      proper.set('nose 1', 0.9);
      const other = await to('../model.phiz?4');
      const requests = performance.getEntriesByType('resource').length;
      proper.src = '';
      await new Promise((done) => setTimeout(done, 200));
      const none = [proper.model, proper.shadowRoot.querySelector('canvas'), performance.getEntriesByType('resource').length - requests];
      return { kept, changed, other, none, errors: errors.splice(0), back: await to('../model.phiz') };
    });
    assert.deepEqual(found.kept, [true, 0.7]);
    assert.deepEqual(found.changed, [true, 0.4]);
    assert.deepEqual(found.other, [true, 0.4]);
    assert.deepEqual(found.none, [null, null, 0]);
    assert.deepEqual(found.errors, []);
  });

  test('a page that freed its face has its card back, and a face when it is put back', async () => {
    const found = await page.evaluate(async () => {
      const { proper } = window.all;
      /** @type {string[]} */
      const thrown = [];
      const hear = (/** @type {ErrorEvent} */ event) => thrown.push(event.message);
      window.addEventListener('error', hear);
      const context = proper.shadowRoot.querySelector('canvas').getContext('webgl2');
      proper.face.free();
      const main = proper.parentNode;
      proper.remove();
      await new Promise((done) => setTimeout(done, 100));
      const lost = context.isContextLost();
      main.append(proper);
      await window.heard('proper', 'ready');
      proper.model.free();
      proper.remove();
      await new Promise((done) => setTimeout(done, 100));
      main.append(proper);
      await window.heard('proper', 'ready');
      window.removeEventListener('error', hear);
      return { thrown, lost, code: proper.code.length };
    });
    assert.deepEqual(found.thrown, []);
    assert.ok(found.lost && found.code > 0);
  });

  test('in another document it looks as it did, and goes on', async () => {
    const found = await page.evaluate(async () => {
      const { proper } = window.all;
      const { model } = proper;
      const frame = document.createElement('iframe');
      document.querySelector('main').append(frame);
      const displays = () => getComputedStyle(proper.shadowRoot.querySelector('canvas')).display;
      const before = displays();
      frame.contentDocument.body.append(proper);
      await new Promise((done) => setTimeout(done));
      const there = [displays(), proper.model === model];
      document.querySelector('main').append(proper);
      await new Promise((done) => setTimeout(done));
      const back = [displays(), proper.model === model];
      proper.remove();
      frame.remove();
      return { before, there, back };
    });
    assert.deepEqual(found, { before: 'block', there: ['block', true], back: ['block', true] });
  });

  test('what others that come and go share with it does not stay on its card', async () => {
    const counts = await page.evaluate(async () => {
      const { wrong } = window.all;
      const own = wrong.shadowRoot.querySelector('canvas').getContext('webgl2');
      const { prototype } = WebGL2RenderingContext;
      const { createTexture, deleteTexture } = prototype;
      let textures = 0;
      prototype.createTexture = function () {
        if (this === own) textures += 1;
        return createTexture.call(this);
      };
      prototype.deleteTexture = function (texture) {
        if (this === own) textures -= 1;
        return deleteTexture.call(this, texture);
      };
      const counts = [];
      for (let i = 0; i < 4; i++) {
        window.add('passing', { src: '../model.phiz', controls: 'none' });
        await window.heard('passing', 'ready');
        window.all.passing.remove();
        delete window.all.passing;
        await new Promise((done) => setTimeout(done));
        wrong.refresh();
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        counts.push(textures);
      }
      Object.assign(prototype, { createTexture, deleteTexture });
      return counts;
    });
    assert.deepEqual(counts, counts.map(() => counts[0]), 'each may replace what was there');
  });

  test('those that are gone are forgotten', async () => {
    const session = await page.context().newCDPSession(page);
    await page.evaluate(() => {
      window.gone = ['wrong', 'upgraded'].map((name) => {
        const element = window.all[name];
        element.remove();
        delete window.all[name];
        return new WeakRef(element);
      });
    });
    let left = 2;
    for (let tries = 0; left > 0 && tries < 10; tries++) {
      await page.waitForTimeout(200);
      await session.send('HeapProfiler.collectGarbage');
      left = await page.evaluate(() => window.gone.filter((ref) => ref.deref()).length);
    }
    assert.equal(left, 0);
  });

  test('a head that does not come is done without, and stays when the model does not', async () => {
    const found = await page.evaluate(async () => {
      window.all.hidden.remove();
      window.add('headless', { src: '../model.phiz', head: 'nowhere.phiz', controls: 'none' });
      window.add('alone', { src: 'nowhere.phiz', head: '../head.phiz' });
      const failed = window.heard('alone', 'error');
      await window.heard('headless', 'ready');
      await failed;
      const { alone } = window.all;
      return { errors: window.errors, alert: alone.shadowRoot.querySelector('[role=alert]').textContent };
    });
    assert.equal(found.errors.headless.length, 1);
    assert.match(found.errors.headless[0], /the head is left out: .*nowhere\.phiz: 404/);
    assert.equal(found.errors.alone.length, 1);
    assert.match(found.errors.alone[0], /nowhere\.phiz: 404/);
    assert.equal(found.alert, found.errors.alone[0]);
    for (const name of ['headless', 'alone']) assert.ok(shades(await look(page, name)) > 100, `${name} shows a face`);
    // With the right model the rest comes.
    await page.evaluate(async () => {
      const ready = window.heard('alone', 'ready');
      window.all.alone.setAttribute('src', '../model.phiz');
      await ready;
    });
    assert.equal(await page.evaluate(() => window.all.alone.shadowRoot.querySelector('[role=alert]')), null);
    // What is no address at all is no more than that.
    const astray = await page.evaluate(async () => {
      window.all.headless.remove();
      window.add('astray', { src: 'http://[', head: 'http://[', controls: 'none' });
      const { astray } = window.all;
      while (!astray.shadowRoot.querySelector('[role=alert]')) await new Promise((done) => setTimeout(done, 20));
      const errors = [...window.errors.astray];
      astray.setAttribute('src', '../model.phiz');
      await window.heard('astray', 'ready');
      astray.remove();
      return { errors, later: window.errors.astray.slice(2) };
    });
    assert.equal(astray.errors.length, 2);
    assert.match(astray.errors[0], /^the head is left out: .*http:\/\/\[/);
    assert.match(astray.errors[1], /http:\/\/\[/);
    // The head is none still.
    assert.equal(astray.later.length, 1);
    assert.deepEqual(complaints.filter((line) => !/Context Lost|404/i.test(line)), []);
  });

  test('what did not come is named, and comes when it is asked for again', async () => {
    const other = await visit();
    await other.route('**/onhead-*.js', (route) => route.abort());
    await other.route('**/lost.phiz', (route) => route.abort());
    const found = await other.evaluate(async () => {
      await window.define();
      window.add('late', { src: '../lost.phiz', controls: 'none' });
      await window.heard('late', 'error');
      window.all.late.src = '../model.phiz';
      await window.heard('late', 'error');
      return window.errors.late;
    });
    assert.equal(found.length, 2);
    assert.match(found[0], /lost\.phiz did not come: ./);
    assert.equal(found[1], 'this needs a connection once');
    await other.unroute('**/onhead-*.js');
    await other.evaluate(() => {
      const ready = window.heard('late', 'ready');
      window.all.late.src = '../model.phiz';
      return ready;
    });
    await other.context().close();
  });

  test('where nothing can be drawn is said once, also of one that has a head', async () => {
    const found = await page.evaluate(async () => {
      const { prototype } = HTMLCanvasElement;
      const { getContext } = prototype;
      prototype.getContext = function (kind, ...rest) {
        return kind === 'webgl2' ? null : getContext.call(this, kind, ...rest);
      };
      window.add('undrawn', { src: '../model.phiz', head: '../head.phiz' });
      const { undrawn } = window.all;
      const alert = () => undrawn.shadowRoot.querySelector('[role=alert]')?.textContent;
      while (!alert()) await new Promise((done) => setTimeout(done, 20));
      Object.assign(prototype, { getContext });
      const said = [window.errors.undrawn, alert()];
      // It is another attempt.
      const ready = window.heard('undrawn', 'ready');
      undrawn.src = '../model.phiz';
      await ready;
      undrawn.remove();
      return { said, later: window.errors.undrawn.slice(said[0].length) };
    });
    assert.match(found.said[1], /^Your browser does not offer WebGL 2/);
    assert.deepEqual(found, { said: [[found.said[1]], found.said[1]], later: [] });
  });

  test('an answer that was none is asked for again; who is ready has a model; what is locked is heeded and said', async () => {
    let isWrong = true;
    await page.route('**/late.phiz', (route) => (isWrong ? route.fulfill({ contentType: 'text/html', body: '<!doctype html><title>Soon</title>' }) : route.fulfill({ path: join(DIST, 'model.phiz') })));
    const wrong = await page.evaluate(async () => {
      for (const name of ['headless', 'alone']) window.all[name]?.remove();
      await window.define();
      window.add('late', { src: '../late.phiz', controls: 'eyes size' });
      await window.heard('late', 'error');
      return window.errors.late;
    });
    assert.equal(wrong.length, 1);
    assert.match(wrong[0], /a page: is its address right/);
    isWrong = false;
    await page.evaluate(async () => {
      const { late } = window.all;
      const ready = window.heard('late', 'ready');
      late.src = late.getAttribute('src');
      await ready;
      const { model } = late;
      late.src = late.getAttribute('src');
      if (late.model !== model) throw new Error('what is there begins anew');
    });
    const found = await page.evaluate(async () => {
      const { late } = window.all;
      let [ready, without, again] = [0, 0, false];
      late.addEventListener('ready', () => {
        ready += 1;
        if (!late.model) without += 1;
      });
      // Whoever hears of the face may begin anew.
      const whole = new Promise((done) => late.addEventListener('ready', () => late.model && done(undefined)));
      late.addEventListener('face', () => {
        if (again) return;
        again = true;
        late.setAttribute('src', '../model.phiz');
      });
      late.remove();
      // In one task it would be moved.
      await new Promise((next) => setTimeout(next));
      document.querySelector('main').append(late);
      await whole;

      late.face.lock('nose');
      late.randomize({ seed: 3 });
      late.code = '';
      const median = late.model.face();
      const isMedian = late.code === median.code;
      median.free();

      late.face.lock('eyes');
      for (const name of ['nose lateral position', 'face height', 'eyes length']) late.face.lockMeasure(name);
      const slider = late.shadowRoot.querySelector('input[type=range]');
      const { code } = late;
      const events = [];
      late.addEventListener('input', () => events.push('input'));
      slider.value = slider.min;
      slider.dispatchEvent(new Event('input', { bubbles: true }));
      return { again, ready, without, isMedian, errors: window.errors.late.slice(1), events, same: late.code === code, off: Math.abs(slider.valueAsNumber - late.face.get('eyes size')) };
    });
    assert.deepEqual([found.again, found.ready, found.without, found.isMedian, found.events, found.same], [true, 1, 0, true, [], true]);
    assert.equal(found.errors.length, 1);
    assert.match(found.errors[0], /cannot have a/);
    assert.ok(found.off < 0.001, `the slider is ${found.off} from the face`);
    assert.deepEqual(complaints.filter((line) => !/Context Lost|404/i.test(line)), []);
  });
});

describe('<phiz-designer> under a finger', () => {
  test('scrolls its page up and down, and turns sideways; a page may keep fingers for it', async () => {
    const page = await visit({ hasTouch: true });
    const context = page.context();
    await page.evaluate(async () => {
      await window.define();
      window.add('touched', { src: '../model.phiz', controls: 'none' });
      document.querySelector('main').style.paddingBottom = '3000px';
      await window.heard('touched', 'ready');
      window.all.touched.scrollIntoView();
    });
    const finger = await fingerOn(context, page);
    // All of it has come.
    await page.evaluate(() => window.all.touched.toPng({ width: 16 }));
    const before = await lookAtRest(page, 'touched');
    const middle = async () => {
      const box = await page.locator('phiz-designer canvas').boundingBox();
      assert.ok(box);
      return /** @type {const} */ ([box.x + box.width / 2, box.y + box.height / 2]);
    };
    const start = await page.evaluate(() => window.scrollY);
    let [x, y] = await middle();
    await finger([x, y], [x, y - 90]);
    await page.waitForFunction((start) => window.scrollY > start + 40, start);
    await page.evaluate((start) => window.scrollTo(0, start), start);
    const again = await lookAtRest(page, 'touched');
    assert.equal(differing(before, again), 0, 'it was not turned');
    await finger([x, y], [x + 80, y]);
    const turned = await look(page, 'touched');
    assert.ok(differing(before, turned) > 200, 'it was turned');
    assert.equal(await page.evaluate(() => window.scrollY), start);
    // As the README has it.
    await page.evaluate(() => {
      const sheet = new CSSStyleSheet();
      sheet.replaceSync('phiz-designer::part(canvas) { touch-action: none }');
      document.adoptedStyleSheets = [sheet];
    });
    await finger([x, y], [x, y - 90]);
    assert.ok(differing(turned, await look(page, 'touched')) > 200, 'it was tilted');
    assert.equal(await page.evaluate(() => window.scrollY), start);
    await context.close();
  });
});
