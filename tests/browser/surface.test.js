// The face itself is a way in: hover, click, drag its surface.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { differing, fingerOn, landmarkOnScreen, open, picture, pictureOfPage, settled, siteAndBrowser, TALL } from './site.js';

const { browser, site } = await siteAndBrowser();

const codeOf = (/** @type {import('playwright-core').Page} */ page) => page.evaluate(() => window.designer.face.code);

/** Where landmarks are on the face at hand, mm. @param {import('playwright-core').Page} page @param {string[]} names */
const places = (page, names) =>
  page.evaluate((wanted) => {
    const { model, face } = window.designer;
    const positions = face.positions.slice();
    return wanted.map((name) => {
      const at = [0, 0, 0];
      for (const [vertex, weight] of model.landmarks.find((landmark) => landmark.name === name).stencil) {
        for (let k = 0; k < 3; k++) at[k] += weight * positions[3 * vertex + k];
      }
      return at;
    });
  }, names);

/** @param {import('playwright-core').Page} page @param {{ x: number, y: number }} from @param {number} dx @param {number} dy */
async function drag(page, from, dx, dy) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= 8; i++) {
    await page.mouse.move(from.x + (dx * i) / 8, from.y + (dy * i) / 8);
    await page.waitForTimeout(30);
  }
}

describe('the surface', () => {
  test('of what was clicked follows the pointer, on both sides, as one step', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true, viewport: TALL });
    const median = await codeOf(page);
    const corner = await landmarkOnScreen(page, 'ibug_54');
    const away = { x: corner.x - 8, y: corner.y };

    // Nothing is selected yet: the same gesture turns the head.
    await drag(page, away, 40, 0);
    await page.mouse.up();
    assert.equal(await codeOf(page), median);
    await page.getByRole('button', { name: 'Front' }).click();
    await settled(page);

    await page.mouse.move(away.x, away.y);
    await settled(page);
    const idle = await page.evaluate(() => document.querySelector('canvas.view').style.cursor);
    assert.equal(idle, 'pointer');
    await page.mouse.click(away.x, away.y);
    assert.equal(await page.locator('.tab[aria-pressed=true]').getAttribute('data-group'), 'mouth');
    await page.getByText('Drag the mouth: what is not locked follows').waitFor();
    await page.mouse.move(away.x + 1, away.y);
    await settled(page);
    assert.equal(await page.evaluate(() => document.querySelector('canvas.view').style.cursor), 'move');
    const before = await picture(page, 'surface-before');
    const rest = await places(page, ['ibug_54', 'ibug_48', 'ibug_27']);

    // Eight events, and the face at each of them: it follows, it does not jump at the end.
    /** @type {number[]} */
    const widths = [];
    await page.mouse.move(away.x, away.y);
    await page.mouse.down();
    for (let i = 1; i <= 6; i++) {
      await page.mouse.move(away.x + 3 * i, away.y - 2 * i);
      await settled(page);
      widths.push(await page.evaluate(() => window.designer.face.measure('mouth width')));
    }
    for (let i = 2; i < widths.length; i++) assert.ok(widths[i] > widths[i - 1] + 0.2, widths.map((mm) => mm.toFixed(2)).join());
    // What is held stays under the pointer.
    const marks = await page.locator('.grip:visible').count();
    assert.equal(marks, 2, 'the point and its mirror image are marked');
    const held = await page.locator('.grip').first().boundingBox();
    assert.ok(held);
    assert.ok(Math.hypot(held.x + 6 - away.x - 18, held.y + 6 - away.y + 12) < 4, `${held.x + 6 - away.x}, ${held.y + 6 - away.y}`);
    await pictureOfPage(page, 'surface-held');
    await page.mouse.up();
    assert.equal(await page.locator('.grip:visible').count(), 0);

    const [left, right, bridge] = await places(page, ['ibug_54', 'ibug_48', 'ibug_27']);
    const moved = [0, 1, 2].map((k) => left[k] - rest[0][k]);
    assert.ok(moved[0] > 1 && moved[1] > 0.5, `${moved}`);
    const mirrored = [0, 1, 2].map((k) => right[k] - rest[1][k]);
    // The landmark is beside the point that is held, and people are not symmetric.
    assert.ok(Math.hypot(mirrored[0] + moved[0], mirrored[1] - moved[1], mirrored[2] - moved[2]) < 0.2 * Math.hypot(...moved), `${moved}; ${mirrored}`);
    assert.ok(Math.hypot(...bridge.map((x, k) => x - rest[2][k])) < Math.hypot(...moved), 'the bridge of the nose moved less');
    const after = await picture(page, 'surface-after');
    assert.ok(differing(before, after) > 300);
    assert.equal(differing(before, after, [0, 0, 0.1, 0.1]), 0, 'the camera stayed');

    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await codeOf(page), median, 'one gesture, one step');
    assert.ok(await page.getByRole('button', { name: 'Undo', exact: true }).isDisabled());

    // One side alone.
    await page.keyboard.down('Alt');
    await drag(page, away, 16, -12);
    await page.mouse.up();
    await page.keyboard.up('Alt');
    const [alone, other] = await places(page, ['ibug_54', 'ibug_48']);
    const [one, two] = [Math.hypot(...alone.map((x, k) => x - rest[0][k])), Math.hypot(...other.map((x, k) => x - rest[1][k]))];
    assert.ok(one > 1 && Math.abs(alone[0] - rest[0][0] + (other[0] - rest[1][0])) > 0.3, `${one}, ${two}`);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();

    // Beside what is selected the head turns, and Escape ends it.
    const brow = await landmarkOnScreen(page, 'ibug_27');
    await drag(page, { x: brow.x, y: brow.y - 60 }, 50, 0);
    await page.mouse.up();
    assert.equal(await codeOf(page), median);
    await page.getByRole('button', { name: 'Front' }).click();
    await settled(page);
    await page.locator('canvas.view').focus();
    await page.keyboard.press('Escape');
    await drag(page, away, 20, 0);
    await page.mouse.up();
    assert.equal(await codeOf(page), median, 'nothing is selected any more');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('of a locked feature stays', async () => {
    const { context, page } = await open(browser, site);
    const tip = await landmarkOnScreen(page, 'ibug_30');
    await page.mouse.click(tip.x, tip.y);
    await page.getByRole('button', { name: 'Lock the nose' }).click();
    const nose = () =>
      page.evaluate(() => {
        const { model, face } = window.designer;
        return model.controls.filter((c) => c.group === 'nose' && !c.measure).map((c) => face.get(c.name));
      });
    const before = await nose();
    await drag(page, tip, 0, 14);
    await page.mouse.up();
    assert.deepEqual(await nose(), before);

    // What is open in the panel is what is dragged; the whole person is no feature, and another section none of features.
    const hint = () => page.locator('.hint').textContent();
    const shapes = () => page.locator('.stage').evaluate((stage) => stage.classList.contains('is-shaping'));
    await page.locator('.tab[data-group="mouth"]').click();
    assert.match((await hint()) ?? '', /^Drag the mouth: what is not locked follows/);
    const code = await codeOf(page);
    await drag(page, await landmarkOnScreen(page, 'ibug_54'), 8, 0);
    await page.mouse.up();
    assert.notEqual(await codeOf(page), code);
    for (const leave of [page.getByRole('button', { name: 'Person', exact: true }), page.getByRole('tab', { name: 'Looks' })]) {
      await page.mouse.click(tip.x, tip.y);
      assert.match((await hint()) ?? '', /^Drag the nose: what is not locked follows/);
      await leave.click();
      assert.equal(await hint(), 'Click a feature to shape it');
      assert.equal(await shapes(), false);
    }
    // To open one is not to select one.
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.locator('.tab[data-group="mouth"]').click();
    assert.equal(await shapes(), false);
    await context.close();
  });

  test('follows a finger on a phone', async () => {
    const { context, page, complaints } = await open(browser, site, {
      sharp: true,
      viewport: { width: 320, height: 640 },
      hasTouch: true,
      isMobile: true,
      colorScheme: 'dark',
    });
    const median = await codeOf(page);
    const finger = await fingerOn(context, page);
    const tip = await landmarkOnScreen(page, 'ibug_30');
    await finger([tip.x, tip.y], [tip.x + 60, tip.y]);
    assert.equal(await codeOf(page), median, 'unselected, the head turns');
    await page.getByRole('button', { name: 'Front' }).click();
    await settled(page);
    const before = await picture(page, 'surface-phone-before');
    await page.touchscreen.tap(tip.x, tip.y);
    assert.equal(await page.locator('.tab[aria-pressed=true]').getAttribute('data-group'), 'nose');
    // Below what lies over the stage.
    const head = /** @type {[number, number, number, number]} */ ([0, 0.2, 1, 1]);
    assert.ok(differing(before, await picture(page, 'surface-phone-picked'), head) > 60, 'what was tapped glows');
    await page.waitForTimeout(1250);
    assert.equal(differing(before, await picture(page, 'surface-phone-selected'), head), 0, 'and then leaves its skin as it is');
    const [rest] = await places(page, ['ibug_30']);
    await finger([tip.x, tip.y], [tip.x, tip.y - 14]);
    assert.notEqual(await codeOf(page), median);
    const [moved] = await places(page, ['ibug_30']);
    assert.ok(moved[1] > rest[1] + 1.5, `${moved[1] - rest[1]} mm`);
    assert.ok(Math.abs(moved[0] - rest[0]) < 0.5, 'and straight');
    assert.ok(differing(before, await picture(page, 'surface-phone-after')) > 60);
    await pictureOfPage(page, 'surface-phone-page');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await codeOf(page), median);

    // Two fingers on it come closer, and shape nothing.
    const eyes = async () => (await landmarkOnScreen(page, 'ibug_45')).x - (await landmarkOnScreen(page, 'ibug_36')).x;
    const far = await eyes();
    const session = await context.newCDPSession(page);
    const touch = (/** @type {string} */ type, /** @type {number[]} */ ...along) =>
      session.send('Input.dispatchTouchEvent', { type, touchPoints: along.map((x, id) => ({ x: tip.x + x, y: tip.y, id })) });
    await touch('touchStart', -8);
    await touch('touchStart', -8, 8);
    for (let reach = 10; reach <= 24; reach += 2) await touch('touchMove', -reach, reach);
    await touch('touchEnd');
    await settled(page);
    assert.equal(await codeOf(page), median, 'a pinch shapes the face');
    assert.ok((await eyes()) > 1.5 * far, 'a pinch on what is selected comes no closer');
    assert.deepEqual(complaints, []);
    await context.close();
  });
});
