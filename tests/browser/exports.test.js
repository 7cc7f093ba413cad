// What leaves the page: the dialog's downloads, as a person takes them.
import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { after, before, describe, test } from 'node:test';

import { glbJson, readPicture } from './glb.js';
import { SCREENSHOTS, decodePng, differing, download, launch, moveSlider, open, picture, serve, settled } from './site.js';

const validator = createRequire(new URL('../../www/package.json', import.meta.url))('gltf-validator');

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

  test('a GLB looks like the page: skin, eyes, teeth that open with the jaw, and nothing of the page changes', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    await page.getByRole('tab', { name: 'Colours' }).click();
    await moveSlider(page, 'Lips, pale to red', 1);
    await moveSlider(page, 'Iris, blue to brown', 0);
    await moveSlider(page, 'Cropped hair, none to dense', 0.9);
    const shown = await picture(page, 'exports-glb-before');
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    const { bytes } = await download(page, 'GLB');
    const { issues } = await validator.validateBytes(new Uint8Array(bytes));
    assert.deepEqual([issues.numErrors, issues.numWarnings], [0, 0], JSON.stringify(issues.messages));
    const json = glbJson(bytes);
    assert.deepEqual(json.nodes.map(({ name }) => name), ['face', 'upper teeth', 'lower teeth', 'lip shadow', 'lashes']);
    const [, upper, lower] = json.meshes;
    assert.equal(upper.extras, undefined, 'the upper row goes with the skull');
    assert.ok(lower.extras.targetNames.includes('jawOpen') && !lower.extras.targetNames.includes('eyeBlinkLeft'), lower.extras.targetNames.join());
    const jaw = json.accessors[lower.primitives[0].targets[lower.extras.targetNames.indexOf('jawOpen')].POSITION];
    assert.ok(jaw.min[1] < -0.01, `the lower teeth go down by ${jaw.min[1]} m`);
    // At the front of the mouth, behind the lips.
    const place = json.accessors[upper.primitives[0].attributes.POSITION];
    const lip = await page.evaluate(() => {
      const { model, face } = window.designer;
      const { stencil } = model.landmarks.find(({ name }) => name === 'ibug_62');
      return [0, 1, 2].map((k) => stencil.reduce((sum, [v, w]) => sum + (w * face.positions[3 * v + k]) / 1000, 0));
    });
    assert.ok(place.max[2] < lip[2] && place.max[2] > lip[2] - 0.02, `teeth to ${place.max[2]}, the lip at ${lip[2]}`);
    assert.ok(place.min[1] < lip[1] && place.max[1] > lip[1]);

    // Between lips at rest it is dark: the shadow lies before the teeth, and goes with the upper lip.
    const shadow = json.meshes[3];
    const there = json.accessors[shadow.primitives[0].attributes.POSITION];
    assert.ok(there.max[2] < lip[2] && there.max[2] > place.max[2] - 0.002, `${there.max[2]} between ${place.max[2]} and ${lip[2]}`);
    assert.ok(shadow.extras.targetNames.includes('mouthUpperUpLeft'));

    // Lashes stand before the eyes and go down with the lids; the jaw leaves them alone.
    const fringe = json.meshes[4];
    const blink = json.accessors[fringe.primitives[0].targets[fringe.extras.targetNames.indexOf('eyeBlinkLeft')].POSITION];
    assert.ok(blink.min[1] < -0.004 && blink.max[1] < 0.003, `a blink moves lashes by ${blink.min[1]} to ${blink.max[1]} m`);
    assert.ok(!fringe.extras.targetNames.includes('jawOpen'), fringe.extras.targetNames.join());
    const eyes = await page.evaluate(() => {
      const { model, face } = window.designer;
      return [36, 45].map((i) => {
        const { stencil } = model.landmarks.find(({ name }) => name === `ibug_${i}`);
        return [0, 1, 2].map((k) => stencil.reduce((sum, [v, w]) => sum + (w * face.positions[3 * v + k]) / 1000, 0));
      });
    });
    const { min, max } = json.accessors[fringe.primitives[0].attributes.POSITION];
    assert.ok(Math.abs(min[0] - eyes[0][0]) < 0.008 && Math.abs(max[0] - eyes[1][0]) < 0.008, `lashes from ${min[0]} to ${max[0]}, eyes ${eyes.map(([x]) => x)}`);
    assert.ok(max[2] > eyes[0][2] && max[2] < eyes[0][2] + 0.03, `lashes to ${max[2]}, outer corners at ${eyes[0][2]}`);

    // The pictures, where features are.
    const read = (name, points) => readPicture(page, bytes, name, points);
    const [nose, mouth, bare, crown, brow] = await read('skin colour', ['ibug_30', 'ibug_57 ibug_66', [0.3, 0.5], 'vertex', 'metopion']);
    assert.ok(nose[0] > nose[1] && nose[1] > nose[2] && nose[0] > 150, `the nose is ${nose}`);
    assert.ok(mouth[1] < 0.75 * nose[1] && mouth[0] > 1.6 * mouth[1], `red lips are ${mouth}, the nose ${nose}`);
    assert.ok(crown[0] < 0.5 * brow[0] && brow[0] > 150, `cropped hair is ${crown}, the forehead ${brow}`);
    assert.ok(bare.every((value, k) => Math.abs(value - nose[k]) < 60), 'what is not skin has its colour, for pictures that are shrunk');
    const [pupil, iris, white] = await read('eyes', [[0.5, 0.5], [0.5 + 0.09, 0.5], [0.5 + 0.24, 0.5]]);
    assert.ok(Math.max(...pupil) < 40, `the pupil is ${pupil}`);
    assert.ok(iris[2] > iris[0] + 8, `a blue iris is ${iris}`);
    assert.ok(Math.min(...white) > 130, `the white is ${white}`);
    const [flat] = await read('skin normal', [[0.3, 0.5]]);
    assert.ok(Math.abs(flat[0] - 128) < 3 && flat[2] > 250, `no skin, no relief: ${flat}`);
    const slopes = await read('skin normal', Array.from({ length: 400 }, (_, i) => [0.7 + 0.0005 * (i % 20), 0.4 + 0.0005 * Math.floor(i / 20)]));
    const relief = slopes.map(([x]) => Math.abs(x - 128)).sort((a, b) => a - b)[200];
    assert.ok(relief >= 1 && relief < 40, `pores lean by ${relief} of 127`);
    const [open0] = await read('skin surface', ['ibug_30']);
    assert.ok(open0[0] > 200 && open0[1] > 60 && open0[1] < 190 && open0[2] < 8, `the nose’s surface: ${open0}`);

    await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
    await page.mouse.move(300, 20);
    assert.equal(differing(shown, await picture(page, 'exports-glb-after')), 0);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('the PNG has the size that was asked for, and leaves the page as it was', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
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
