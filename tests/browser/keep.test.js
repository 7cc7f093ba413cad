import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import { moveSlider, open, SCREENSHOTS, settled, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

const codeOf = (page) => page.evaluate(() => window.designer.face.code);
const ready = (page) => page.waitForFunction(() => document.documentElement.dataset.ready === 'true');
const toast = (page) => page.locator('.toast').textContent();

describe('nothing is lost', () => {
  test('four hundred steps are undone to the first and redone to the last', async () => {
    const { context, page } = await open(browser, site);
    const first = await codeOf(page);
    const slider = page.getByRole('slider', { name: 'chin 1', exact: true });
    await page.locator('.tab[data-group="chin"]').click();
    // Typed numbers are steps of their own; a run of one key would be a single one.
    await slider.evaluate((input) => {
      const row = input.closest('.control');
      const value = row.querySelector('.value');
      const typed = row.querySelector('.typed');
      for (let i = 0; i < 400; i++) {
        value.click();
        typed.value = String(10 + (i % 80));
        typed.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true }));
      }
    });
    const last = await codeOf(page);
    assert.notEqual(last, first);
    const all = (/** @type {string} */ name) =>
      page.getByRole('button', { name, exact: true }).evaluate((/** @type {HTMLButtonElement} */ button) => {
        let presses = 0;
        for (; !button.disabled && presses < 1000; presses++) button.click();
        return presses;
      });
    assert.equal(await all('Undo'), 400);
    assert.equal(await codeOf(page), first);
    assert.equal(await all('Redo'), 400);
    assert.equal(await codeOf(page), last);
    await context.close();
  });

  test('the face comes back with the page, and a link does not push it out', async () => {
    const { context, page, complaints } = await open(browser, site);
    await moveSlider(page, 'nose 1', 0.93);
    await page.getByRole('button', { name: 'Lock the nose' }).click();
    const mine = await codeOf(page);
    await page.close();

    // Without a link.
    const again = await context.newPage();
    await again.goto(site.url);
    await ready(again);
    assert.equal(await codeOf(again), mine);
    assert.deepEqual(await again.evaluate(() => window.designer.face.locked), ['nose']);
    assert.match((await toast(again)) ?? '', /last face is back/);
    assert.equal(new URL(again.url()).hash, `#${mine}`, 'the address holds the face that is shown');
    const theirs = await again.evaluate(() => {
      const other = window.designer.model.face();
      other.set('mouth 1', 0.1);
      return other.code;
    });
    await again.close();

    const third = await context.newPage();
    await third.goto(`${site.url}#${theirs}`);
    await ready(third);
    assert.equal(await codeOf(third), theirs);
    assert.match((await toast(third)) ?? '', /among your faces/);
    await third.getByRole('tab', { name: 'Faces' }).click();
    await third.getByRole('button', { name: /^Open Last visit/ }).click();
    assert.equal(await codeOf(third), mine);
    await third.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await codeOf(third), theirs);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('faces are saved, renamed, deleted, brought back, and go through files', async () => {
    const { context, page, complaints } = await open(browser, site);
    await moveSlider(page, 'nose 1', 0.93);
    const mine = await codeOf(page);
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('textbox', { name: 'Save this face as' }).fill('Old sailor');
    await page.keyboard.press('Enter');
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    const random = await codeOf(page);
    await page.getByRole('button', { name: 'Save', exact: true }).click();

    // Two portraits, and they are of two people.
    await settled(page);
    await page.waitForFunction(() =>
      [...document.querySelectorAll('.saved img')].every((image) => /** @type {HTMLImageElement} */ (image).naturalWidth > 0),
    );
    const looks = await page.locator('.saved img').evaluateAll((all) =>
      all.map((image) => {
        const canvas = document.createElement('canvas');
        [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
        const context = canvas.getContext('2d');
        context.drawImage(image, 0, 0);
        const { data } = context.getImageData(canvas.width / 2, canvas.height / 2, 1, 1);
        return { src: image.src, skin: data[0] > data[2] + 15 };
      }),
    );
    const [newer, older] = looks.map(({ src }) => src);
    assert.ok(looks.every(({ skin }) => skin), 'a portrait shows no face');
    assert.notEqual(newer, older);
    await page.screenshot({ path: join(SCREENSHOTS, 'saved.png') });

    await page.getByRole('button', { name: 'Rename Old sailor' }).click();
    await page.keyboard.type('Young sailor');
    await page.keyboard.press('Enter');
    await page.getByRole('button', { name: 'Open Young sailor' }).click();
    assert.equal(await codeOf(page), mine);

    const [file] = await Promise.all([
      page.waitForEvent('download'),
      page.getByRole('button', { name: 'Download Young sailor' }).click(),
    ]);
    assert.equal(file.suggestedFilename(), 'young-sailor.phiz.json');
    const path = join(SCREENSHOTS, 'sailor.json');
    await file.saveAs(path);
    const content = JSON.parse(readFileSync(path, 'utf8'));
    assert.equal(content.code, mine);

    await page.getByRole('button', { name: 'Delete Young sailor' }).click();
    assert.equal(await page.getByRole('button', { name: 'Open Young sailor' }).count(), 0);
    await page.locator('.restore').getByRole('button', { name: 'Undo' }).click();
    await page.getByRole('button', { name: 'Open Young sailor' }).waitFor();
    await page.getByRole('button', { name: 'Delete Young sailor' }).click();
    await page.getByRole('button', { name: 'Reset all' }).click();

    // Into an empty browser, and broken or foreign files into the same one.
    const other = await open(browser, site);
    await other.page.getByRole('tab', { name: 'Faces' }).click();
    const give = (name, body) =>
      other.page.locator('input[type=file]').setInputFiles({ name, mimeType: 'application/json', buffer: Buffer.from(body) });
    await give('sailor.json', JSON.stringify(content));
    await other.page.getByRole('button', { name: 'Open Young sailor' }).waitFor();
    assert.equal(await codeOf(other.page), mine);
    for (const [name, body, sentence] of [
      ['notes.json', 'dear diary', /notes\.json is not a face from this page/],
      ['empty.json', '', /empty\.json is not a face/],
      ['list.json', '[1, 2]', /list\.json is not a face/],
      ['null.json', 'null', /null\.json is not a face/],
      ['cut.json', JSON.stringify({ ...content, code: content.code.slice(0, -3) }), /cut\.json is damaged: ./],
      ['new.json', JSON.stringify({ ...content, version: 9 }), /new\.json was written by a newer page/],
      ['theirs.json', JSON.stringify({ ...content, model: 'Cats', code: 'AAAAAAAA' }), /face of another model, “Cats”/],
      ['long.json', 'x'.repeat(200_000), /long\.json is not a face: it is far too long/],
    ]) {
      await give(name, body);
      await other.page.waitForFunction(
        (source) => new RegExp(source).test(document.querySelector('.toast')?.textContent ?? ''),
        sentence.source,
      );
      assert.equal(await codeOf(other.page), mine, `${name} changed the face`);
      assert.equal(await other.page.locator('.saved li').count(), 1, `${name} changed the list`);
    }
    assert.deepEqual([...complaints, ...other.complaints], []);
    await other.context.close();

    // What is saved survives the page.
    await page.reload();
    await ready(page);
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('button', { name: 'Open My face 2' }).click();
    assert.equal(await codeOf(page), random);
    await context.close();
  });
});
