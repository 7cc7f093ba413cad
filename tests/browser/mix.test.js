import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { decodePng, differing, download, fingerOn, landmarkOnScreen, later, moveSlider, onePage, open, picture, pictureOfPage, settled, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

const codeOf = (page) => page.evaluate(() => window.designer.face.code);
const coefficients = (page) => page.evaluate(() => [...window.designer.face.coefficients]);
/** The coefficients of one feature, by asking which of them its reset changes. */
const partOf = (page, group) =>
  page.evaluate((region) => {
    const { model } = window.designer;
    const face = model.face();
    const median = face.coefficients;
    face.coefficients = median.map((c) => c + 1);
    face.reset(region);
    const found = [...face.coefficients.keys()].filter((i) => face.coefficients[i] === median[i]);
    face.free();
    // The last ones are edits on top, one a control that sets a length: no preset has any.
    const edits = window.designer.model.controls.filter((control) => control.measure).length;
    return found.filter((i) => i < median.length - edits);
  }, group);
const faceIn = (page, name) => page.locator('.tray').getByRole('button', { name, exact: true });
/** What a face of the tray is, found by taking it over and undoing that. */
const codeOfPreset = async (page, name) => {
  await faceIn(page, name).click();
  await page.getByRole('button', { name: 'Take over' }).click();
  const code = await codeOf(page);
  await page.getByRole('button', { name: 'Undo', exact: true }).click();
  await faceIn(page, name).click();
  return code;
};

describe('mixing', () => {
  test('a face dragged onto a feature lends it, and only it; what is locked stays', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    const nose = await partOf(page, 'nose');
    const median = await coefficients(page);
    const nostril = await landmarkOnScreen(page, 'ibug_30');
    await page.getByRole('tab', { name: 'Mix' }).click();
    assert.equal(await page.locator('.tray-face').count(), 12);
    await settled(page);
    const before = await picture(page, 'mix-before');

    const carry = async (name, to, meanwhile = async () => {}) => {
      const box = await faceIn(page, name).boundingBox();
      assert.ok(box);
      await page.mouse.move(box.x + box.width / 2, box.y + 30);
      await page.mouse.down();
      await page.mouse.move(to.x + 30, to.y, { steps: 3 });
      await page.mouse.move(to.x, to.y);
      assert.ok(await page.locator('.drag-face').isVisible());
      await meanwhile();
      await page.mouse.up();
      assert.equal(await page.locator('.drag-face').count(), 0);
    };
    await carry('Preset 3', nostril);
    const taken = await coefficients(page);
    taken.forEach((value, i) => assert.equal(value !== median[i], nose.includes(i), `coefficient ${i}`));
    await page.mouse.move(5, 5);
    const shown = await picture(page, 'mix-nose');
    const box = await page.locator('canvas').boundingBox();
    assert.ok(box);
    const at = (nostril.y - box.y) / box.height;
    assert.ok(differing(before, shown, [0.3, at - 0.12, 0.7, at + 0.08]) > 150);
    assert.equal(differing(before, shown, [0, 0, 1, 0.2]), 0, 'the crown changed');

    // Beside the head it is dropped, and nothing happens; a locked feature refuses.
    await carry('Preset 5', { x: box.x + 12, y: box.y + 200 });
    assert.deepEqual(await coefficients(page), taken);
    await page.evaluate(() => window.designer.face.lock('nose'));
    await carry('Preset 5', nostril);
    assert.deepEqual(await coefficients(page), taken);
    assert.match((await page.locator('.toast').textContent()) ?? '', /nose is locked/);
    // Another tab saves a face, which makes all that are shown anew, while one of them is carried.
    await page.evaluate(() => window.designer.face.unlock('nose'));
    await carry('Preset 5', nostril, async () => {
      const other = await context.newPage();
      await other.goto(site.url);
      await other.waitForFunction(() => document.documentElement.dataset.ready === 'true');
      await other.getByRole('tab', { name: 'Faces' }).click();
      await other.getByRole('button', { name: 'Save', exact: true }).click();
      await other.close();
      await faceIn(page, 'My face 1').waitFor();
    });
    assert.notDeepEqual(await coefficients(page), taken);
    assert.match((await page.locator('.toast').textContent()) ?? '', /Preset 5/);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('by keyboard: a feature taken over, an amount up and down, the circle, undo', async () => {
    const { context, page, complaints } = await open(browser, site);
    await moveSlider(page, 'nose 1', 0.9);
    const start = await coefficients(page);
    const mouth = await partOf(page, 'mouth');
    await page.getByRole('tab', { name: 'Features' }).focus();
    const mix = page.getByRole('tab', { name: 'Mix' });
    for (let n = 0; n < 4 && (await mix.getAttribute('aria-selected')) !== 'true'; n++) await page.keyboard.press('ArrowRight');
    const [three, five] = [await codeOfPreset(page, 'Preset 3'), await codeOfPreset(page, 'Preset 5')];
    assert.deepEqual(await coefficients(page), start);
    const of = (code) =>
      page.evaluate((c) => {
        const face = window.designer.model.fromCode(c);
        const found = [...face.coefficients];
        face.free();
        return found;
      }, code);
    const goal = await of(three);

    await faceIn(page, 'Preset 3').focus();
    await page.keyboard.press('Enter');
    await page.getByLabel('Where').selectOption('Mouth');
    const amount = page.getByRole('slider', { name: 'How much', exact: true });
    await amount.focus();
    await page.keyboard.press('End');
    // Mixed coefficients lie in steps of 1/8192; the circle blends one face after the other.
    const near = (a, b, what) => a.forEach((v, i) => assert.ok(Math.abs(v - b[i]) < 2e-4, `${what}: coefficient ${i}: ${v}, not ${b[i]}`));
    near(await coefficients(page), start.map((v, i) => (mouth.includes(i) ? goal[i] : v)), 'all of the mouth');
    await page.keyboard.press('5');
    await page.keyboard.press('0');
    await page.keyboard.press('Enter');
    near(await coefficients(page), start.map((v, i) => (mouth.includes(i) ? (v + goal[i]) / 2 : v)), 'half');
    await amount.focus();
    await page.keyboard.press('Home');
    assert.deepEqual(await coefficients(page), start, 'down again is where it began');

    // Two faces in the circle: on one of them it is that face, in the middle the mean of both.
    await page.getByRole('button', { name: 'Add to the circle' }).click();
    await faceIn(page, 'Preset 5').click();
    await page.getByRole('button', { name: 'Add to the circle' }).click();
    const other = await of(five);
    const puck = page.getByRole('slider', { name: 'Mixture' });
    await puck.focus();
    await page.keyboard.press('Home');
    near(await coefficients(page), goal.map((v, i) => (v + other[i]) / 2), 'the middle');
    for (let i = 0; i < 4; i++) await page.keyboard.press('Shift+ArrowUp');
    near(await coefficients(page), goal, 'on the first');
    assert.match((await puck.getAttribute('aria-valuetext')) ?? '', /Preset 3 100%, Preset 5 0%/);
    const ring = await page.locator('.ring').boundingBox();
    assert.ok(ring);
    await page.locator('.ring').scrollIntoViewIfNeeded();
    await puck.dragTo(page.locator('.ring'), { targetPosition: { x: ring.width / 2, y: ring.height * 0.8 } });
    const share = ((await puck.getAttribute('aria-valuetext')) ?? '').match(/Preset 5 (\d+)%/)?.[1];
    assert.ok(Number(share) > 80, `the puck is near the second face: ${share} %`);
    await page.getByRole('button', { name: 'Take Preset 3 out of the circle' }).click();
    assert.equal(await page.locator('.member').count(), 1);
    assert.equal(await page.evaluate(() => document.activeElement?.getAttribute('aria-label')), 'Take Preset 5 out of the circle');
    // One face has nothing between it and another: beside it nothing is pressed.
    const alone = await codeOf(page);
    await page.locator('.ring').click({ position: { x: ring.width / 2, y: ring.height * 0.8 } });
    assert.equal(await codeOf(page), alone);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('the puck stands where the mixture is that the face shows, also when steps are taken back', async () => {
    const { context, page, complaints } = await open(browser, site);
    await page.getByRole('tab', { name: 'Mix' }).click();
    for (const name of ['Preset 3', 'Preset 5', 'Preset 7']) {
      await faceIn(page, name).click();
      await page.getByRole('button', { name: 'Add to the circle' }).click();
    }
    const puck = page.getByRole('slider', { name: 'Mixture' });
    const undo = () => page.getByRole('button', { name: 'Undo', exact: true }).click();
    const redo = () => page.getByRole('button', { name: 'Redo', exact: true }).click();
    const place = async () => [await codeOf(page), await puck.getAttribute('aria-valuetext')];
    const move = async (/** @type {string} */ key) => {
      await later(page);
      await puck.press(key);
      return place();
    };
    const start = await place();
    const up = await move('Shift+ArrowUp');
    const right = await move('Shift+ArrowRight');
    assert.equal(new Set([start, up, right].map(([, words]) => words)).size, 3);
    await undo();
    assert.deepEqual(await place(), up);
    await undo();
    assert.deepEqual(await place(), start);
    await redo();
    await redo();
    assert.deepEqual(await place(), right);
    // What else is done to the mixture is none of the puck's, and taking that back leads to where it was.
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    const [, words] = await place();
    assert.equal(words, right[1]);
    await undo();
    await undo();
    assert.deepEqual(await place(), up);
    // It goes on from there.
    assert.deepEqual(await move('Shift+ArrowRight'), right);
    // Of other faces a place is another mixture.
    await faceIn(page, 'Preset 9').click();
    await page.getByRole('button', { name: 'Add to the circle' }).click();
    const [, middle] = await place();
    await undo();
    assert.deepEqual(await place(), [up[0], middle]);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('under a finger a face goes up onto the head, and the tray scrolls sideways', async () => {
    const { context, page } = await open(browser, site, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
    const mouth = await partOf(page, 'mouth');
    const median = await coefficients(page);
    const lip = await landmarkOnScreen(page, 'ibug_57');
    await page.getByRole('tab', { name: 'Mix' }).tap();
    await settled(page);
    const finger = await fingerOn(context, page);
    const box = await faceIn(page, 'Preset 2').boundingBox();
    assert.ok(box);
    await finger([box.x + 30, box.y + 40], [box.x + 30, lip.y + 60], [lip.x, lip.y]);
    const taken = await coefficients(page);
    taken.forEach((value, i) => assert.equal(value !== median[i], mouth.includes(i), `coefficient ${i}`));
    await finger([box.x + 30, box.y + 40], [box.x - 40, box.y + 40]);
    await page.waitForFunction(() => (document.querySelector('.tray')?.scrollLeft ?? 0) > 20);
    assert.deepEqual(await coefficients(page), taken);

    // On its side the phone has the head beside the panel: the other way round.
    await page.setViewportSize({ width: 740, height: 360 });
    await settled(page);
    const nose = await partOf(page, 'nose');
    const tip = await landmarkOnScreen(page, 'ibug_30');
    // There the tray fills the panel, and who is chosen is told of below it.
    await faceIn(page, 'Preset 1').tap();
    const told = await page.locator('.chosen-head').boundingBox();
    assert.ok(told && told.y > 40 && told.y + told.height <= 360, JSON.stringify(told));
    await faceIn(page, 'Preset 1').tap();
    const face = faceIn(page, 'Preset 4');
    await face.scrollIntoViewIfNeeded();
    const place = await face.boundingBox();
    assert.ok(place);
    const from = /** @type {[number, number]} */ ([place.x + 30, place.y + 40]);
    await finger(from, [tip.x + 80, from[1]], [tip.x, tip.y]);
    const both = await coefficients(page);
    both.forEach((value, i) => assert.equal(value !== taken[i], nose.includes(i), `coefficient ${i}`));
    const before = await face.boundingBox();
    await finger(from, [from[0], from[1] - 60]);
    await page.waitForFunction(([id, y]) => document.querySelector(`[data-id="${id}"]`).getBoundingClientRect().y < y - 20, /** @type {const} */ (['preset-4', before.y]));
    assert.deepEqual(await coefficients(page), both);
    await context.close();
  });
});

describe('the way as a film', () => {
  test('a GIF of it, there and back, leaves the face as it was; a film can be stopped', async () => {
    // A film has 96 frames, whatever the size: the stage is small here, its pixels few.
    const { context, page, complaints } = await open(browser, site, { viewport: { width: 640, height: 400 }, deviceScaleFactor: 0.25, drawn: true });
    const code = () => page.evaluate(() => window.designer.face.code);
    const before = await code();
    const still = await picture(page, 'film-before');
    await page.getByRole('tab', { name: 'Mix' }).click();
    const morph = page.getByRole('region', { name: 'Morph' });
    // Somebody bald: hair would be grown for each frame, which colours.test.js looks at.
    await morph.getByLabel('To', { exact: true }).selectOption('Preset 3');
    const take = async (/** @type {string} */ button) => {
      const [file] = await Promise.all([
        page.waitForEvent('download', { timeout: 120_000 }),
        morph.getByRole('button', { name: button }).click(),
      ]);
      return { name: file.suggestedFilename(), bytes: await readFile(await file.path()) };
    };
    const drawn = () => page.evaluate(() => window.designer.frames);
    const first = await drawn();
    const gif = await take('As a GIF');
    assert.equal(gif.name, 'morph.gif');
    const draws = (await drawn()) - first;
    assert.ok(draws >= 96 && draws < 110, `the stage was drawn ${draws} times for 96 frames`);
    assert.equal(gif.bytes.toString('latin1', 0, 6), 'GIF89a');
    let frames = 0;
    // A graphic control extension before each frame: 4 bytes, no disposal or transparency asked for.
    for (let at = gif.bytes.indexOf('\x21\xf9\x04', 0, 'latin1'); at >= 0; at = gif.bytes.indexOf('\x21\xf9\x04', at + 1, 'latin1')) frames++;
    assert.ok(frames >= 96, `${frames} frames`);
    await morph.getByText('Saved morph.gif').waitFor();
    assert.equal(await code(), before);

    // How a video is made is film.test.js's; here it begins, and is stopped.
    await morph.getByRole('button', { name: 'As a video' }).click();
    await morph.getByRole('progressbar').waitFor();
    assert.ok(await morph.getByRole('button', { name: 'Play' }).isDisabled());
    await morph.getByRole('button', { name: 'Stop' }).click();
    await morph.getByText('The film was stopped.').waitFor();
    assert.ok(await morph.getByRole('progressbar').isHidden());
    assert.equal(await code(), before);
    assert.equal(differing(still, await picture(page, 'film-after')), 0, 'the stage shows the face again');
    assert.deepEqual(complaints, []);
    await context.close();
  });
});

describe('comparing', () => {
  test('another face has its own hair and colours, and a split can be ended from any section', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true, viewport: { width: 1100, height: 640 } });
    await page.locator('.invitation').getByRole('button', { name: 'Close' }).click();
    const start = await picture(page, 'compare-bald');
    await page.getByRole('tab', { name: 'Looks' }).click();
    await page.getByRole('button', { name: 'Wavy', exact: true }).click();
    await moveSlider(page, 'Skin, fair to deep', 0.9);
    const own = await picture(page, 'compare-wavy');
    await page.getByRole('tab', { name: 'Compare' }).click();
    await page.getByRole('button', { name: 'Hold to see it' }).hover();
    await page.mouse.down();
    assert.equal(differing(start, await picture(page, 'compare-wavy-held')), 0);
    await page.mouse.up();
    assert.equal(differing(own, await picture(page, 'compare-wavy-let-go')), 0);

    await page.getByLabel('Split by a line').check();
    const halves = async (/** @type {string} */ name) => {
      await page.locator('.divider').evaluate((line) => (line.style.opacity = '0'));
      await page.locator('.split-end').evaluate((end) => (end.style.opacity = '0'));
      return picture(page, name);
    };
    const both = await halves('compare-wavy-split');
    assert.equal(differing(start, both, [0, 0, 0.49, 1]), 0);
    assert.equal(differing(own, both, [0.51, 0, 1, 1]), 0);
    await page.getByLabel('Compare with').selectOption('Preset 6');
    assert.ok(differing(start, await halves('compare-preset'), [0, 0, 0.49, 1]) > 500);

    // Where the colours' scale stands there is no head.
    await page.getByLabel('Distance as colour').check();
    const [bar, canvas] = [await page.locator('.colour-bar').boundingBox(), await page.locator('canvas').boundingBox()];
    assert.ok(bar && canvas);
    const [x, y] = [bar.x - canvas.x, bar.y - canvas.y];
    const under = [x / canvas.width, y / canvas.height, (x + bar.width) / canvas.width, (y + bar.height) / canvas.height];
    assert.equal(differing(start, own, under), 0);

    await page.getByRole('tab', { name: 'Features' }).click();
    await page.getByRole('button', { name: 'Take the colours off' }).click();
    await page.getByRole('button', { name: 'Show one face again' }).click();
    assert.ok(await page.getByRole('slider', { name: 'Line between the two faces' }).isHidden());
    assert.equal(differing(own, await picture(page, 'compare-parted')), 0);
    await page.getByRole('tab', { name: 'Compare' }).click();
    assert.equal(await page.getByLabel('Split by a line').isChecked(), false);

    // From now on the hair is the start's, too.
    await page.getByRole('button', { name: 'Use this face as the start' }).click();
    await page.getByLabel('Compare with').selectOption('The start');
    await page.getByRole('button', { name: 'Hold to see it' }).hover();
    await page.mouse.down();
    assert.equal(differing(own, await picture(page, 'compare-new-start')), 0);
    await page.mouse.up();
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('held, split, in colours and in numbers', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    const start = await picture(page, 'compare-start');
    const box = await page.locator('canvas').boundingBox();
    const nose = await landmarkOnScreen(page, 'ibug_30');
    assert.ok(box);
    await moveSlider(page, 'nose 1', 0.98);
    const width = await page.evaluate(() => window.designer.face.measure('nose width'));
    const own = await picture(page, 'compare-own');
    await page.getByRole('tab', { name: 'Compare' }).click();

    const hold = page.getByRole('button', { name: 'Hold to see it' });
    await hold.hover();
    await page.mouse.down();
    assert.equal(differing(start, await picture(page, 'compare-held')), 0);
    await page.mouse.up();
    assert.equal(differing(own, await picture(page, 'compare-let-go')), 0);
    await hold.focus();
    await page.keyboard.down('Space');
    assert.equal(differing(start, await picture(page, 'compare-held-by-key')), 0);
    await page.keyboard.up('Space');

    // What is taken along of a split view has both.
    const taken = async () => {
      await page.getByRole('button', { name: 'Take the face with you' }).click();
      await page.getByLabel('Width in pixels').fill('400');
      await page.getByLabel('Height in pixels').fill('400');
      const { bytes } = await download(page, 'PNG');
      await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
      return decodePng(bytes);
    };
    await page.evaluate(() => (window.looking = true));
    const alone = await taken();
    await page.getByLabel('Split by a line').check();
    const both = await taken();
    // Below the names.
    const part = (/** @type {number} */ from, /** @type {number} */ to) => differing(alone, both, [from, 0.1, to, 1]);
    assert.ok(part(0, 0.49) > 300, `the left half differs in ${part(0, 0.49)} pixels`);
    assert.equal(part(0.51, 1), 0, 'the right half is as it is alone, edges too');
    await page.getByLabel('Split by a line').uncheck();
    await page.evaluate(() => (window.looking = false));

    // Left of the line the start, right of it the face; each as it is alone, up to the line.
    await page.getByLabel('Split by a line').check();
    await settled(page);
    await page.locator('.divider').evaluate((line) => (line.style.opacity = '0'));
    const middle = await picture(page, 'compare-split');
    assert.equal(differing(start, middle, [0, 0.1, 0.49, 1]), 0);
    assert.equal(differing(own, middle, [0.51, 0.1, 1, 1]), 0);
    assert.ok(differing(own, middle, [0, 0.1, 0.49, 1]) > 50);
    const line = page.getByRole('slider', { name: 'Line between the two faces' });
    await line.focus();
    await page.keyboard.press('Home');
    assert.equal(differing(own, await picture(page, 'compare-split-left'), [0.05, 0.1, 1, 1]), 0);
    const handle = await line.boundingBox();
    assert.ok(handle);
    await page.mouse.move(handle.x + 22, handle.y + 120);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.96 * box.width, handle.y + 120, { steps: 3 });
    await page.mouse.up();
    assert.equal(differing(start, await picture(page, 'compare-split-right'), [0, 0.1, 0.94, 1]), 0);
    await page.getByLabel('Split by a line').uncheck();

    // Colours: the crown has not moved and has the scale's first colour; the nose has others.
    await page.getByLabel('Distance as colour').check();
    const warm = await picture(page, 'compare-heat');
    const pixel = (x, y) => {
      const o = 3 * (Math.round(y) * warm.width + Math.round(x));
      return [...warm.rgb.subarray(o, o + 3)];
    };
    const crown = pixel(0.5 * warm.width, 0.22 * warm.height);
    assert.ok(crown[2] > crown[1] + 30 && crown[0] < 110, `the crown is ${crown}`);
    let far = 0;
    for (let y = -40; y < 30; y++) {
      for (let x = -40; x < 40; x++) {
        const [r, g, b] = pixel(nose.x - box.x + x, nose.y - box.y + y);
        if (g > b + 20 && g > 90 && g >= r - 20) far++;
      }
    }
    assert.ok(far > 100, `only ${far} pixels around the nose are far`);
    assert.match((await page.locator('.colour-bar').textContent()) ?? '', /The start.*0.*≥ [\d.]+ mm/);
    await pictureOfPage(page, 'compare');

    // The start's contours over this face: in the picture where heads end and features do, and in its file with whose they are.
    await page.getByLabel('Distance as colour').uncheck();
    const bare = await picture(page, 'compare-bare');
    const outline = page.getByLabel('The other’s outline over this face');
    await outline.check();
    await page.waitForFunction(() => performance.getEntriesByType('resource').some(({ name }) => /outline-[^/]*\.js$/.test(name)));
    await settled(page);
    const lined = await picture(page, 'compare-outline');
    assert.match((await page.locator('.outline-key').textContent()) ?? '', /The start/);
    // Skin is red and the wall is grey: nothing else on the stage is as blue.
    const inked = (/** @type {{ width: number, height: number, rgb: Uint8Array }} */ { width, height, rgb }, /** @type {number[]} */ [left, top, right, bottom]) => {
      let count = 0;
      for (let y = Math.round(top * height); y < bottom * height; y++) {
        for (let x = Math.round(left * width); x < right * width; x++) {
          const [r, g, b] = rgb.subarray(3 * (y * width + x));
          if (b > r + 50 && b > g + 10) count++;
        }
      }
      return count;
    };
    const all = [0.1, 0.1, 0.9, 0.85];
    assert.equal(inked(bare, all), 0);
    const ink = inked(lined, all);
    assert.ok(ink > 200, `the line has ${ink} pixels`);
    // Nothing is drawn on the cheeks, and nothing changes there.
    assert.equal(differing(bare, lined, [0.38, 0.6, 0.44, 0.66]), 0);
    // It goes with the view, and stays the start's while the face changes.
    await page.getByRole('button', { name: 'Profile' }).click();
    await settled(page);
    const aside = await picture(page, 'compare-outline-profile');
    assert.ok(inked(aside, all) > 200);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await settled(page);
    const changed = await picture(page, 'compare-outline-changed');
    const off = [aside, changed].map((of) => inked(of, [0, 0, 1, 0.35]));
    assert.equal(off[0], off[1], 'where nothing else changes');
    assert.ok(differing(aside, changed) > 100);
    await page.getByRole('button', { name: 'Redo', exact: true }).click();
    const png = await taken();
    assert.ok(inked(png, [0, 0, 1, 0.9]) > 50, 'a picture of it has it');
    assert.ok(inked(png, [0, 0.9, 0.5, 1]) > 5, 'and says whose it is, with a stroke of its colour');
    await page.getByRole('button', { name: 'Take the outline off' }).click();
    assert.equal(await outline.isChecked(), false);
    assert.equal(inked(await picture(page, 'compare-outline-off'), all), 0);
    await page.getByRole('button', { name: 'Front' }).click();
    await page.getByLabel('Distance as colour').check();

    // Angles are of the face at rest, as lengths are.
    const angles = page.getByRole('table', { name: 'Angles in the profile, degrees' });
    const nasal = angles.getByRole('row').filter({ hasText: /^nasolabial/ });
    const [degrees, others] = await nasal.locator('td').allTextContents();
    assert.ok(Number(degrees) > 70 && Number(degrees) < 150 && degrees !== others, `${degrees} and ${others}`);

    const row = page.locator('.lengths tr').filter({ hasText: /^nose width/ });
    const [here, there, apart] = await row.locator('td').allTextContents();
    assert.equal(here, width.toFixed(1));
    const median = await page.evaluate(() => window.designer.model.face().measure('nose width'));
    assert.equal(there, median.toFixed(1));
    const printed = Number(apart.replace('−', '-'));
    assert.ok(Math.abs(printed - (width - median)) <= 0.051, `${apart} for ${width - median}`);

    // From now on: no difference anywhere.
    await page.getByRole('button', { name: 'Use this face as the start' }).click();
    assert.ok((await page.locator('.lengths td:last-child').allTextContents()).every((d) => d === '0.0'));
    await page.getByLabel('Compare with').selectOption('Preset 6');
    assert.ok((await page.locator('.lengths td.differs').count()) > 8);
    await page.getByRole('button', { name: 'Take the colours off' }).click();
    assert.equal(await page.getByLabel('Distance as colour').isChecked(), false);
    assert.deepEqual(complaints, []);
    await context.close();
  });
});

describe('comparing on a phone', () => {
  test('a long name beside the line ends where the stage does', async () => {
    const { context, page, complaints } = await open(browser, site, { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true });
    const name = 'Last visit, 3 Feb 2024, 12:00, at the end of a long day';
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('textbox', { name: 'Save this face as' }).fill(name);
    await page.keyboard.press('Enter');
    await page.getByRole('tab', { name: 'Compare' }).click();
    await page.getByLabel('Compare with').selectOption(name);
    await page.getByLabel('Split by a line').check();
    const [left, right] = await page.locator('.side').evaluateAll((sides) => sides.map((it) => ({ ...it.getBoundingClientRect().toJSON(), cut: it.scrollWidth > it.clientWidth })));
    assert.ok(left.left >= 4 && left.cut, `it begins at ${left.left}`);
    assert.ok(right.right <= 356 && !right.cut);
    // Nothing on the stage is under something else, nor is it where a photo was opened.
    const under = () =>
      page.evaluate(() => {
        const all = ['.explain-open', '.photo-sides', '.side.left', '.side.right', '.split-end'].map((of) => /** @type {const} */ ([of, document.querySelector(of)?.getBoundingClientRect()]));
        const shown = all.filter(([, box]) => box?.width > 0);
        return shown.flatMap(([one, a], i) =>
          shown.slice(i + 1).filter(([, b]) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom).map(([other]) => `${one} and ${other}`),
        );
      });
    assert.deepEqual(await under(), []);
    await page.setViewportSize({ width: 740, height: 740 });
    await page.waitForFunction(() => {
      const side = document.querySelector('.side.left');
      return side.getBoundingClientRect().left >= 4 && side.getBoundingClientRect().width > 200;
    });
    await page.setViewportSize({ width: 360, height: 740 });
    await page.getByRole('tab', { name: 'Photo' }).click();
    await page.getByRole('button', { name: 'An example' }).click();
    await page.locator('.photo-sides').waitFor();
    await page.getByRole('tab', { name: 'Compare' }).click();
    await page.getByLabel('Split by a line').uncheck();
    await page.getByLabel('Split by a line').check();
    assert.ok(await page.locator('.photo-sides').isVisible());
    assert.deepEqual(await under(), [], 'with a photo');
    // One of a single word breaks, and widens nothing.
    const word = 'W'.repeat(60);
    const wide = () => page.evaluate(() => [...document.querySelectorAll('.scroll, .toast, html')].filter((it) => it.clientWidth > 0 && it.scrollWidth > Math.min(it.clientWidth, window.innerWidth)).map((it) => it.className));
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('textbox', { name: 'Save this face as' }).fill(word);
    await page.keyboard.press('Enter');
    await page.getByText(`Saved as “${word}”`).waitFor();
    assert.deepEqual(await wide(), []);
    await page.getByRole('tab', { name: 'Mix' }).click();
    await faceIn(page, word).click();
    assert.deepEqual(await wide(), []);
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('button', { name: `Delete ${word}` }).click();
    await page.getByText(`Deleted “${word}”.`).waitFor();
    assert.deepEqual(await wide(), []);
    assert.deepEqual(complaints, []);
    await context.close();
  });
});

describe('between faces, on one page', () => {
  const visit = onePage(browser, site, { sharp: true });

  test('the way between two faces is shown, not taken, until it is kept', async () => {
    const { page } = visit;
    await page.getByRole('tab', { name: 'Mix' }).click();
    const mine = await codeOf(page);
    const four = await codeOfPreset(page, 'Preset 4');
    await page.getByLabel('To', { exact: true }).selectOption('Preset 4');
    await settled(page);
    const still = await picture(page, 'morph-0');
    const way = page.getByRole('slider', { name: 'Progress', exact: true });
    await way.fill('100');
    const there = await picture(page, 'morph-100');
    assert.ok(differing(still, there) > 0.03 * still.width * still.height);
    assert.equal(await codeOf(page), mine);
    await page.getByRole('button', { name: 'Stop' }).click();
    assert.equal(differing(still, await picture(page, 'morph-stopped')), 0);

    await page.getByRole('button', { name: 'Play' }).click();
    await page.waitForFunction(() => /** @type {HTMLInputElement} */ (document.getElementById('morph-at')).valueAsNumber > 20);
    await page.getByRole('button', { name: 'Pause' }).click();
    const at = await way.inputValue();
    const frames = await page.evaluate(() => window.designer.frames);
    assert.ok(frames > 0);
    await settled(page);
    assert.equal(await way.inputValue(), at, 'it plays on while paused');
    // It goes on from where it is, and that way: a frame comes when the test says so.
    await way.fill('25');
    const played = await page.evaluate(() => {
      const input = /** @type {HTMLInputElement} */ (document.getElementById('morph-at'));
      const button = /** @type {HTMLButtonElement} */ (document.querySelector('[data-playing]'));
      const { requestAnimationFrame } = window;
      /** After so many ms of playing. @param {number} ms */
      const after = (ms) => {
        /** @type {FrameRequestCallback[]} */
        const frames = [];
        window.requestAnimationFrame = (frame) => frames.push(frame);
        button.click();
        const now = performance.now();
        for (const frame of frames.splice(0)) frame(now + ms);
        window.requestAnimationFrame = requestAnimationFrame;
        button.click();
        // What is to be drawn is drawn all the same.
        for (const frame of frames) requestAnimationFrame(frame);
        return input.valueAsNumber;
      };
      // The way takes 2.4 s: after as long it comes back, as far from its other end.
      return [after(0), after(2400), after(0), after(400)];
    });
    // Give or take what a busy machine takes for a click.
    [25, 75, 75].forEach((value, i) => assert.ok(Math.abs(played[i] - value) < 4, `${played}`));
    assert.ok(played[3] < 60, `${played}: it was on its way back`);
    // Who shapes the face sees it from the first move on.
    const caricature = page.getByRole('slider', { name: 'Caricature', exact: true });
    await caricature.evaluate((/** @type {HTMLInputElement} */ input) => {
      input.value = '150';
      input.dispatchEvent(new Event('input', { bubbles: true }));
    });
    assert.equal(await way.inputValue(), '0');
    await caricature.dispatchEvent('change');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await way.fill('100');
    await page.getByRole('button', { name: 'Keep this face' }).click();
    assert.equal(await codeOf(page), four);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await codeOf(page), mine);

    // What is locked stays.
    const nose = await partOf(page, 'nose');
    const before = await coefficients(page);
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.getByRole('button', { name: 'Lock the nose' }).click();
    await page.getByRole('tab', { name: 'Mix' }).click();
    await way.fill('100');
    await page.getByRole('button', { name: 'Keep this face' }).click();
    const after = await coefficients(page);
    assert.deepEqual(nose.map((i) => after[i]), nose.map((i) => before[i]));
    assert.ok(after.some((value, i) => value !== before[i]));
    // And who keeps, mixes or rolls dice is told of it.
    assert.match((await page.locator('.toast').textContent()) ?? '', /^What is locked stays as it is/);
    await faceIn(page, 'Preset 4').click();
    await page.getByLabel('Where').selectOption('Nose');
    const much = page.getByRole('slider', { name: 'How much', exact: true });
    await much.focus();
    await page.keyboard.press('End');
    assert.equal(await page.locator('.toast').textContent(), 'The nose is locked and stays as it is.');
    assert.equal(await much.inputValue(), '0', 'nothing of it is mixed in');
    assert.equal(await page.locator('[aria-live] .control').count(), 0, 'a slider says itself what it does');
    await page.getByLabel('Where').selectOption('');
    await faceIn(page, 'Preset 4').click();
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.locator('.toast').evaluate((toast) => (toast.textContent = ''));
    await page.getByRole('button', { name: 'Random nose' }).click();
    assert.equal(await page.locator('.toast').textContent(), 'The nose is locked and stays as it is.');
    assert.deepEqual(await coefficients(page), after);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await codeOf(page), mine);
    assert.deepEqual(await page.evaluate(() => window.designer.face.locked), []);
    assert.deepEqual(visit.complaints, []);
  });

  test('all of a face goes over with its way of blending, and a new name is known everywhere', async () => {
    const { page } = visit;
    const alpha = () => page.evaluate(() => window.designer.face.alpha);
    const usual = await alpha();
    await page.getByRole('tab', { name: 'Features' }).click();
    await moveSlider(page, 'nose 1', 0.9);
    await page.locator('#alpha').evaluate((input) => input.closest('details')?.setAttribute('open', ''));
    await moveSlider(page, 'Blending distance', 15);
    assert.equal(await alpha(), 15);
    const wide = await codeOf(page);
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('textbox', { name: 'Save this face as' }).fill('Ada');
    await page.keyboard.press('Enter');
    await page.getByRole('button', { name: 'Reset all' }).click();
    assert.equal(await alpha(), usual);
    assert.equal(await page.evaluate(() => location.hash), '');

    await page.getByRole('tab', { name: 'Compare' }).click();
    await page.getByLabel('Compare with').selectOption('Ada');
    await page.getByLabel('Split by a line').check();
    await page.getByRole('tab', { name: 'Mix' }).click();
    await faceIn(page, 'Ada').click();
    await page.getByRole('button', { name: 'Take over' }).click();
    assert.equal(await codeOf(page), wide, 'taken over');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await page.getByRole('slider', { name: 'How much', exact: true }).fill('100');
    assert.equal(await codeOf(page), wide, 'all of the way');
    await page.getByRole('slider', { name: 'How much', exact: true }).fill('50');
    assert.ok(Math.abs((await alpha()) - (usual + 15) / 2) < 0.1, `half of the way it is ${await alpha()}`);
    await page.getByRole('slider', { name: 'How much', exact: true }).dispatchEvent('change');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await page.getByLabel('To', { exact: true }).selectOption('Ada');
    await page.getByRole('slider', { name: 'Progress', exact: true }).fill('100');
    await page.getByRole('button', { name: 'Keep this face' }).click();
    assert.equal(await codeOf(page), wide, 'at the end of the way');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    // One of a feature does not change the others.
    await page.getByLabel('Where').selectOption('Nose');
    await page.getByRole('button', { name: 'Take over' }).click();
    assert.equal(await alpha(), usual);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await page.getByLabel('Where').selectOption('');

    await page.getByRole('button', { name: 'Add to the circle' }).click();
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('button', { name: 'Rename Ada' }).click();
    await page.keyboard.type('Bea');
    await page.keyboard.press('Enter');
    assert.equal(await page.locator('.side.left').textContent(), 'Bea');
    await page.getByRole('tab', { name: 'Mix' }).click();
    assert.equal(await page.locator('.chosen h3').textContent(), 'Bea');
    await page.getByRole('button', { name: 'Take Bea out of the circle' }).click();
    assert.ok(await page.evaluate(() => document.activeElement !== document.body), 'the focus is lost');
    await page.getByRole('button', { name: 'Show one face again' }).click();
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('button', { name: 'Delete Bea' }).click();
    await page.locator('.restore').getByRole('button', { name: 'Undo' }).press('Enter');
    assert.equal(await page.evaluate(() => document.activeElement?.getAttribute('aria-label')), 'Open Bea');
    await page.getByRole('button', { name: 'Delete Bea' }).click();
    await page.getByRole('button', { name: 'Reset all' }).click();
    assert.deepEqual(visit.complaints, []);
  });

  test('the dice of a feature say so, and no seed that gives another face', async () => {
    const { page } = visit;
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    const seed = await page.locator('#seed').inputValue();
    await page.locator('.tab[data-group="nose"]').click();
    await page.getByRole('button', { name: 'Random nose' }).click();
    assert.equal(await page.locator('.toast').textContent(), 'Random nose');
    assert.equal(await page.locator('#seed').inputValue(), seed);
    await page.getByRole('button', { name: 'Reset all' }).click();
  });

  test('a caricature of the face: less is the average, more ends where sliders do, and what is locked stays', async () => {
    const { page } = visit;
    await page.getByRole('tab', { name: 'Features' }).click();
    await moveSlider(page, 'nose 1', 0.99);
    await moveSlider(page, 'nose 2', 0.3);
    await page.getByRole('tab', { name: 'Mix' }).click();
    await codeOfPreset(page, 'Preset 3');
    const code = await codeOf(page);
    const start = await coefficients(page);
    const far = Math.max(...start.map(Math.abs));
    assert.ok(far > 1.6 && far < 3, `so that twice is too far: ${far}`);
    await settled(page);
    const before = await picture(page, 'caricature-before');
    const slider = page.getByRole('slider', { name: 'Caricature', exact: true });
    assert.equal(await slider.inputValue(), '100');
    const near = (a, b, what) => a.forEach((v, i) => assert.ok(Math.abs(v - b[i]) < 2e-4, `${what}: coefficient ${i}: ${v}, not ${b[i]}`));
    await slider.focus();
    await page.keyboard.press('End');
    near(await coefficients(page), start.map((v) => Math.max(-3, Math.min(3, 2 * v))), 'twice');
    assert.ok(differing(before, await picture(page, 'caricature')) > 0.01 * before.width * before.height);
    await page.keyboard.press('5');
    await page.keyboard.press('0');
    await page.keyboard.press('Enter');
    near(await coefficients(page), start.map((v) => v / 2), 'half');
    await slider.focus();
    await page.keyboard.press('Home');
    assert.ok((await coefficients(page)).every((v) => v === 0), 'the average');
    // Where it began is where it began.
    await slider.press('Delete');
    assert.equal(await codeOf(page), code);
    assert.equal(await slider.inputValue(), '100');

    // Each stop of the way is a step, unless one follows another at once; another change makes a new face, which is itself.
    await later(page);
    await slider.focus();
    await page.keyboard.press('End');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await codeOf(page), code);
    assert.equal(await slider.inputValue(), '100');
    await page.evaluate(() => window.designer.face.lock('nose'));
    const nose = await partOf(page, 'nose');
    await slider.focus();
    await page.keyboard.press('Home');
    (await coefficients(page)).forEach((v, i) => assert.equal(v, nose.includes(i) ? start[i] : 0));
    assert.deepEqual(visit.complaints, []);
  });
});
