// What leaves the page: the dialog's downloads, as a person takes them.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, before, describe, test } from 'node:test';

import { SCREENSHOTS, decodePng, differing, launch, open, picture, serve, settled } from './site.js';

/** @type {Awaited<ReturnType<typeof serve>>} */
let site;
/** @type {import('playwright-core').Browser} */
let browser;
before(async () => {
  site = await serve();
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await site?.close();
});

/** @param {import('playwright-core').Page} page @param {string} button */
async function download(page, button) {
  const [file] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('dialog').getByRole('button', { name: button, exact: true }).click(),
  ]);
  return { name: file.suggestedFilename(), bytes: await readFile(await file.path()) };
}

/** @param {import('playwright-core').Page} page @param {number} width @param {number} height */
async function ask(page, width, height) {
  const dialog = page.getByRole('dialog');
  await dialog.getByLabel('Width in pixels').fill(String(width));
  await dialog.getByLabel('Height in pixels').fill(String(height));
}

describe('exports', () => {
  for (const [device, options] of /** @type {const} */ ([
    ['desktop', {}],
    ['phone', { viewport: { width: 390, height: 844 }, hasTouch: true }],
  ])) {
    test(`the four mesh formats, on a ${device}`, async () => {
      const { context, page, complaints } = await open(browser, site, options);
      await page.getByRole('button', { name: 'Take the face with you' }).click();
      const starts = { GLB: 'glTF', OBJ: '# ', PLY: 'ply\n', STL: 'phiz: a face' };
      for (const [format, start] of Object.entries(starts)) {
        const { name, bytes } = await download(page, format);
        assert.equal(name, `face.${format.toLowerCase()}`);
        assert.equal(bytes.toString('latin1', 0, start.length), start);
        assert.ok(bytes.length > 500_000, `${format}: ${bytes.length} bytes`);
        await page.getByText(`${name} is written`).waitFor();
      }
      await page.screenshot({ path: `${SCREENSHOTS}/exports-${device}.png` });
      assert.deepEqual(complaints, []);
      await context.close();
    });
  }

  test('the PNG has the size that was asked for, and leaves the page as it was', async () => {
    const { context, page, complaints } = await open(browser, site);
    const shown = await picture(page, 'exports-before');
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    await ask(page, 500, 640);
    const { name, bytes } = await download(page, 'PNG');
    assert.equal(name, 'face.png');
    const { width, height, rgb, alpha } = decodePng(bytes);
    assert.deepEqual([width, height], [500, 640]);
    assert.ok(!alpha || alpha.every((a) => a === 255), 'the wall is behind the head');
    assert.ok(new Set(rgb).size > 100, 'it is a picture');
    await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
    // Off everything that lights a feature up.
    await page.mouse.move(300, 20);
    await settled(page);
    const again = await picture(page, 'exports-after');
    assert.equal(differing(shown, again), 0);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('a transparent PNG is the head alone, with soft edges at the neck', async () => {
    const { context, page, complaints } = await open(browser, site);
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    await ask(page, 480, 600);
    await page.getByRole('dialog').getByLabel('Transparent behind the head').check();
    const { bytes } = await download(page, 'PNG');
    const { width, height, alpha } = decodePng(bytes);
    assert.ok(alpha);
    const at = (/** @type {number} */ x, /** @type {number} */ y) => alpha[Math.floor(y * height) * width + Math.floor(x * width)];
    assert.equal(at(0.02, 0.02), 0);
    assert.equal(at(0.98, 0.02), 0);
    assert.equal(at(0.5, 0.999), 0, 'the neck has ended');
    assert.equal(at(0.5, 0.5), 255, 'the face is there');
    const soft = alpha.filter((a) => a > 20 && a < 235).length / alpha.length;
    // The neck's fade alone is some percent of the picture; edges are far less.
    assert.ok(soft > 0.01 && soft < 0.2, `${soft}`);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('a size that the graphics card does not have is said, and the page goes on', async () => {
    const { context, page } = await open(browser, site);
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    const most = await page.evaluate(() => {
      const gl = document.createElement('canvas').getContext('webgl2');
      return gl?.getParameter(gl.MAX_RENDERBUFFER_SIZE);
    });
    const dialog = page.getByRole('dialog');
    await ask(page, 5, 600);
    await dialog.getByRole('button', { name: 'PNG', exact: true }).click();
    assert.equal(await dialog.getByLabel('Width in pixels').evaluate((input) => input.validity.rangeUnderflow), true);
    // Past the form's own limit, as a browser that ignores it would.
    await dialog.getByLabel('Width in pixels').evaluate((input, value) => {
      input.removeAttribute('max');
      input.value = String(value);
    }, most + 1);
    await dialog.getByRole('button', { name: 'PNG', exact: true }).click();
    await page.getByText(`16 to ${most} pixels a side`).waitFor();
    await ask(page, 64, 64);
    assert.equal(decodePng((await download(page, 'PNG')).bytes).width, 64);
    await context.close();
  });
});
