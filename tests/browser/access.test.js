import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { describe, test } from 'node:test';
import { moveSlider, open, siteAndBrowser } from './site.js';

const require = createRequire(new URL('../../www/package.json', import.meta.url));
const AXE = readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');

const { browser, site } = await siteAndBrowser();

const ALL = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'];
/** What light and dark differ in: all else of the page is the same in both. */
const COLOURS = ['color-contrast', 'link-in-text-block'];

/** What axe calls serious or critical, in one line each. */
const faults = (page, rules = ALL) =>
  page.evaluate(async (runOnly) => {
    const { violations } = await window.axe.run(document, { resultTypes: ['violations'], runOnly });
    return violations
      .filter(({ impact }) => impact === 'serious' || impact === 'critical')
      .map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.slice(0, 4).map(({ html, any }) => `${html.slice(0, 120)} ${any[0]?.message ?? ''}`).join(' | ')}`);
  }, rules);
const overflow = (page) => page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
const sections = (page) => page.getByRole('tab').allTextContents();

/** Looks at every section with axe, and at what opens over the page. */
async function inspect(page, what, rules = ALL) {
  /** @type {string[]} */
  const found = [];
  const look = async (/** @type {string} */ where) => {
    for (const fault of await faults(page, rules)) found.push(`${what}, ${where}: ${fault}`);
    if ((await overflow(page)) > 0) found.push(`${what}, ${where}: too wide by ${await overflow(page)} px`);
  };
  for (const name of await sections(page)) {
    await page.getByRole('tab', { name, exact: true }).click();
    if (name === 'Mix') {
      for (const face of ['Preset 1', 'Preset 2']) {
        await page.locator('.tray').getByRole('button', { name: face, exact: true }).click();
        await page.getByRole('button', { name: 'Add to the circle' }).click();
      }
    }
    if (name === 'Compare') {
      await page.getByLabel('Split by a line').check();
      await page.getByLabel('Distance as colour').check();
    }
    if (name === 'Lengths') await page.waitForFunction(() => !document.querySelector('.awaited'));
    await look(name);
    if (name === 'Looks') {
      await page.getByRole('button', { name: 'Pilot', exact: true }).click();
      await page.getByRole('slider', { name: 'Tint, clear to dark' }).waitFor();
      await look('glasses');
      await page.getByRole('group', { name: 'Put on' }).getByRole('button', { name: 'Scar' }).click();
      await look('a scar that is to be put');
      const box = await page.locator('canvas.view').boundingBox();
      for (const t of [0.4, 0.5]) await page.mouse.click(box.x + t * box.width, box.y + 0.5 * box.height);
      await page.getByRole('slider', { name: 'Width of the scar' }).waitFor();
      await look('a scar');
    }
    if (name === 'Features') {
      await page.getByRole('button', { name: 'Person', exact: true }).click();
      await look('the person');
      await page.getByRole('button', { name: 'Nose', exact: true }).click();
    }
    if (name === 'Compare') {
      await page.getByLabel('Split by a line').uncheck();
      await page.getByLabel('Distance as colour').uncheck();
    }
  }
  await page.getByRole('button', { name: 'What is happening?' }).click();
  await look('explanation');
  await page.keyboard.press('Escape');
  await page.getByRole('button', { name: 'What is this?' }).click();
  await look('about');
  await page.keyboard.press('Escape');
  return found;
}

describe('for everybody', () => {
  for (const [name, options] of /** @type {const} */ ([
    ['desktop', { viewport: { width: 1280, height: 800 }, colorScheme: 'light' }],
    ['phone', { viewport: { width: 320, height: 640 }, hasTouch: true, isMobile: true, colorScheme: 'dark' }],
  ])) {
    test(`axe finds nothing serious on a ${name}, light and dark, and nothing is too wide`, async () => {
      const { context, page, complaints } = await open(browser, site, { ...options, reducedMotion: 'reduce' });
      await page.evaluate(AXE);
      assert.ok((await sections(page)).length >= 4);
      const found = await inspect(page, `${name}-${options.colorScheme}`);
      await page.getByRole('button', { name: 'Light or dark' }).click();
      found.push(...(await inspect(page, `${name}-other`, COLOURS)));
      assert.deepEqual(found, []);
      assert.deepEqual(complaints, []);
      await context.close();
    });
  }

  test('the tour goes round by keyboard and is offered once; the explanation follows what is done', async () => {
    const { context, page, complaints } = await open(browser, site);
    await page.evaluate(AXE);
    // Whoever looked at the whole person is shown a feature's sliders.
    await page.getByRole('button', { name: 'Person', exact: true }).click();
    await page.getByRole('button', { name: 'Show me around' }).focus();
    await page.keyboard.press('Enter');
    const card = page.getByRole('dialog');
    const titles = [];
    for (;;) {
      const title = await card.getByRole('heading').textContent();
      titles.push(title);
      // What it tells of is ringed.
      const of = { 'Sliders that know people': '.control:has(#control-nose-1)', 'Random, reset, lock': '#feature-title', Mix: '.tray' }[title ?? ''];
      if (of) {
        const [ring, thing] = [await page.locator('.tour-ring').boundingBox(), await page.locator(of).boundingBox()];
        assert.ok(ring && thing && ring.x <= thing.x && ring.y <= thing.y && ring.x + ring.width >= thing.x + thing.width, `${title}: ${JSON.stringify([ring, thing])}`);
      }
      const box = await card.boundingBox();
      const view = page.viewportSize();
      assert.ok(box && view && box.x >= 0 && box.y >= 0 && box.x + box.width <= view.width && box.y + box.height <= view.height);
      if (titles.length === 1) assert.deepEqual(await faults(page), []);
      const last = (await card.getByRole('button', { name: 'Done' }).count()) > 0;
      await page.keyboard.press('Enter');
      if (last) break;
      assert.ok(titles.length < 12, 'the tour never ends');
    }
    assert.equal(new Set(titles).size, 8);
    assert.ok(titles.includes('Expressions') && titles.includes('Photo'));
    assert.ok(await card.isHidden());
    assert.equal(await page.getByRole('button', { name: 'Show me around' }).isVisible(), false);
    await page.reload();
    await page.waitForFunction(() => document.documentElement.dataset.ready === 'true');
    assert.equal(await page.getByRole('button', { name: 'Show me around' }).isVisible(), false);

    await page.getByRole('button', { name: 'What is happening?' }).click();
    const aside = page.getByRole('complementary', { name: 'What is happening?' });
    assert.match((await aside.textContent()) ?? '', /eigenmesh[\s\S]*95%/);
    await moveSlider(page, 'nose 1', 0.9);
    assert.match((await aside.textContent()) ?? '', /moved nose 1 to the 90th percentile: about 9 of 10/);
    await page.getByRole('tab', { name: 'Compare' }).click();
    assert.match((await aside.textContent()) ?? '', /It is no norm/);
    await aside.getByRole('button').click();
    assert.ok(await aside.isHidden());

    // The way through the page by Tab: everything that can be reached shows where it is.
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.evaluate(() => document.querySelector('.bar button')?.focus());
    const seen = new Set();
    for (let i = 0; i < 40; i++) {
      await page.keyboard.press('Tab');
      const at = await page.evaluate(() => {
        const here = document.activeElement;
        if (!here || here === document.body) return null;
        const mark = here.matches('.track input') ? here.parentElement.querySelector('.thumb') : here;
        const { outlineStyle, outlineWidth } = getComputedStyle(mark);
        return { name: here.id || here.getAttribute('aria-label') || here.textContent, shows: outlineStyle !== 'none' && parseFloat(outlineWidth) >= 2 };
      });
      if (!at) break;
      assert.ok(at.shows, `nothing shows that ${at.name} has the focus`);
      seen.add(at.name);
    }
    for (const name of ['control-nose-1', 'Lock the nose']) assert.ok(seen.has(name), `Tab never reaches ${name}`);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('on a phone rows that go on fade, the tour speaks of taps, and words keep off what they speak of', async () => {
    const viewport = { width: 360, height: 740 };
    const { context, page, complaints } = await open(browser, site, { viewport, hasTouch: true, isMobile: true });
    const boxOf = (/** @type {string} */ selector) => page.locator(selector).evaluate((it) => it.getBoundingClientRect().toJSON());
    const apart = (a, b) => a.bottom <= b.top + 1 || b.bottom <= a.top + 1;
    const edges = () => page.locator('.modes').evaluate((row) => [row.classList.contains('goes-before'), row.classList.contains('goes-on')]);
    assert.deepEqual(await edges(), [false, true]);
    // No panel goes sideways, into nothing.
    for (const name of ['Looks', 'Mix', 'Features']) {
      await page.getByRole('tab', { name, exact: true }).click();
      assert.deepEqual(await page.locator('.scroll').filter({ visible: true }).evaluateAll((all) => all.map((it) => it.scrollWidth - it.clientWidth)), [0], name);
    }
    const cut = await page.locator('.measures dt').evaluateAll((names) => names.filter((it) => it.scrollWidth > it.clientWidth).map((it) => it.textContent));
    assert.deepEqual(cut, []);

    await page.getByRole('button', { name: 'Show me around' }).click();
    const card = page.getByRole('dialog');
    const said = [];
    for (let i = 0; i < 8; i++) {
      said.push(await card.textContent());
      if (i === 0) for (const over of ['.view', '.modes', '.tabs']) assert.ok(apart(await boxOf('.tour-card'), await boxOf(over)), `the first card lies over ${over}`);
      await card.getByRole('button', { name: /Next|Done/ }).click();
    }
    assert.doesNotMatch(said.join(), /click/i);
    assert.match(said.join(), /Tap a feature[^]*Double-tap/);

    await page.getByRole('tab', { name: 'Photo' }).click();
    await page.waitForFunction(() => document.querySelector('.modes')?.matches('.goes-before:not(.goes-on)'));
    await page.getByRole('button', { name: 'What is happening?' }).click();
    assert.ok(apart(await boxOf('.explanation'), await boxOf('.views')), 'the explanation lies over the stage');
    await page.keyboard.press('Escape');
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    assert.ok(apart(await boxOf('.toast'), await boxOf('.view')), 'what is said lies over the face');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('the explanation leaves the face free, and the tabs', async () => {
    const { context, page, complaints } = await open(browser, site, { viewport: { width: 1366, height: 768 } });
    const boxOf = (/** @type {string} */ selector) => page.locator(selector).evaluate((it) => it.getBoundingClientRect().toJSON());
    await page.getByRole('button', { name: 'What is happening?' }).click();
    for (const [width, height] of [[1366, 768], [1280, 720], [1000, 640], [911, 512], [844, 390], [390, 844]]) {
      await page.setViewportSize({ width, height });
      await page.evaluate(() => new Promise((laid) => requestAnimationFrame(() => requestAnimationFrame(laid))));
      const [said, ...others] = [await boxOf('.explanation'), await boxOf('.view'), ...(width > 820 ? [await boxOf('.modes')] : [])];
      for (const it of others) {
        const apart = said.right <= it.left + 1 || it.right <= said.left + 1 || said.bottom <= it.top + 1 || it.bottom <= said.top + 1;
        assert.ok(apart, `${width} x ${height}: it lies over what is at ${it.left}, ${it.top}`);
      }
      assert.ok(others[0].width > 300 && said.width > 280 && said.height > 200, `${width} x ${height}`);
      assert.ok((await overflow(page)) <= 0);
      assert.equal(await page.locator('.invitation').isVisible(), false);
    }
    await page.keyboard.press('Escape');
    assert.ok(await page.locator('.invitation').isVisible());
    assert.equal(await page.locator('.hint').isVisible(), false, 'one sentence at a time');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('at four times its size the page scrolls, and face and sliders have room', async () => {
    const { context, page, complaints } = await open(browser, site, { viewport: { width: 320, height: 256 } });
    const found = await page.evaluate(() => {
      const height = (/** @type {string} */ selector) => document.querySelector(selector)?.getBoundingClientRect().height ?? 0;
      return { stage: height('.stage'), scroll: height('.panel .scroll') };
    });
    assert.ok(found.stage >= 200 && found.scroll >= 120, `a stage of ${found.stage} and sliders on ${found.scroll} px`);
    assert.ok((await overflow(page)) <= 0);
    await page.mouse.move(160, 20);
    await page.mouse.wheel(0, 2000);
    await page.waitForFunction(() => {
      const panel = document.querySelector('.panel')?.getBoundingClientRect();
      return panel && Math.abs(panel.bottom - window.innerHeight) < 1;
    });
    // All of it can be reached by keyboard, and is in view then.
    await page.getByRole('button', { name: 'Undo', exact: true }).evaluate((button) => window.scrollTo(0, 0));
    await page.getByRole('slider', { name: 'nose 1', exact: true }).focus();
    const box = await page.getByRole('slider', { name: 'nose 1', exact: true }).boundingBox();
    assert.ok(box && box.y >= 0 && box.y + box.height <= 256, `the slider is at ${box?.y}`);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('what is typed into is as large as phones want it', async () => {
    const { context, page } = await open(browser, site, { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true });
    for (const name of await sections(page)) await page.getByRole('tab', { name, exact: true }).click();
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    const small = await page.evaluate(() =>
      [...document.querySelectorAll('input:not([type=range], [type=checkbox], [type=radio], [type=file]), select')]
        .map((field) => ({ name: field.id || field.className || field.outerHTML, size: parseFloat(getComputedStyle(field).fontSize) }))
        .filter(({ size }) => size < 16),
    );
    assert.deepEqual(small, []);
    await context.close();
  });

  test('fits a screen of 3840 by 2160', async () => {
    // Half a device pixel a CSS pixel: the layout is the same, the software renderer has a quarter.
    const viewport = { width: 3840, height: 2160 };
    const { context, page } = await open(browser, site, { viewport, deviceScaleFactor: 0.5, reducedMotion: 'reduce' });
    assert.ok((await overflow(page)) <= 0);
    const [stage, panel] = [await page.locator('.stage').boundingBox(), await page.locator('.panel').boundingBox()];
    assert.ok(stage && panel && stage.width > 0.8 * viewport.width && panel.x + panel.width <= viewport.width);
    assert.equal(await page.evaluate(() => getComputedStyle(document.documentElement).fontSize), '20px');
    await context.close();
  });
});
