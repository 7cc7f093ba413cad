// Small things that a panel owes to who uses it.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { decodePng, moveSlider, onePage, open, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

describe('the panels of one page', () => {
  const visit = onePage(browser, site);

  test('without a connection a part that never came says that it needs one, once', async () => {
    const { page } = visit;
    // Also where it is asked for once more.
    const parts = /\/(room|export|gif)-[^/]*\.(js|css)(\?|$)/;
    await page.route(parts, (route) => route.abort());
    await page.getByRole('tab', { name: 'Photo' }).click();
    const said = page.locator('.photo-panel [role=status]');
    await page.waitForFunction(() => /could not/.test(document.querySelector('.photo-panel [role=status]')?.textContent ?? ''));
    assert.equal(await said.textContent(), 'The photo tools could not be loaded: this needs a connection once.');
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    await page.getByRole('button', { name: 'STL' }).click();
    await page.getByText('The file could not be written: this needs a connection once.').waitFor();
    await page.getByRole('button', { name: 'Close', exact: true }).last().click();
    // What is dropped meanwhile waits for it.
    await page.evaluate(() => {
      const files = new DataTransfer();
      files.items.add(new File(['no picture'], 'me.jpg', { type: 'image/jpeg' }));
      window.dispatchEvent(new DragEvent('drop', { dataTransfer: files, bubbles: true, cancelable: true }));
    });
    await page.waitForFunction(() => /could not/.test(document.querySelector('.photo-panel [role=status]')?.textContent ?? ''));
    // It may come later.
    await page.unroute(parts);
    await page.getByRole('button', { name: 'Try again' }).click();
    await page.getByRole('button', { name: 'Choose a photo' }).waitFor();
    await page.getByText('This is not a picture that your browser can show.').waitFor();
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'STL' }).click()]);
    assert.equal(file.suggestedFilename(), 'face.stl');
    await page.getByRole('button', { name: 'Close', exact: true }).last().click();
  });

  test('what is dropped and is neither a face nor a photo is told what is', async () => {
    const { page } = visit;
    await page.evaluate(() => {
      const files = new DataTransfer();
      files.items.add(new File(['dear diary'], 'notes.txt', { type: 'text/plain' }));
      window.dispatchEvent(new DragEvent('drop', { dataTransfer: files, bubbles: true, cancelable: true }));
    });
    await page.getByText('notes.txt is not a face from this page. Faces saved here (.json) and photos can be opened.').waitFor();
  });

  test('the key that hides hair is the stage’s alone, and its button says so', async () => {
    const { page } = visit;
    await page.getByRole('tab', { name: 'Looks' }).click();
    await page.getByRole('button', { name: 'Bob', exact: true }).click();
    const hide = page.getByRole('button', { name: 'Hide hair and glasses' });
    assert.match((await hide.getAttribute('title')) ?? '', /On the face, the key is H\./);
    await page.keyboard.press('h');
    assert.equal(await hide.getAttribute('aria-pressed'), 'false', 'a key on another control');
    // Who has clicked the button goes on with the key.
    await hide.click();
    assert.equal(await hide.getAttribute('aria-pressed'), 'true');
    await page.keyboard.press('h');
    assert.equal(await hide.getAttribute('aria-pressed'), 'false');
    await page.locator('.view').focus();
    await page.keyboard.press('h');
    assert.equal(await hide.getAttribute('aria-pressed'), 'true');
  });
});

test('a slider is found among many by the words below it', async () => {
  const { context, page, complaints } = await open(browser, site);
  const field = page.getByRole('textbox', { name: 'Find' });
  await page.getByRole('button', { name: 'Head', exact: true }).click();
  const abouts = () => page.locator('#section-features .sliders[role=group] .about').allTextContents();
  const first = await abouts();
  const known = await page.evaluate(() => window.designer.model.controls.filter(({ group, measure }) => group === 'head' && !measure).map(({ description }) => description));
  await field.fill('ears');
  const ears = known.filter((description) => /\bears?\b/.test(description)).length;
  assert.ok(ears > first.filter((words) => /\bears?\b/.test(words)).length, 'all of them are sought, not only the first');
  assert.equal((await abouts()).filter((words) => /\bears?\b/.test(words)).length, ears);
  assert.equal((await abouts()).length, ears);
  assert.equal(await page.getByRole('status').filter({ hasText: 'sliders' }).textContent(), `${ears} of ${known.length} sliders`);
  await field.fill('neck, left ear');
  assert.ok((await abouts()).every((words) => /neck|left.*ear|ear.*left/.test(words)) && (await abouts()).length > 1);
  await field.fill('xylophone');
  assert.equal((await abouts()).length, 0);
  await page.getByText(`None of the ${known.length} sliders has these words.`).waitFor();
  await field.fill('');
  assert.deepEqual(await abouts(), first);
  // Another feature begins with all of its own; one that has few is seen at a glance.
  await field.fill('ear');
  await page.getByRole('button', { name: 'Eyes', exact: true }).click();
  assert.equal(await field.inputValue(), '');
  await page.getByRole('button', { name: 'Forehead', exact: true }).click();
  assert.equal(await field.isVisible(), false);
  assert.deepEqual(complaints, []);
  await context.close();
});

test('faces like one are drawn beside each other, taken, saved, and put on one sheet', async () => {
  const { context, page, complaints } = await open(browser, site);
  const code = () => page.evaluate(() => window.designer.face.code);
  await page.getByRole('button', { name: 'Random face', exact: true }).click();
  await page.getByRole('button', { name: 'Lock the nose', exact: true }).click();
  const own = await code();
  const looks = await page.evaluate(() => window.designer.colouring);
  await page.getByRole('button', { name: 'Like this face' }).click();
  // They come below the button, which is where the panel ends.
  await page.waitForFunction(() => {
    const [line, seen] = ['[role=group]:has(> .alike)', '#section-features > .scroll'].map((of) => document.querySelector(of)?.getBoundingClientRect());
    return line && seen && line.height > 0 && line.bottom <= seen.bottom + 1;
  });
  const six = page.getByRole('group', { name: 'Faces like it' }).getByRole('button', { name: /^Take face/ });
  assert.equal(await six.count(), 6);
  assert.equal(await code(), own, 'none of them is taken yet');
  const codes = await six.evaluateAll((buttons) => buttons.map((button) => button.dataset.face));
  assert.equal(new Set([own, ...codes]).size, 7);
  /** Root mean squares in mm: of the skin, and of what belongs to the nose. */
  const apart = (/** @type {string} */ other) =>
    page.evaluate(
      ([own, other]) => {
        const { model } = window.designer;
        const [a, b] = [own, other].map((code) => model.fromCode(code));
        const p = a.positions.slice();
        const q = b.positions.slice();
        const nose = model.regions.indexOf('nose');
        const [all, some] = [[], []];
        for (let i = 0; i < p.length; i++) {
          all.push((p[i] - q[i]) ** 2);
          if (model.regionGroups[model.regionOf[Math.floor(i / 3)]] === nose) some.push((p[i] - q[i]) ** 2);
        }
        const reads = ['sex', 'age'].map((name) => Math.abs(a.attribute(name) - b.attribute(name)));
        a.free();
        b.free();
        return { skin: Math.sqrt((3 * all.reduce((x, y) => x + y)) / all.length), nose: Math.sqrt(Math.max(...some)), reads };
      },
      [own, other],
    );
  for (const other of codes) {
    const { skin, nose, reads } = await apart(other);
    assert.ok(skin > 0.4 && skin < 6, `${skin} mm`);
    assert.ok(nose < 0.001, `the nose is locked, and ${nose} mm off`);
    // A reading that is beyond its labels may go.
    assert.ok(reads[0] < 0.35 && reads[1] < 40, reads.join());
  }
  await six.nth(3).click();
  assert.equal(await code(), codes[3]);
  assert.equal(await six.nth(3).getAttribute('aria-pressed'), 'true');
  assert.deepEqual(await page.evaluate(() => window.designer.colouring), looks);
  await page.getByRole('button', { name: 'Undo', exact: true }).click();
  assert.equal(await code(), own);
  assert.equal(await six.nth(3).getAttribute('aria-pressed'), 'false');

  await page.getByRole('button', { name: 'Save all 6' }).click();
  await page.getByRole('tab', { name: 'Faces' }).click();
  assert.deepEqual(await page.locator('.saved .open').allTextContents(), [1, 2, 3, 4, 5, 6].map((n) => `Line-up, ${n}`));
  const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Picture of all' }).click()]);
  assert.equal(file.suggestedFilename(), 'faces.png');
  const { width, height } = decodePng(await readFile(await file.path()));
  assert.ok(width > 3 * 288 && height > 2 * 352, `${width} x ${height}`);
  await page.getByText('Saved faces.png, 6 faces.').waitFor();
  // A second line-up has names of its own.
  await page.getByRole('tab', { name: 'Features' }).click();
  await page.getByRole('button', { name: 'Like this face' }).click();
  await page.getByRole('button', { name: 'Save all 6' }).click();
  await page.getByRole('tab', { name: 'Faces' }).click();
  assert.deepEqual(await page.locator('.saved .open').allTextContents(), [7, 8, 9, 10, 11, 12, 1, 2, 3, 4, 5, 6].map((n) => `Line-up, ${n}`));
  assert.equal(await code(), own, 'the face on the stage stays');
  assert.deepEqual(complaints, []);
  await context.close();
});

test('on paper there is the picture, with the lengths under it and nothing to press', async () => {
  const { context, page, complaints } = await open(browser, site);
  const before = await page.evaluate(() => window.designer.face.measure('nose length'));
  await moveSlider(page, 'nose 1', 0.9);
  await page.getByRole('tab', { name: 'Compare' }).click();
  await page.getByLabel('Split by a line you drag').check();
  assert.equal(await page.locator('.printed').isVisible(), false);
  await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
  await page.emulateMedia({ media: 'print' });
  assert.deepEqual(await page.locator('button, input, [role=tab], .hint, .toast, .panel, .bar').filter({ visible: true }).count(), 0);
  assert.ok(await page.locator('canvas.view').isVisible());
  const { measures, nose } = await page.evaluate(() => ({ measures: window.designer.model.measures.length, nose: window.designer.face.measure('nose length') }));
  assert.equal(await page.locator('.printed dt').filter({ visible: true }).count(), measures);
  // Two faces are in the picture, and so they are in what stands under it.
  const apart = nose - before;
  assert.ok(apart > 0.1, `${apart}`);
  assert.match((await page.locator('.printed').textContent()) ?? '', new RegExp(`^This face vs The start.*nose length\\+${apart.toFixed(1)}${nose.toFixed(1)} mm.*nose lateral position0\\.0`));
  // The line between two faces is where it is on the screen.
  const [stage, line] = [await page.locator('.stage').boundingBox(), await page.locator('.divider').boundingBox()];
  assert.ok(stage && line && Math.abs(line.x + line.width / 2 - stage.x - stage.width / 2) < 1.5);
  const shape = await page.locator('.stage').evaluate((it) => it.clientWidth / it.clientHeight);
  await page.emulateMedia({ media: 'screen' });
  await page.getByLabel('Split by a line you drag').uncheck();
  await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
  assert.match((await page.locator('.printed').textContent()) ?? '', new RegExp(`^This face\\w.*nose length${nose.toFixed(1)} mm`));
  assert.ok(Math.abs(shape - (await page.locator('.stage').evaluate((it) => it.clientWidth / it.clientHeight))) < 0.02);
  assert.deepEqual(complaints, []);
  await context.close();
});

test('where the person has chosen all colours, tracks and what is pressed are there', async () => {
  const { context, page, complaints } = await open(browser, site, { forcedColors: 'active' });
  await moveSlider(page, 'nose 1', 0.9);
  const colours = (/** @type {string} */ selector) =>
    page.locator(selector).first().evaluate((it) => {
      const { backgroundColor, backgroundImage, borderBottomColor } = getComputedStyle(it);
      return { backgroundColor, backgroundImage, borderBottomColor };
    });
  const panel = (await colours('.panel')).backgroundColor;
  const [line, fill] = [await colours('#section-features .line'), await colours('#section-features .fill')];
  assert.equal(new Set([panel, line.backgroundColor, fill.backgroundColor]).size, 3, 'the panel, a track, what of it is filled');
  for (const selector of ['.tab', '.mode']) {
    const [chosen, other] = [await colours(`${selector}:is([aria-pressed=true], [aria-selected=true])`), await colours(`${selector}:not([aria-pressed=true], [aria-selected=true])`)];
    assert.notEqual(chosen.backgroundColor, other.backgroundColor, selector);
  }
  assert.equal((await colours('.mode[aria-selected=false]')).borderBottomColor, panel, 'no line under what is not chosen');
  await page.getByRole('tab', { name: 'Looks' }).click();
  assert.match((await colours('.colours .line')).backgroundImage, /gradient/);
  await page.getByRole('tab', { name: 'Compare' }).click();
  await page.getByLabel('Distance as colour').check();
  const scale = page.locator('.colour-bar .scale');
  assert.equal(await scale.evaluate((it) => getComputedStyle(it).forcedColorAdjust), 'none', 'the scale of distances keeps its colours');
  assert.deepEqual(complaints, []);
  await context.close();
});

test('who asks for more contrast has it, by day and by night', async () => {
  const { context, page } = await open(browser, site, { contrast: 'more' });
  await page.evaluate(() => document.querySelector('.stage')?.classList.add('is-shaping'));
  /** By which factor two colours differ as WCAG counts it. */
  const contrasts = () =>
    page.evaluate(() => {
      const light = (/** @type {string} */ colour) =>
        colour.match(/[\d.]+/g)?.slice(0, 3).map((part) => (Number(part) / 255 <= 0.04045 ? Number(part) / 255 / 12.92 : ((Number(part) / 255 + 0.055) / 1.055) ** 2.4))
          .reduce((sum, part, i) => sum + part * [0.2126, 0.7152, 0.0722][i], 0.05) ?? NaN;
      const of = (/** @type {string} */ selector, /** @type {string} */ property) => {
        const it = document.querySelector(selector);
        return it ? light(getComputedStyle(it).getPropertyValue(property)) : NaN;
      };
      const ground = of('.panel', 'background-color');
      const from = (/** @type {number} */ there) => Math.max(ground, there) / Math.min(ground, there);
      return {
        letters: ['.control .about', '.mode[aria-selected=false]', '.measures dt', '.hint'].map((selector) => from(of(selector, 'color'))),
        edges: [of('.tab', 'border-bottom-color'), of('.bar', 'border-bottom-color'), of('#section-features .line', 'background-color')].map(from),
        accent: from(of('.tab[aria-pressed=true]', 'border-bottom-color')),
        hint: getComputedStyle(/** @type {Element} */ (document.querySelector('.hint'))).backgroundColor,
      };
    });
  for (const theme of ['day', 'night']) {
    if (theme === 'night') await page.getByRole('button', { name: 'Light or dark' }).click();
    const { letters, edges, accent, hint } = await contrasts();
    assert.ok(Math.min(...letters) >= 7, `${theme}: ${letters}`);
    assert.ok(Math.min(...edges, accent) >= 3, `${theme}: ${edges}, ${accent}`);
    assert.match(hint, /^rgb\(/, 'nothing of the face is behind letters');
  }
  await context.close();
});

test('where a window is low and broad, the face has its height beside the sliders, and one is in sight', async () => {
  const { context, page } = await open(browser, site, { viewport: { width: 819, height: 514 } });
  /** @param {string} of */
  const box = async (of) => (await page.locator(of).first().boundingBox()) ?? assert.fail(of);
  // Projectors of 1024 by 768 at 125 and 150 per cent, and phones on their side.
  for (const [width, height] of [[819, 514], [683, 512], [683, 430], [740, 360]]) {
    await page.setViewportSize({ width, height });
    const [stage, panel, slider] = [await box('.stage'), await box('.panel'), await box('[aria-labelledby=feature-title] .track')];
    assert.ok(stage.x + stage.width <= panel.x + 0.5 && stage.height > height - 60, `${width} x ${height}: ${JSON.stringify(stage)}`);
    assert.ok(stage.width >= 0.55 * width && panel.width >= 250, `${width} x ${height}: ${stage.width}, ${panel.width}`);
    assert.ok(slider.y + slider.height <= height, `${width} x ${height}: the first slider ends at ${slider.y + slider.height}`);
    // What explains covers the sliders, and what is said some of the stage: the face stays free.
    await page.getByRole('button', { name: 'What is happening?' }).click();
    assert.ok((await box('.explanation')).x >= panel.x, `${width} x ${height}`);
    await page.keyboard.press('Escape');
    await page.getByRole('button', { name: 'Random face' }).click();
    const said = await box('.toast');
    assert.ok(said.x >= 0 && said.x + said.width <= panel.x, `${width} x ${height}: ${JSON.stringify(said)}`);
  }
  // A window that is higher than that has the sliders below.
  await page.setViewportSize({ width: 800, height: 800 });
  assert.ok((await box('.panel')).y >= (await box('.stage')).height);
  await context.close();
});

test('what is chosen is in sight on a phone on its side, and after the letters have grown', async () => {
  const { context, page } = await open(browser, site, { viewport: { width: 844, height: 390 }, hasTouch: true, isMobile: true });
  /** How much of the chosen one's row is between it and the nearer end, px; less than 0 when it is cut. */
  const room = (/** @type {string} */ row) =>
    page.locator(row).evaluate((it) => {
      const chosen = it.querySelector('[aria-pressed=true], [aria-selected=true]').getBoundingClientRect();
      const { left, right } = it.getBoundingClientRect();
      return Math.min(chosen.left - left, right - chosen.right);
    });
  assert.ok((await room('.tabs')) >= 0, 'the nose of a new face');
  await page.getByRole('tab', { name: 'Photo' }).tap();
  assert.ok((await room('.modes')) >= 0);
  await page.getByRole('tab', { name: 'Features' }).tap();
  assert.ok((await room('.modes')) >= 0, 'back from the last');
  await page.getByRole('tab', { name: 'Mix' }).tap();
  await page.evaluate(() => (document.documentElement.style.fontSize = '200%'));
  await page.waitForFunction(() => document.querySelector('.modes').scrollWidth > 2 * document.querySelector('.modes').clientWidth);
  await page.evaluate(() => new Promise((laid) => requestAnimationFrame(() => requestAnimationFrame(laid))));
  assert.ok((await room('.modes')) >= 0, 'in large letters');
  await context.close();
});
