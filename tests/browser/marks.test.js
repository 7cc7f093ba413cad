// Marks of the skin are put on the face, moved, taken off, kept and taken along.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { BELOW } from '../../www/src/hair/browline.js';
import { decodeMarks, encodeMarks, FIRST, MOST } from '../../www/src/head/marks.js';
import { glbJson, readPicture } from './glb.js';
import { decodePng, differing, download, fingerOn, landmarkOnScreen, later, moveSlider, open, picture, pictureOfPage, siteAndBrowser, smallTextures } from './site.js';

const { browser, site } = await siteAndBrowser();

const choose = (page) => page.getByRole('tab', { name: 'Looks' }).click();
const marksOn = async (page) => decodeMarks((await page.evaluate(() => window.designer.colouring.marks)) ?? '');
const putOn = (page, kind) => page.getByRole('group', { name: 'Put on' }).getByRole('button', { name: kind }).click();
const toast = (page) => page.locator('.toast');

/** On the left cheek, away from what is painted. */
async function cheek(page) {
  const [eye, nose] = [await landmarkOnScreen(page, 'ibug_46'), await landmarkOnScreen(page, 'ibug_33')];
  return { x: eye.x, y: nose.y };
}
/** A box around a point of the screen, as parts of the stage. @param {number} half CSS px */
async function boxAround(page, { x, y }, half) {
  const { x: left, y: top, width, height } = await page.locator('canvas.view').boundingBox();
  return /** @type {[number, number, number, number]} */ ([(x - half - left) / width, (y - half - top) / height, (x + half - left) / width, (y + half - top) / height]);
}
/** How light a pixel of the stage is, 0 to 255. */
async function lightAt(page, shown, { x, y }) {
  const { x: left, y: top } = await page.locator('canvas.view').boundingBox();
  const o = 3 * (Math.round(y - top) * shown.width + Math.round(x - left));
  return 0.3 * shown.rgb[o] + 0.59 * shown.rgb[o + 1] + 0.11 * shown.rgb[o + 2];
}

describe('a mark', () => {
  test('is put where one clicks, seen there and nowhere else, undone, and there again when the page is', async () => {
    const { page, context, complaints } = await open(browser, site, { sharp: true });
    await choose(page);
    const before = await picture(page, 'marks-before');
    const there = await cheek(page);
    await putOn(page, 'Mole');
    await page.mouse.click(there.x, there.y);
    const [mole, ...others] = await marksOn(page);
    assert.deepEqual(others, []);
    assert.deepEqual({ ...mole, at: undefined }, { kind: 'mole', at: undefined, ...FIRST.mole });
    assert.equal(await page.getByRole('tab', { name: 'Looks' }).getAttribute('aria-selected'), 'true', 'a click on the face leads to its feature elsewhere');
    await moveSlider(page, 'Size of the mole', 8);
    const after = await picture(page, 'marks-mole');
    const around = await boxAround(page, there, 14);
    assert.ok(differing(before, after, around) > 40, `${differing(before, after, around)} pixels`);
    assert.equal(differing(before, after), differing(before, after, around), 'nothing else has changed');
    assert.ok((await lightAt(page, after, there)) < (await lightAt(page, before, there)) - 40);

    // On deep skin it is darker than that, too.
    await later(page);
    await moveSlider(page, 'Skin, fair to deep', 0.9);
    const deep = await picture(page, 'marks-deep');
    assert.ok((await lightAt(page, deep, there)) < 0.75 * (await lightAt(page, deep, { x: there.x, y: there.y + 16 })));
    await page.keyboard.press('Control+z');

    await page.keyboard.press('Control+z');
    assert.deepEqual((await marksOn(page)).map(({ size }) => size), [FIRST.mole.size]);
    await page.keyboard.press('Control+z');
    assert.deepEqual(await marksOn(page), []);
    assert.equal(differing(before, await picture(page, 'marks-undone')), 0);
    assert.ok(!(await page.evaluate(() => location.hash)), 'a link without marks is none');
    for (let i = 0; i < 2; i++) await page.keyboard.press('Control+Shift+z');
    assert.deepEqual((await marksOn(page))[0].at, mole.at);

    const hash = await page.evaluate(() => location.hash);
    assert.match(hash, /^#~~~[\w-]+$/);
    await page.reload();
    await page.waitForFunction(() => document.documentElement.dataset.ready === 'true');
    await page.evaluate(() => window.designer.refine(false));
    assert.deepEqual((await marksOn(page))[0], { ...mole, size: 8 });
    assert.equal(differing(after, await picture(page, 'marks-again')), 0);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('goes with the face, and into the mirror', async () => {
    const { page, context } = await open(browser, site);
    await choose(page);
    const at = await cheek(page);
    await putOn(page, 'Mole');
    await page.mouse.click(at.x, at.y);
    const pin = page.getByRole('slider', { name: 'Mole', exact: true });
    const left = async () => Number(await pin.getAttribute('aria-valuenow'));
    const before = await left();
    assert.ok(before > 20, `${before} mm to the subject's left`);
    await page.getByRole('tab', { name: 'Features' }).click();
    const flip = page.getByRole('button', { name: 'Mirror image' });
    await page.getByRole('button', { name: 'Person', exact: true }).click();
    await flip.click();
    await choose(page);
    assert.equal(await left(), -before);
    // A wider head has it farther from its middle.
    await page.getByRole('tab', { name: 'Lengths' }).click();
    await page.waitForFunction(() => !document.querySelector('.awaited'));
    await moveSlider(page, 'face width', 4);
    await choose(page);
    assert.ok((await left()) < -before, `${await left()} mm`);
    await context.close();
  });

  test('is put, moved, made larger and removed by keys, which tell where it is', async () => {
    const { page, context } = await open(browser, site);
    await choose(page);
    const start = page.getByRole('group', { name: 'Put on' }).getByRole('button', { name: 'Scar' });
    await start.focus();
    await page.keyboard.press('Enter');
    const aim = page.getByRole('slider', { name: /^Scar: (its place|where it ends)/ });
    assert.ok(await aim.evaluate((element) => element === document.activeElement));
    // Escape leaves.
    await page.keyboard.press('Escape');
    assert.ok(await start.evaluate((element) => element === document.activeElement && element.getAttribute('aria-pressed') === 'false'));
    await page.keyboard.press('Enter');
    const first = await aim.getAttribute('aria-valuetext');
    for (let i = 0; i < 3; i++) await page.keyboard.press('Shift+ArrowLeft');
    const second = await aim.getAttribute('aria-valuetext');
    assert.match(`${first}`, /^\S.* mm left of the middle, \d+ mm (above|below) the tip of the nose$/);
    assert.match(`${second}`, /, [1-9]\d* mm right of the middle, /);
    await page.keyboard.press('Enter');
    await page.getByText('Now click where it ends.').waitFor();
    assert.deepEqual(await marksOn(page), []);
    for (let i = 0; i < 3; i++) await page.keyboard.press('Shift+ArrowDown');
    await page.keyboard.press('Enter');
    const [scar] = await marksOn(page);
    assert.equal(scar.kind, 'scar');
    assert.notDeepEqual(scar.at, scar.to);

    // What was put has the focus.
    const pin = page.getByRole('slider', { name: 'Scar, where it begins' });
    assert.ok(await pin.evaluate((element) => element === document.activeElement));
    const [was] = [await pin.getAttribute('aria-valuetext')];
    await later(page);
    for (let i = 0; i < 2; i++) await page.keyboard.press('Shift+ArrowLeft');
    assert.notEqual(await pin.getAttribute('aria-valuetext'), was);
    assert.deepEqual((await marksOn(page))[0].to, scar.to, 'its other end stays');
    await later(page);
    await page.keyboard.press('+');
    assert.equal((await marksOn(page))[0].size, FIRST.scar.size + 0.1);
    await page.keyboard.press('Delete');
    assert.deepEqual(await marksOn(page), []);
    assert.ok(await start.evaluate((element) => element === document.activeElement), 'the focus is not lost');
    // Each of these is a step.
    for (const sizes of [[FIRST.scar.size + 0.1], [FIRST.scar.size], [FIRST.scar.size], []]) {
      await page.keyboard.press('Control+z');
      assert.deepEqual((await marksOn(page)).map(({ size }) => size), sizes);
    }
    await context.close();
  });

  test('is dragged to another place, which Escape takes back; a finger puts another', async () => {
    const { page, context } = await open(browser, site, { hasTouch: true });
    await choose(page);
    const there = await cheek(page);
    await putOn(page, 'Birthmark');
    await page.mouse.click(there.x, there.y);
    const [{ at }] = await marksOn(page);
    const drag = async () => {
      await page.mouse.move(there.x + 2, there.y + 1);
      await page.mouse.down();
      await page.mouse.move(there.x - 30, there.y + 1, { steps: 4 });
    };
    await drag();
    await page.keyboard.press('Escape');
    await page.mouse.up();
    assert.deepEqual((await marksOn(page))[0].at, at);
    const view = await page.evaluate(() => window.designer.onScreen('ibug_30'));
    await drag();
    await page.mouse.up();
    assert.notDeepEqual((await marksOn(page))[0].at, at);
    assert.deepEqual(await page.evaluate(() => window.designer.onScreen('ibug_30')), view, 'the head does not turn');
    await page.keyboard.press('Control+z');
    assert.deepEqual((await marksOn(page))[0].at, at);

    await putOn(page, 'Mole');
    const forehead = await landmarkOnScreen(page, 'metopion');
    await (await fingerOn(context, page))([forehead.x, forehead.y]);
    assert.deepEqual((await marksOn(page)).map(({ kind }) => kind), ['birthmark', 'mole']);
    // Beside the head there is none.
    await putOn(page, 'Mole');
    const box = await page.locator('canvas.view').boundingBox();
    await page.mouse.click(box.x + 30, box.y + box.height / 2);
    assert.match(`${await toast(page).textContent()}`, /no skin/);
    // The canvas has the focus now.
    await page.keyboard.press('Escape');
    await page.mouse.click(there.x, there.y - 60);
    assert.equal((await marksOn(page)).length, 2);
    await choose(page);
    await putOn(page, 'Mole');
    // Who goes elsewhere puts nothing any more, and clicks on features.
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.mouse.click(forehead.x, forehead.y);
    assert.equal((await marksOn(page)).length, 2);
    assert.equal(await page.locator('.pin').count(), 0);
    await context.close();
  });

  test('is one of a dozen at most; random looks leave them, the model’s own are without', async () => {
    const dozen = Array.from({ length: MOST }, (_, i) => ({ kind: /** @type {const} */ ('mole'), at: { triangle: 40 * i, b: 0, c: 0 }, ...FIRST.mole }));
    const { page, context } = await open(browser, site, { hash: `#~~~${encodeMarks(dozen)}` });
    await choose(page);
    assert.equal((await marksOn(page)).length, MOST);
    await putOn(page, 'Mole');
    assert.match(`${await toast(page).textContent()}`, /12 marks at most/);
    assert.equal(await page.locator('.pin-aim').isVisible(), false);
    const { marks, ...before } = await page.evaluate(() => window.designer.colouring);
    await page.getByRole('button', { name: 'Random looks' }).click();
    const { marks: left, ...after } = await page.evaluate(() => window.designer.colouring);
    assert.equal(left, marks);
    assert.notDeepEqual(after, before);
    await page.getByRole('button', { name: 'The model’s own' }).click();
    assert.deepEqual(await marksOn(page), []);
    // One that cannot be read is said, as colours are.
    await page.evaluate(() => (location.hash = '~~~AAAA'));
    await page.waitForFunction(() => document.querySelector('.toast')?.textContent?.includes('looks'));
    assert.deepEqual(await marksOn(page), []);
    await context.close();
  });
});

describe('a scar', () => {
  test('is bald, and a mark is taken along in a GLB', async () => {
    const { page, context } = await open(browser, site, { sharp: true, prepare: smallTextures, viewport: { width: 1200, height: 760 } });
    await choose(page);
    await moveSlider(page, 'Brows, thin to bushy', 0.7);
    await picture(page, 'marks-brows');
    const [above, right, left] = await Promise.all(['ibug_19', 'ibug_36', 'ibug_45'].map((name) => landmarkOnScreen(page, name)));
    // Hair grows below the landmark; outer corners of eyes are 90 mm from each other.
    const brow = { x: above.x, y: above.y + ((BELOW[2] + 1) * (left.x - right.x)) / 90 };
    const before = await picture(page, 'marks-brow');
    await putOn(page, 'Scar');
    // Twice in one place is no scar.
    for (const y of [-26, -26, 26]) await page.mouse.click(brow.x, brow.y + y);
    assert.equal((await marksOn(page)).length, 1);
    await moveSlider(page, 'Width of the scar', 3);
    const after = await picture(page, 'marks-scar');
    await pictureOfPage(page, 'marks-page');
    // Somewhere across the brow, as no scar is straight.
    const gap = async (shown) => {
      const columns = Array.from({ length: 13 }, (_, x) => Promise.all([-3, -2, -1, 0, 1, 2, 3].map((y) => lightAt(page, shown, { x: brow.x + x - 6, y: brow.y + y }))));
      return Math.max(...(await Promise.all(columns)).map((column) => Math.min(...column)));
    };
    assert.ok((await gap(after)) > (await gap(before)) + 30, `${await gap(before)} with hairs, ${await gap(after)} on the scar`);
    const around = await boxAround(page, brow, 45);
    assert.equal(differing(before, after), differing(before, after, around));

    await putOn(page, 'Birthmark');
    const there = await cheek(page);
    await page.mouse.click(there.x, there.y);
    const [, stain] = await marksOn(page);
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    const { bytes } = await download(page, 'GLB');
    assert.ok(glbJson(bytes).images.length > 1);
    const [{ uv, mirror }] = await page.evaluate(
      ({ triangle, b, c }) => {
        const { model } = window.designer;
        const weights = [1 - (b + c) / 255, b / 255, c / 255];
        const corners = [0, 1, 2].map((k) => model.triangles[3 * triangle + k]);
        const at = (of) => [0, 1].map((k) => of.reduce((sum, corner, i) => sum + weights[i] * (k ? 1 - model.uvs[2 * corner + 1] : model.uvs[2 * corner]), 0));
        // No seam is there: a vertex has one corner, of its own number.
        return [{ uv: at(corners), mirror: at(corners.map((corner) => model.mirror[model.uvVertices[corner]])) }];
      },
      stain.at,
    );
    const [[red, green], [skinRed, skinGreen]] = await readPicture(page, bytes, 'skin colour', [uv, mirror]);
    assert.ok(green / red < 0.8 * (skinGreen / skinRed), `${red}, ${green} on the stain, ${skinRed}, ${skinGreen} on the other cheek`);
    await context.close();
  });
});

test('an element shows the marks of a link, gives them back, and says what are none', async () => {
  const context = await browser.newContext({ viewport: { width: 500, height: 500 } });
  const page = await context.newPage();
  await page.goto(`${site.url}examples/plain/index.html`);
  const marks = encodeMarks([{ kind: 'birthmark', at: { triangle: 0, b: 0, c: 0 }, ...FIRST.birthmark, size: 100 }]);
  const found = await page.evaluate(async (marks) => {
    const element = /** @type {any} */ (document.querySelector('phiz-designer'));
    await customElements.whenDefined('phiz-designer');
    if (!element.model) await new Promise((done) => element.addEventListener('ready', done, { once: true }));
    const shot = async () => [...new Uint8Array(await (await element.toPng({ width: 400 })).arrayBuffer())];
    /** @type {string[]} */
    const errors = [];
    element.addEventListener('error', (event) => errors.push(event.detail.message) && event.preventDefault());
    const plain = await shot();
    element.colours = { skin: 0.3, marks };
    const marked = await shot();
    const given = element.colours;
    element.colours = { marks: 'none' };
    element.setAttribute('colours', `iris: 0.1, marks: ${marks}`);
    return { plain, marked, given, errors, spelled: element.colours };
  }, marks);
  assert.deepEqual(found.given, { marks });
  assert.deepEqual(found.spelled, { iris: 0.1, marks });
  assert.deepEqual(found.errors, ['the marks are what a link of the page has after its third tilde']);
  const [plain, marked] = [found.plain, found.marked].map((bytes) => decodePng(Buffer.from(bytes)));
  assert.ok(differing(plain, marked) > 100, `${differing(plain, marked)} pixels`);
  await context.close();
});
