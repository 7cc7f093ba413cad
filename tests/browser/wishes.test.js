import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { gunzipSync, gzipSync } from 'node:zlib';
import { differing, later, moveSlider, open, picture, pressQuickly, siteAndBrowser, TALL } from './site.js';

const { browser, site } = await siteAndBrowser();

const group = (page) => page.getByRole('group', { name: 'What random faces should be like' });
const choice = (page, name) => group(page).getByRole('combobox', { name, exact: true });
const draw = (page) => page.getByRole('button', { name: 'Draw a face' });
const reading = (page, name) => page.evaluate((attribute) => window.designer.face.attribute(attribute), name);
const code = (page) => page.evaluate(() => window.designer.face.code);
const places = (page, region) =>
  page.evaluate((named) => {
    const { model, face } = window.designer;
    const inside = [...model.regionOf.keys()].filter((v) => model.regionNames[model.regionOf[v]] === named);
    return inside.flatMap((v) => [...face.positions.slice(3 * v, 3 * v + 3)]);
  }, region);

/** A model's file without what it knows of labels: see src/blob for its bytes. @param {Buffer} packed */
function unlabelled(packed) {
  const blob = gunzipSync(packed);
  for (let row = 40; row < 40 + 32 * blob.readUInt32LE(24); row += 32) {
    // A section that nobody asks for is passed over.
    if (['attributes', 'read-outs'].includes(blob.toString('latin1', row, row + 16).replace(/\0+$/, ''))) blob[row] = 0x5f;
  }
  let hash = 0xcbf29ce484222325n;
  const words = Buffer.concat([blob.subarray(0, 32), blob.subarray(40), Buffer.alloc((8 - (blob.length % 8)) % 8)]);
  // The last word is one of padding where nothing is left over.
  const padded = blob.length % 8 ? words : Buffer.concat([words, Buffer.alloc(8)]);
  for (let at = 0; at < padded.length; at += 8) hash = BigInt.asUintN(64, (hash ^ padded.readBigUInt64LE(at)) * 0x100000001b3n);
  blob.writeBigUInt64LE(hash, 32);
  return gzipSync(blob, { level: 1 });
}

describe('a person', () => {
  const slider = (page, name) => page.getByRole('slider', { name, exact: true });

  test('grows older, and back: the shape, lines and grey hair; undone as one step', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true, viewport: TALL });
    await page.getByRole('button', { name: 'Person', exact: true }).click();
    await moveSlider(page, 'Age', 0.2);
    const young = { code: await code(page), picture: await picture(page, 'person-young') };
    assert.ok(Math.abs((await reading(page, 'age')) - 30.4) < 0.1);
    const others = async () => Promise.all(['sex', 'african', 'asian', 'caucasian'].map((name) => reading(page, name)));
    const kept = await others();

    // By keys: a year each, ten with Shift; one run of keys is one step, and what is long after the last is another.
    await later(page);
    await slider(page, 'Age').focus();
    await pressQuickly(slider(page, 'Age'), 'ArrowRight', 4, true);
    assert.ok(Math.abs((await reading(page, 'age')) - 70.4) < 0.1);
    assert.equal(await slider(page, 'Age').getAttribute('aria-valuetext'), '70 years');
    (await others()).forEach((now, i) => assert.ok(Math.abs(now - kept[i]) < 0.002, 'what was not asked for stays'));
    const colouring = await page.evaluate(() => window.designer.colouring);
    assert.ok(colouring.lines > 0.5 && colouring.grey > 0.5, JSON.stringify(colouring));
    assert.ok(differing(young.picture, await picture(page, 'person-old')) > 10_000);

    await page.keyboard.press('Control+z');
    assert.equal(await code(page), young.code);
    assert.equal(differing(young.picture, await picture(page, 'person-young-again')), 0);
    await page.keyboard.press('Control+y');
    await moveSlider(page, 'Age', 0.2);
    // Coefficients are rounded, to a micrometre, which a pixel at an edge may tell.
    assert.ok(differing(young.picture, await picture(page, 'person-young-at-last')) < 20, 'there and back is where it was');

    // What is under way is what is undone, and stays undone when it is let go.
    await later(page);
    const before = await code(page);
    const box = await slider(page, 'Age').boundingBox();
    assert.ok(box);
    const over = (/** @type {number} */ part) => page.mouse.move(box.x + part * box.width, box.y + box.height / 2, { steps: 3 });
    await over(0.2);
    await page.mouse.down();
    await over(0.7);
    assert.notEqual(await code(page), before);
    await page.keyboard.press('Control+z');
    assert.equal(await code(page), before);
    await page.mouse.up();
    assert.equal(await code(page), before);
    assert.ok(await page.getByRole('button', { name: 'Redo', exact: true }).isEnabled());
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('is of a shape in shares that sum to one, in colours of its own if that is wanted; what is locked stays', async () => {
    const { context, page, complaints } = await open(browser, site, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
    await page.getByRole('button', { name: 'Person', exact: true }).tap();
    await page.getByLabel('Skin, hair and lines go along').setChecked(false);
    const type = async (name, number) => {
      await slider(page, name).focus();
      await page.keyboard.press('Enter');
      const field = page.getByRole('spinbutton', { name, exact: true });
      await field.fill(String(number));
      await field.press('Enter');
    };
    await type('African shape', 70);
    const shares = () => Promise.all(['african', 'asian', 'caucasian'].map((name) => reading(page, name)));
    let now = await shares();
    assert.ok(Math.abs(now[0] - 0.7) < 0.002 && Math.abs(now[0] + now[1] + now[2] - 1) < 0.01, `${now}`);
    assert.deepEqual(await page.evaluate(() => window.designer.colouring), {});
    await page.getByLabel('Skin, hair and lines go along').setChecked(true);
    await type('African shape', 20);
    now = await shares();
    assert.ok(Math.abs(now[0] - 0.2) < 0.002, `${now}`);
    assert.ok((await page.evaluate(() => window.designer.colouring.skin)) < 0.25, 'skin goes along');

    // The field has what the reading says, and takes it; a number alone is of what it says.
    await type('Age', '70 years');
    assert.ok(Math.abs((await reading(page, 'age')) - 70) < 0.1);
    await type('Age', '-8');
    assert.ok(Math.abs((await reading(page, 'age')) - 62) < 0.1);
    await type('Age', 7);
    assert.equal(await page.getByRole('alert').textContent(), 'This model knows adults only: it ends at 18.');
    await type('Age', 99);
    assert.equal(await page.getByRole('alert').textContent(), 'It ends at 80.');
    await type('Age', 70);
    const field = page.getByRole('spinbutton', { name: 'Sex', exact: true });
    for (const [typed, male, said] of /** @type {const} */ ([['80 % F', 0.2, '80% female'], ['70', 0.3, '70% female'], ['60% male', 0.6, '60% male'], ['52', 0.52, '52% male'], ['+10', 0.62, '62% male'], ['+20% female', 0.42, '58% female'], ['-10', 0.52, '52% male']])) {
      await type('Sex', typed);
      assert.ok(Math.abs((await reading(page, 'sex')) - male) < 0.005, `${typed} is ${await reading(page, 'sex')}`);
      await slider(page, 'Sex').press('Enter');
      assert.equal(await field.inputValue(), said);
      await field.press('Escape');
    }
    await slider(page, 'Sex').press('Enter');
    await field.press('ArrowDown');
    assert.deepEqual([await field.inputValue(), await field.getAttribute('aria-valuenow')], ['51% male', '51']);
    await type('Sex', '80% mail');
    assert.equal(await page.getByRole('alert').textContent(), 'Type it like “51% male”.');
    await field.press('Escape');

    await page.evaluate(() => window.designer.face.lock('nose'));
    const nose = await places(page, 'nose');
    const sex = await reading(page, 'sex');
    await type('Sex', '95% male');
    const gone = ((await reading(page, 'sex')) - sex) / (0.95 - sex);
    assert.ok(gone > 0.5 && gone < 1.001, `${gone} of the way`);
    assert.ok((await places(page, 'nose')).every((x, i) => Math.abs(x - nose[i]) <= 1e-4));
    assert.deepEqual(complaints, []);
    await context.close();
  });
});

describe('the two sides', () => {
  test('become alike, differ by what is typed, and change places; each is a step, and what is locked stays', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true, viewport: TALL });
    await page.getByRole('button', { name: 'Person', exact: true }).click();
    const slider = page.getByRole('slider', { name: 'Asymmetry', exact: true });
    await slider.waitFor();
    /** How far spots are from where the other side's image has them, of all vertices at the most, mm. */
    const apart = () =>
      page.evaluate(() => {
        const { model, face } = window.designer;
        const { positions } = face;
        const off = Array.from(model.mirror, (other, v) => Math.hypot(...[0, 1, 2].map((axis) => positions[3 * v + axis] - (axis === 0 ? -1 : 1) * positions[3 * other + axis])));
        return Math.max(...off);
      });
    const said = () => slider.getAttribute('aria-valuetext');
    assert.match(await said(), /^0\.0 mm, less than anybody’s$/);

    // Of a face whose sides are alike they become somebody's.
    await moveSlider(page, 'Asymmetry', 0.5);
    assert.match(await said(), /^\d\.\d mm, \d+(st|nd|rd|th)$/);
    assert.ok((await apart()) > 0.5);
    await page.keyboard.press('Control+z');
    assert.ok((await apart()) < 0.01);

    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    const random = { code: await code(page), picture: await picture(page, 'sides-random') };
    await page.getByRole('button', { name: 'Mirror image' }).click();
    assert.notEqual(await code(page), random.code);
    assert.ok(differing(random.picture, await picture(page, 'sides-mirrored')) > 5000);
    await page.getByRole('button', { name: 'Mirror image' }).click();
    assert.equal(await code(page), random.code);
    assert.equal(differing(random.picture, await picture(page, 'sides-random-again')), 0);

    await slider.focus();
    await page.keyboard.press('Enter');
    const field = page.getByRole('spinbutton', { name: 'Asymmetry, in mm' });
    await field.fill('0.4 mm'); // less than anybody's: no coefficient of a random face ends on the way
    await field.press('Enter');
    assert.match(await said(), /^0\.4 mm, /);
    await page.evaluate(() => window.designer.face.lock('nose'));
    const nose = await places(page, 'nose');
    await slider.focus();
    await page.keyboard.press('Delete');
    assert.ok((await places(page, 'nose')).every((x, i) => Math.abs(x - nose[i]) <= 1e-4));
    await page.evaluate(() => window.designer.face.unlock('nose'));
    await slider.press('Delete');
    assert.ok((await apart()) < 0.05, `${await apart()} mm`);
    // A face keeps its way of blending.
    await page.evaluate(() => (window.designer.face.alpha = 14));
    await page.getByRole('button', { name: 'Mirror image' }).click();
    await moveSlider(page, 'Asymmetry', 0.5);
    assert.equal(await page.evaluate(() => window.designer.face.alpha), 14);
    assert.deepEqual(complaints, []);
    await context.close();
  });
});

describe('what random faces should be like', () => {
  test('is not asked of a model without labels, whose faces are drawn all the same', async () => {
    const body = unlabelled(await readFile(new URL('../../www/public/model.phiz', import.meta.url)));
    const { context, page, complaints } = await open(browser, site, {
      prepare: (opened) => opened.route('**/model.phiz', (route) => route.fulfill({ body, contentType: 'application/octet-stream' })),
    });
    assert.deepEqual(await page.evaluate(() => window.designer.model.attributes), []);
    assert.equal(await group(page).count(), 0);
    assert.equal(await draw(page).count(), 0);
    await page.getByRole('button', { name: 'Person', exact: true }).click();
    await page.getByRole('slider', { name: 'Asymmetry', exact: true }).waitFor();
    assert.equal(await page.locator('.person input[type=range]').count(), 1, 'its sides are all that is known of the person');
    const before = await code(page);
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    assert.notEqual(await code(page), before);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('is anything at first, and what was chosen by pointer and by keys after that', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    for (const name of ['Sex', 'Age', 'Ethnicity']) assert.equal(await choice(page, name).inputValue(), '');
    assert.equal(await choice(page, 'Weight').count(), 0, 'the default model does not tell it');
    const median = await picture(page, 'wishes-median');

    await choice(page, 'Sex').selectOption('Male');
    await choice(page, 'Age').selectOption('About 70');
    await choice(page, 'Ethnicity').selectOption('Asian');
    assert.ok((await picture(page, 'wishes-chosen')).rgb.equals(median.rgb), 'a choice alone changes no face');
    const before = await code(page);
    await draw(page).click();
    assert.ok(differing(median, await picture(page, 'wishes-man')) > 1000, 'another face');
    assert.ok(Math.abs((await reading(page, 'sex')) - 1) < 0.005);
    assert.ok(Math.abs((await reading(page, 'age')) - 70) < 0.1);
    assert.ok(Math.abs((await reading(page, 'asian')) - 1) < 0.02);
    assert.ok((await page.evaluate(() => location.hash)).includes(await code(page)), 'the face is in the address');

    // Everything random asks for the same: the toolbar's button, too.
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    assert.ok(Math.abs((await reading(page, 'age')) - 70) < 0.1);

    // By keys: a native list takes the first letter.
    await choice(page, 'Sex').focus();
    await page.keyboard.press('F');
    assert.equal(await choice(page, 'Sex').locator('option:checked').textContent(), 'Female');
    await draw(page).focus();
    await page.keyboard.press('Enter');
    assert.ok(Math.abs(await reading(page, 'sex')) < 0.005);

    for (let step = 0; step < 3; step++) await page.getByRole('button', { name: 'Undo' }).click();
    assert.equal(await code(page), before);

    await group(page).getByRole('button', { name: 'Clear all' }).click();
    for (const name of ['Sex', 'Age', 'Ethnicity']) assert.equal(await choice(page, name).inputValue(), '');
    assert.equal(await page.evaluate(() => document.activeElement?.id), 'wish-sex');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('leaves what is locked alone, on a phone', async () => {
    const { context, page } = await open(browser, site, { viewport: { width: 390, height: 780 }, hasTouch: true });
    await page.evaluate(() => window.designer.face.lock('nose'));
    const before = await places(page, 'nose');
    assert.ok(before.length > 300);
    await choice(page, 'Sex').scrollIntoViewIfNeeded();
    const box = await choice(page, 'Sex').boundingBox();
    assert.ok(box && box.x >= 0 && box.x + box.width <= 390 && box.height >= 36);
    await choice(page, 'Sex').selectOption('Male');
    await draw(page).tap();
    const after = await places(page, 'nose');
    assert.ok(after.every((x, i) => Math.abs(x - before[i]) <= 1e-4));
    const male = await reading(page, 'sex');
    assert.ok(male > 0.8 && male < 1.05, `${male}`);
    await context.close();
  });

  test('knows more of the synthetic people, and is explained', async () => {
    const synthetic = await open(browser, site, { hash: '?model=synthetic' });
    await choice(synthetic.page, 'Weight').selectOption('Heavy');
    await draw(synthetic.page).click();
    assert.ok((await reading(synthetic.page, 'weight')) > 0.9);
    await synthetic.page.getByRole('button', { name: 'What is happening?' }).click();
    assert.match((await synthetic.page.locator('#explanation').textContent()) ?? '', /synthetic heads/);
    await synthetic.context.close();
  });
});
