import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { gunzipSync, gzipSync } from 'node:zlib';
import { differing, open, picture, siteAndBrowser } from './site.js';

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

describe('what random faces should be like', () => {
  test('is not asked of a model without labels, whose faces are drawn all the same', async () => {
    const body = unlabelled(await readFile(new URL('../../www/public/model.phiz', import.meta.url)));
    const { context, page, complaints } = await open(browser, site, {
      prepare: (opened) => opened.route('**/model.phiz', (route) => route.fulfill({ body, contentType: 'application/octet-stream' })),
    });
    assert.deepEqual(await page.evaluate(() => window.designer.model.attributes), []);
    assert.equal(await group(page).count(), 0);
    assert.equal(await draw(page).count(), 0);
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
