// What leaves the page: the dialog's downloads, as a person takes them.
import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { describe, test } from 'node:test';

import { glbJson, readPicture, readVectors } from './glb.js';
import { decodePng, differing, download, moveSlider, onePage, open, picture, SCREENSHOTS, settled, siteAndBrowser, smallTextures } from './site.js';

const validator = createRequire(new URL('../../www/package.json', import.meta.url))('gltf-validator');

const { browser, site } = await siteAndBrowser();

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
      const { context, page, complaints } = await open(browser, site, { ...options, prepare: smallTextures });
      // Somebody who makes a face, which all of them show.
      await page.getByRole('button', { name: 'Random face', exact: true }).click();
      await page.getByRole('tab', { name: 'Expressions' }).click();
      await moveSlider(page, 'Open jawOpen', 0.37);
      const [x, y, z] = await page.evaluate(() => Array.from(window.designer.face.positions.slice(0, 3)));
      await page.getByRole('button', { name: 'Take the face with you' }).click();
      const starts = { GLB: 'glTF', OBJ: '# ', PLY: 'ply\n', STL: 'phiz: a face' };
      for (const [format, start] of Object.entries(starts)) {
        const { name, bytes } = await download(page, format);
        assert.equal(name, `face.${format.toLowerCase()}`);
        assert.equal(bytes.toString('latin1', 0, start.length), start);
        assert.ok(bytes.length > 500_000, `${format}: ${bytes.length} bytes`);
        await page.getByText(`Saved ${name}`).waitFor();
        if (format === 'OBJ') assert.ok(bytes.toString().includes(`v ${x.toFixed(4)} ${y.toFixed(4)} ${z.toFixed(4)} `));
        if (format === 'GLB') {
          const { weights, extras } = glbJson(bytes).meshes[0];
          assert.equal(weights[extras.targetNames.indexOf('jawOpen')].toFixed(2), '0.37');
          const shapeKeys = page.getByRole('checkbox', { name: /^With a named shape key/ });
          await shapeKeys.uncheck();
          const plain = (await download(page, format)).bytes;
          assert.ok(plain.length < 0.3 * bytes.length && glbJson(plain).meshes.every(({ weights }) => !weights), `${plain.length} of ${bytes.length} bytes`);
          await shapeKeys.check();
        }
      }
      assert.deepEqual(complaints, []);
      await context.close();
    });
  }

});

describe('taking a face along as a PNG', () => {
  const visit = onePage(browser, site, { drawn: true, prepare: smallTextures });

  test('a size that the graphics card does not have is said, and the page goes on', async () => {
    const { page } = visit;
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
    await dialog.getByRole('button', { name: 'Close' }).click();
  });

  test('a transparent PNG is the head alone, with soft edges at the neck', async () => {
    const { page } = visit;
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

    // From below, there is hair behind the neck that has ended.
    await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
    await page.getByRole('tab', { name: 'Looks' }).click();
    await moveSlider(page, 'Length, cropped to below the chin', 1);
    await page.locator('.view').focus();
    for (let i = 0; i < 4; i++) await page.keyboard.press('ArrowDown');
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    const png = (await download(page, 'PNG')).bytes;
    await writeFile(`${SCREENSHOTS}/exports-neck.png`, png);
    const long = decodePng(png);
    let [hair, all] = [0, 0];
    for (let y = 482; y < 494; y++) {
      for (let x = 200; x < 280; x++, all++) if (long.alpha?.[y * width + x] === 255 && long.rgb[3 * (y * width + x)] < 120) hair++;
    }
    assert.ok(hair > 0.5 * all, `where the neck ends it hides the hair behind it: ${hair} of ${all} pixels are hair`);

    // A graphics card that is lost leaves an empty picture, which is not kept.
    const card = await page.evaluateHandle(() => /** @type {HTMLCanvasElement} */ (document.querySelector('canvas.view')).getContext('webgl2')?.getExtension('WEBGL_lose_context'));
    await card.evaluate((card) => card.loseContext());
    for (const format of ['PNG', 'GLB']) {
      await page.getByRole('dialog').getByRole('button', { name: format, exact: true }).click();
      await page.getByRole('dialog').getByText('the graphics card is not available at the moment').waitFor();
    }
    // In the middle of a file, too.
    await card.evaluate((card) => card.restoreContext());
    await page.waitForFunction(() => !document.querySelector('canvas.view').getContext('webgl2').isContextLost());
    await page.evaluate(() => {
      const { prototype } = WebGL2RenderingContext;
      const { readPixels } = prototype;
      prototype.readPixels = function (...asked) {
        prototype.readPixels = readPixels;
        this.getExtension('WEBGL_lose_context').loseContext();
        readPixels.apply(this, asked);
      };
    });
    await page.getByRole('dialog').getByRole('button', { name: 'GLB', exact: true }).click();
    await page.getByRole('dialog').getByText('the graphics card is not available at the moment').waitFor();
    await card.evaluate((card) => card.restoreContext());
    await page.waitForFunction(() => !document.querySelector('canvas.view').getContext('webgl2').isContextLost());
    const whole = decodePng((await download(page, 'PNG')).bytes);
    const filled = (/** @type {typeof whole} */ { alpha }) => alpha?.filter((a) => a === 255).length ?? 0;
    assert.ok(filled(whole) > 0.9 * filled(long), `${filled(whole)} of ${filled(long)} pixels are the head's`);
    assert.deepEqual(visit.complaints, []);
  });
});

describe('what is taken along leaves the page as it was', () => {
  const visit = onePage(browser, site, { sharp: true, drawn: true });

  test('the PNG has the size that was asked for, and leaves the page as it was', async () => {
    const { page } = visit;
    const shown = await picture(page, 'exports-before');
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    await ask(page, 500, 640);
    // Who marks a number, and lets go beside the page, is not done with it; a click there closes it.
    const [field, screen] = [await page.getByLabel('Width in pixels').boundingBox(), page.viewportSize()];
    assert.ok(field && screen);
    await page.mouse.move(field.x + field.width / 2, field.y + field.height / 2);
    await page.mouse.down();
    await page.mouse.move(5, screen.height - 5, { steps: 3 });
    await page.mouse.up();
    assert.ok(await page.getByRole('dialog').isVisible(), 'the page over the page is gone');
    await page.mouse.click(5, screen.height - 5);
    assert.ok(await page.getByRole('dialog').isHidden());
    await page.getByRole('button', { name: 'Take the face with you' }).click();
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
    assert.deepEqual(visit.complaints, []);
  });

  test('a PNG of two faces has the line, and one of a distance its colours; both say whose in their names', async () => {
    const { page } = visit;
    /** How much of a box (parts of the picture) is of a colour, or near it. */
    const share = ({ width, height, rgb }, [left, top, right, bottom], colour, near = 12) => {
      let [of, all] = [0, 0];
      for (let y = Math.floor(top * height); y < bottom * height; y++) {
        for (let x = Math.floor(left * width); x < right * width; x++, all++) {
          const o = 3 * (y * width + x);
          if (colour.every((c, k) => Math.abs(rgb[o + k] - c) < near)) of++;
        }
      }
      return of / all;
    };
    const take = async () => {
      await page.getByRole('button', { name: 'Take the face with you' }).click();
      await ask(page, 240, 320);
      const { name, bytes } = await download(page, 'PNG');
      await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
      return { name, bytes, ...decodePng(bytes) };
    };
    const [white, yellow] = [[255, 255, 255], [253, 231, 37]];
    const [line, bar, sheet] = [[119 / 240, 0.1, 121 / 240, 1], [0.68, 0.03, 0.74, 0.1], [0.8, 0.08, 0.97, 0.15]];
    const plain = await take();
    assert.ok(share(plain, line, white) < 0.1);
    await page.getByRole('tab', { name: 'Compare' }).click();
    await page.getByLabel('Compare with').selectOption({ label: 'Preset 5' });
    await page.getByLabel('Split by a line you drag').check();
    const split = await take();
    assert.equal(split.name, 'face-vs-preset-5.png');
    await writeFile(`${SCREENSHOTS}/exports-split.png`, split.bytes);
    assert.ok(share(split, line, white) > 0.95, 'no line between the two');
    assert.ok(share(split, [0.37, 0.012, 0.47, 0.036], white) > 0.4, 'no name beside it');
    assert.equal(share(split, bar, yellow, 40), 0);
    // The line is where it is on the stage, which has another shape: so far from the middle, in heights.
    const divider = page.getByRole('slider', { name: 'Line between the two faces' });
    await divider.focus();
    for (let n = 0; n < 5; n++) await page.keyboard.press('ArrowLeft');
    const [stage, at] = [await page.locator('.stage').boundingBox(), await divider.boundingBox()];
    assert.ok(stage && at);
    const x = Math.round(120 + (320 * (at.x + at.width / 2 - stage.x - stage.width / 2)) / stage.height);
    assert.ok(x < 92, `as far from the middle in widths it were at 96, not ${x}`);
    const aside = await take();
    assert.ok(share(aside, [(x - 0.9) / 240, 0.1, (x + 0.9) / 240, 1], white) > 0.95, `no line at ${x}`);
    assert.equal(differing(plain, aside, [(x + 3) / 240, 0.1, 1, 1]), 0, 'right of it is this face');
    assert.ok(differing(split, aside, [(x + 3) / 240, 0.1, 0.48, 1]) > 100, 'and was not');
    await page.getByLabel('Split by a line you drag').uncheck();
    await page.getByLabel('Distance as colour').check();
    const heat = await take();
    assert.equal(heat.name, 'face-vs-preset-5.png');
    await writeFile(`${SCREENSHOTS}/exports-heat.png`, heat.bytes);
    assert.ok(share(heat, bar, yellow, 40) > 0.003 && share(heat, sheet, white) > 0.9, 'no scale');
    await page.getByLabel('Distance as colour').uncheck();
    const again = await take();
    assert.equal(again.name, 'face.png');
    assert.equal(differing(plain, again), 0, 'a plain picture has neither');
    await page.getByRole('tab', { name: 'Features' }).click();
    assert.deepEqual(visit.complaints, []);
  });

  test('a PLY and an OBJ have the colours of the page, a vertex', async () => {
    const { page } = visit;
    // A vertex of each.
    const places = await page.evaluate(() => {
      const { model, face } = window.designer;
      const nearest = (/** @type {string} */ name) => model.landmarks.find((one) => one.name === name).stencil.reduce((a, b) => (b[1] > a[1] ? b : a))[0];
      const rest = face.positions.slice();
      const eye = model.parts.find(({ name }) => /eyeball/.test(name));
      const ball = [...model.triangles.subarray(3 * eye.first, 3 * (eye.first + eye.count))].map((corner) => model.uvVertices[corner]);
      const pupil = ball.reduce((a, b) => (rest[3 * b + 2] > rest[3 * a + 2] ? b : a));
      return { cheek: nearest('ibug_31'), lip: nearest('ibug_62'), pupil };
    });
    const read = async () => {
      await page.getByRole('button', { name: 'Take the face with you' }).click();
      const { bytes } = await download(page, 'PLY');
      const { bytes: obj } = await download(page, 'OBJ');
      await page.keyboard.press('Escape');
      const start = bytes.indexOf('end_header\n') + 11;
      const lines = obj.toString().split('\n').filter((line) => line.startsWith('v '));
      return Object.fromEntries(
        Object.entries(places).map(([name, v]) => {
          const colour = [...bytes.subarray(start + 27 * v + 24, start + 27 * v + 27)];
          assert.deepEqual(lines[v].split(' ').slice(4).map((part) => Math.round(255 * Number(part))), colour);
          return [name, colour];
        }),
      );
    };
    const plain = await read();
    assert.ok(plain.cheek[0] > 150 && plain.cheek[0] > plain.cheek[2] + 20, `the cheek is ${plain.cheek}`);
    assert.ok(plain.lip[1] < plain.cheek[1] - 30, `the lip is ${plain.lip}`);
    assert.ok(Math.max(...plain.pupil) < 90, `the pupil is ${plain.pupil}`);
    await page.getByRole('tab', { name: 'Looks' }).click();
    await page.getByRole('slider', { name: 'Skin, fair to deep' }).press('End');
    const deep = await read();
    assert.ok(deep.cheek[0] < plain.cheek[0] - 60 && deep.cheek[2] < plain.cheek[2] - 60, `the cheek is ${deep.cheek}, it was ${plain.cheek}`);
    assert.ok(deep.lip[0] < plain.lip[0] - 40, `the lip is ${deep.lip}`);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(await read(), plain);
    assert.deepEqual(visit.complaints, []);
  });

  test('a GLB looks like the page: skin, eyes, teeth that open with the jaw, and nothing of the page changes', async () => {
    const { page } = visit;
    // Lips that are open at rest, by 2 mm: what is between them follows lips, and not all that a face does.
    await page.getByRole('tab', { name: 'Lengths' }).click();
    await moveSlider(page, 'mouth vertical position', 0.01);
    await page.getByRole('tab', { name: 'Looks' }).click();
    await moveSlider(page, 'Lips, pale to red', 1);
    await moveSlider(page, 'Iris, blue to brown', 0);
    await moveSlider(page, 'Length, cropped to below the chin', 0.4);
    await moveSlider(page, 'Beard, short to long', 0.3);
    await page.getByRole('button', { name: 'Half-rim', exact: true }).click();
    // What the stage hides is the face's, and the file's.
    await page.getByRole('button', { name: 'Hide hair and glasses' }).click();
    const shown = await picture(page, 'exports-glb-before');
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    const { bytes } = await download(page, 'GLB');
    const { issues } = await validator.validateBytes(new Uint8Array(bytes));
    assert.deepEqual([issues.numErrors, issues.numWarnings], [0, 0], JSON.stringify(issues.messages));
    const json = glbJson(bytes);
    assert.deepEqual(json.nodes.map(({ name }) => name), ['face', 'upper teeth', 'lower teeth', 'lip shadow', 'lashes', 'hair', 'beard', 'glasses frame', 'glasses metal', 'glasses pads', 'lenses']);
    const [, upper, lower] = json.meshes;
    const controls = await page.evaluate(() => window.designer.face.controls.map(({ name }) => name));
    assert.deepEqual(upper.extras.targetNames.filter((name) => !controls.includes(name)), [], 'no expression moves the upper row: it goes with the skull');
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
    assert.ok(shadow.extras.targetNames.includes('mouthUpperUpLeft') && !shadow.extras.targetNames.includes('eyeBlinkLeft'), shadow.extras.targetNames.join());

    // Glasses go with the head, and stay when it says something. One sees through them.
    for (const mesh of json.meshes.slice(7)) {
      const { targetNames } = mesh.extras;
      assert.ok(targetNames.includes('head 1') && targetNames.includes('nose 1'), `${mesh.name}: ${targetNames}`);
      assert.ok(!targetNames.includes('jawOpen') && !targetNames.includes('mouthSmileLeft') && !targetNames.includes('eyeBlinkLeft'), `${mesh.name}: ${targetNames}`);
    }
    const { alphaMode, pbrMetallicRoughness } = json.materials[json.meshes[10].primitives[0].material];
    assert.equal(alphaMode, 'BLEND');
    assert.ok(pbrMetallicRoughness.baseColorFactor[3] < 0.2);
    const glass = json.accessors[json.meshes[10].primitives[0].attributes.POSITION];
    assert.ok(glass.min[2] > lip[2] - 0.01 && glass.max[0] > 0.05 && glass.min[0] < -0.05, `lenses from ${glass.min} to ${glass.max}`);

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

    // Sliders take along what stands in the face: roots of lashes go as far as the lid beneath, teeth as far as the lips.
    const [face] = json.meshes;
    const skinOf = face.primitives[0];
    const rest = readVectors(bytes, skinOf.attributes.POSITION);
    /** @param {any} mesh @param {string} name @returns {Float32Array | null} */
    const target = (mesh, name) => {
      const index = mesh.extras.targetNames.indexOf(name);
      return index < 0 ? null : readVectors(bytes, mesh.primitives[0].targets[index].POSITION);
    };
    const hairs = readVectors(bytes, fringe.primitives[0].attributes.POSITION);
    // A lash is three rings of three and a tip; the middle of its first one is on the lid. Every seventh is enough.
    const middle = (/** @type {Float32Array} */ values, /** @type {number} */ lash) => [0, 1, 2].map((k) => (values[30 * lash + k] + values[30 * lash + 3 + k] + values[30 * lash + 6 + k]) / 3);
    const roots = Array.from({ length: Math.floor(hairs.length / 30 / 7) }, (_, n) => {
      const at = middle(hairs, 7 * n);
      let [nearest, least] = [0, Infinity];
      for (let v = 0; v < rest.length / 3; v++) {
        const away = Math.hypot(rest[3 * v] - at[0], rest[3 * v + 1] - at[1], rest[3 * v + 2] - at[2]);
        if (away < least) [nearest, least] = [v, away];
      }
      assert.ok(least < 0.002, `a lash stands ${1000 * least} mm from the skin`);
      return { lash: 7 * n, lid: nearest };
    });
    for (const name of ['eyes size', 'eyes vertical position', 'inner eye distance', 'eyes 1', 'head 1']) {
      const [lids, lashes] = [target(face, name), target(fringe, name)];
      const far = roots.map(({ lid }) => Math.hypot(...lids.subarray(3 * lid, 3 * lid + 3)));
      assert.ok(Math.max(...far) > 0.0005, `${name} moves lids`);
      const off = roots.map(({ lash, lid }) => Math.hypot(...middle(lashes, lash).map((value, k) => value - lids[3 * lid + k]))).sort((a, b) => a - b);
      // A root is up to half an edge of the lid, 0.7 mm, from that vertex, and the lid stretches between.
      assert.ok(off[Math.floor(0.9 * off.length)] < 0.2 * Math.max(...far), `${name}: lids go up to ${1000 * Math.max(...far)} mm, lashes are off by ${1000 * off[Math.floor(0.9 * off.length)]}`);
    }
    const lipAt = await page.evaluate(() => {
      const { model } = window.designer;
      return model.landmarks.find(({ name }) => name === 'ibug_62').stencil;
    });
    for (const name of ['mouth vertical position', 'head 1', 'head 2']) {
      const lips = target(face, name);
      const lipMove = [0, 1, 2].map((k) => lipAt.reduce((sum, [v, w]) => sum + w * lips[3 * v + k], 0));
      for (const row of [upper, lower]) {
        const moves = target(row, name);
        const mean = [0, 1, 2].map((k) => moves.reduce((sum, value, i) => (i % 3 === k ? sum + value : sum), 0) / (moves.length / 3));
        // They stand between both lips, which do not go equally far; how deep is a matter of the wall behind.
        const away = Math.hypot(mean[0] - lipMove[0], mean[1] - lipMove[1]);
        assert.ok(away < 0.5 * Math.hypot(...lipMove), `${name}: the lip goes by ${lipMove.map((x) => 1000 * x)} mm, ${row.name} by ${mean.map((x) => 1000 * x)}`);
      }
    }
    assert.equal(target(fringe, 'chin 1'), null);

    // Hair stands on the head and goes along with it, root by root; no nose or mouth moves it. A beard goes with the jaw.
    const hair = json.meshes[5];
    const ribbons = readVectors(bytes, hair.primitives[0].attributes.POSITION);
    const strands = 3000;
    const each = ribbons.length / strands;
    assert.ok(Number.isInteger(each / 6), `${ribbons.length / 3} vertices are no strands`);
    assert.deepEqual(hair.extras.targetNames.filter((name) => name === 'jawOpen' || /^(nose|mouth|chin)/.test(name)), []);
    const opens = target(json.meshes[6], 'jawOpen');
    assert.ok(Math.min(...opens.filter((_, i) => i % 3 === 1)) < -0.01, 'the jaw leaves the beard behind');
    const goes = target(hair, 'head 1');
    const [skull, off] = [target(face, 'head 1'), []];
    for (let n = 0; n < strands; n += 60) {
      const at = [0, 1, 2].map((k) => (ribbons[each * n + k] + ribbons[each * n + 3 + k]) / 2);
      let [nearest, least] = [0, Infinity];
      for (let v = 0; v < rest.length / 3; v++) {
        const away = Math.hypot(rest[3 * v] - at[0], rest[3 * v + 1] - at[1], rest[3 * v + 2] - at[2]);
        if (away < least) [nearest, least] = [v, away];
      }
      // Hair along a parting begins up to 8 mm beyond it.
      assert.ok(least < 0.01, `a strand begins ${1000 * least} mm from the skin`);
      off.push(Math.hypot(...[0, 1, 2].map((k) => goes[each * n + k] - skull[3 * nearest + k])));
    }
    off.sort((a, b) => a - b);
    const far = Math.hypot(...[0, 1, 2].map((k) => Math.max(...goes.filter((_, i) => i % 3 === k).map(Math.abs))));
    assert.ok(off[Math.floor(0.9 * off.length)] < 0.25 * far, `the head moves by up to ${1000 * far} mm, strands are off by ${1000 * off[Math.floor(0.9 * off.length)]}`);

    // Behind parted lips the shadow draws back: its lower edge in the middle comes as high as its upper one.
    const ribbon = readVectors(bytes, shadow.primitives[0].attributes.POSITION);
    const opened = target(shadow, 'jawOpen');
    const columns = ribbon.length / 6;
    const centre = (columns - 1) / 2;
    const heights = [centre, columns + centre].map((i) => ribbon[3 * i + 1] + opened[3 * i + 1]);
    assert.ok(heights[0] - heights[1] < 1e-5, `the shadow hangs ${1000 * (heights[0] - heights[1])} mm into an open mouth`);
    assert.ok(ribbon[3 * centre + 1] - ribbon[3 * (columns + centre) + 1] > 0.0015, 'and is there between lips at rest');

    // The pictures, where features are, and between the charts.
    const read = (name, points) => readPicture(page, bytes, name, points);
    const [nose, mouth, bare, crown, brow] = await read('skin colour', ['ibug_30', 'ibug_57 ibug_66', [0.5, 0.73], 'vertex', 'metopion']);
    assert.ok(nose[0] > nose[1] && nose[1] > nose[2] && nose[0] > 150, `the nose is ${nose}`);
    assert.ok(mouth[1] < 0.75 * nose[1] && mouth[0] > 1.6 * mouth[1], `red lips are ${mouth}, the nose ${nose}`);
    assert.ok(crown[0] < 0.5 * brow[0] && brow[0] > 150, `cropped hair is ${crown}, the forehead ${brow}`);
    assert.ok(bare.every((value, k) => Math.abs(value - nose[k]) < 60), 'what is not skin has its colour, for pictures that are shrunk');
    const [pupil, iris, white] = await read('eyes', [[0.5, 0.5], [0.5 + 0.09, 0.5], [0.5 + 0.24, 0.5]]);
    assert.ok(Math.max(...pupil) < 40, `the pupil is ${pupil}`);
    assert.ok(iris[2] > iris[0] + 8, `a blue iris is ${iris}`);
    assert.ok(Math.min(...white) > 130, `the white is ${white}`);
    // Past an eyeball is what goes on with its white, and not the dark.
    assert.equal(json.materials[skinOf.material].doubleSided, true);
    const walls = await page.evaluate(() => {
      const { parts, triangles, uvs } = window.designer.model;
      const { first, count } = parts.find(({ name }) => name === 'eye cavities');
      return Array.from({ length: count }, (_, t) => [0, 1].map((k) => Math.abs(k - [0, 1, 2].reduce((sum, i) => sum + uvs[2 * triangles[3 * (first + t) + i] + k] / 3, 0))));
    });
    const wall = (await read('skin colour', walls)).map(([, g]) => g).sort((a, b) => a - b)[walls.length >> 1];
    assert.ok(wall > 120 && wall < Math.min(...white), `behind the lids it is ${wall}, the white of the eye ${white}`);
    const [flat] = await read('skin normal', [[0.5, 0.73]]);
    assert.ok(Math.abs(flat[0] - 128) < 3 && flat[2] > 250, `no skin, no relief: ${flat}`);
    const slopes = await read('skin normal', Array.from({ length: 400 }, (_, i) => [0.7 + 0.0005 * (i % 20), 0.4 + 0.0005 * Math.floor(i / 20)]));
    const relief = slopes.map(([x]) => Math.abs(x - 128)).sort((a, b) => a - b)[200];
    assert.ok(relief >= 1 && relief < 40, `pores lean by ${relief} of 127`);
    const [open0] = await read('skin surface', ['ibug_30']);
    assert.ok(open0[0] > 200 && open0[1] > 60 && open0[1] < 190 && open0[2] < 8, `the nose’s surface: ${open0}`);

    await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
    await page.mouse.move(300, 20);
    assert.equal(differing(shown, await picture(page, 'exports-glb-after')), 0);
    assert.deepEqual(visit.complaints, []);
  });
});
