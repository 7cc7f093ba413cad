import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import { holdBack, moveSlider, open, SCREENSHOTS, settled, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

const codeOf = (page) => page.evaluate(() => window.designer.face.code);
const locks = (page) => page.evaluate(() => [window.designer.face.locked, window.designer.face.lockedMeasures]);
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
    assert.deepEqual(await locks(third), [[], []], 'a link has none of what is locked here');
    assert.match((await toast(third)) ?? '', /among your faces/);
    await third.getByRole('tab', { name: 'Faces' }).click();
    await third.getByRole('button', { name: /^Open Last visit/ }).click();
    assert.equal(await codeOf(third), mine);
    await third.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await codeOf(third), theirs);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('two tabs have a face each, and its locks, when they are loaded again', async () => {
    const { context, page, complaints } = await open(browser, site);
    await moveSlider(page, 'nose 1', 0.93);
    await page.getByRole('button', { name: 'Lock the nose' }).click();
    const mine = await codeOf(page);
    const beside = await context.newPage();
    await beside.goto(site.url);
    await ready(beside);
    await beside.getByRole('button', { name: 'Reset all' }).click();
    await moveSlider(beside, 'nose 2', 0.2);
    const other = await codeOf(beside);
    const has = async (/** @type {any} */ tab, /** @type {string} */ code, /** @type {string[]} */ locked) => {
      await tab.reload();
      await ready(tab);
      assert.deepEqual([await codeOf(tab), await locks(tab)], [code, [locked, []]]);
      assert.equal(await tab.evaluate(() => Object.keys(localStorage).find((name) => name.startsWith('phiz-faces-')) ?? null), null, 'the other tab has a face, which is not lost');
    };
    await has(page, mine, ['nose']);
    await has(beside, other, ['nose']);
    await has(page, mine, ['nose']);
    // The median face has an empty address.
    await page.getByRole('button', { name: 'Lock the nose' }).click();
    await page.getByRole('button', { name: 'Reset all' }).click();
    const median = await codeOf(page);
    assert.equal(await page.evaluate(() => location.hash), '');
    await has(beside, other, ['nose']);
    await moveSlider(beside, 'nose 2', 0.3);
    await has(page, median, []);

    // A browser that takes no more addresses for a while gets the newest then; who loads the page again has it.
    await page.evaluate(() => {
      const { replaceState } = window.history;
      window.history.replaceState = () => {
        throw new DOMException('too often', 'SecurityError');
      };
      window.allow = () => (window.history.replaceState = replaceState);
    });
    await moveSlider(page, 'nose 1', 0.4);
    const late = await codeOf(page);
    assert.equal(await page.evaluate(() => location.hash), '');
    await page.evaluate(() => window.allow());
    await page.waitForFunction((code) => location.hash === `#${code}`, late);
    await has(page, late, []);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('of two tabs that are closed neither loses its face, and one that is there keeps its own to itself', async () => {
    const { context, page, complaints } = await open(browser, site);
    const another = async () => {
      const tab = await context.newPage();
      await tab.goto(site.url);
      await ready(tab);
      return tab;
    };
    const kept = (/** @type {import('playwright-core').Page} */ tab) =>
      tab.evaluate(() => JSON.parse(localStorage.getItem(Object.keys(localStorage).find((name) => name.startsWith('phiz-faces-')) ?? '') ?? '[]').map(({ code }) => code));
    await moveSlider(page, 'nose 1', 0.93);
    const mine = await codeOf(page);
    const beside = await another();
    await beside.getByRole('button', { name: 'Reset all' }).click();
    await moveSlider(beside, 'nose 2', 0.2);
    const other = await codeOf(beside);
    // Both are there, and so is the one that is loaded again.
    await page.reload();
    await ready(page);
    const looking = await another();
    assert.deepEqual(await kept(looking), []);
    for (const tab of [looking, page, beside]) await tab.close();

    const next = await another();
    assert.equal(await codeOf(next), other, 'what was worked on last');
    assert.deepEqual(await kept(next), [mine], 'and what the other tab did');
    assert.equal(await toast(next), 'What you worked on in another tab, which is closed, is among your faces.');
    await moveSlider(next, 'nose 3', 0.7);
    await next.close();
    const last = await another();
    assert.deepEqual(await kept(last), [mine], 'once');
    assert.equal(await toast(last), 'Your last face is back.');
    assert.deepEqual(await last.evaluate(() => Object.keys(localStorage).filter((name) => name.startsWith('phiz-tab-'))), [], 'nothing is left behind');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('what was worked on last stays where it is kept until it is among the faces', async () => {
    const { context, page, complaints } = await open(browser, site);
    const key = await page.evaluate(() => Object.keys(localStorage).find((name) => name.startsWith('phiz-face-')) ?? null);
    assert.equal(key, null);
    await page.getByRole('tab', { name: 'Expressions' }).click();
    await page.getByRole('slider', { name: 'mouthSmile' }).first().waitFor({ timeout: 60_000 });
    await moveSlider(page, 'Smile mouthSmile', 0.8);
    const theirs = new URL(page.url()).hash;
    await page.getByRole('button', { name: 'Reset all' }).click();
    await page.getByRole('tab', { name: 'Features' }).click();
    await moveSlider(page, 'nose 1', 0.93);
    const mine = await codeOf(page);
    await page.close();

    const linked = await context.newPage();
    const come = await holdBack(linked, '**/expressions.phiz');
    await linked.goto(`${site.url}${theirs}`);
    await linked.waitForFunction(() => window.designer);
    await moveSlider(linked, 'nose 2', 0.2);
    const kept = () =>
      linked.evaluate(() => {
        const key = Object.keys(localStorage).find((name) => name.startsWith('phiz-face-')) ?? '';
        return JSON.parse(localStorage.getItem(key) ?? '{}').code;
      });
    assert.equal(await kept(), mine);
    come();
    await ready(linked);
    assert.equal(await kept(), await codeOf(linked));
    await linked.getByRole('tab', { name: 'Faces' }).click();
    await linked.getByRole('button', { name: /^Open Last visit/ }).click();
    assert.equal(await codeOf(linked), mine);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('what was worked on last is not lost: an expression alone, a face of another version of the model, and beside another site', async () => {
    const { context, page, complaints } = await open(browser, site);
    await moveSlider(page, 'nose 2', 0.1);
    const theirs = await codeOf(page);
    await page.getByRole('button', { name: 'Reset all' }).click();
    await page.getByRole('tab', { name: 'Expressions' }).click();
    await page.getByRole('slider', { name: 'mouthSmile' }).first().waitFor({ timeout: 60_000 });
    await moveSlider(page, 'Smile mouthSmile', 0.8);
    const key = await page.evaluate(() => Object.keys(localStorage).find((name) => name.startsWith('phiz-face-')) ?? '');
    assert.ok(key.endsWith(new URL(site.url).pathname), `${key}: of this site, not of all of its origin`);
    // Of a visit the other day.
    await page.evaluate((key) => {
      const kept = JSON.parse(localStorage.getItem(key));
      if (Math.abs(kept.when - Date.now()) > 60_000) throw new Error(`kept at ${kept.when}`);
      localStorage.setItem(key, JSON.stringify({ ...kept, when: new Date(2024, 1, 3, 12).getTime() }));
    }, key);
    await page.close();

    const linked = await context.newPage();
    await linked.goto(`${site.url}#${theirs}`);
    await ready(linked);
    assert.equal(await toast(linked), 'You see this link’s face. The one you were working on is among your faces.');
    await linked.getByRole('tab', { name: 'Faces' }).click();
    await linked.getByRole('button', { name: /^Open Last visit, 3 Feb 2024, 12:00/ }).click();
    await linked.waitForFunction(() => window.designer.face.expression.mouthSmileLeft > 0.79);
    // A model that was trained anew has other codes; what another site on the origin keeps is its own.
    const strange = 'AAAAAAAA';
    const elsewhere = JSON.stringify({ code: strange });
    await linked.evaluate(
      ([key, strange, elsewhere]) => {
        localStorage.setItem(key, JSON.stringify({ code: strange, expression: '', colouring: '', shown: { jawOpen: 0.5 } }));
        localStorage.setItem('phiz-face-people-/other/', elsewhere);
      },
      [key, strange, elsewhere],
    );
    await linked.close();
    const after = await context.newPage();
    await after.goto(site.url);
    await ready(after);
    assert.equal(await toast(after), 'The face you were working on is of another version of this model and cannot be shown here. The browser keeps it.');
    await moveSlider(after, 'nose 1', 0.7);
    const kept = await after.evaluate(() => JSON.parse(localStorage.getItem(Object.keys(localStorage).find((name) => name.startsWith('phiz-faces-')) ?? '') ?? '[]'));
    assert.deepEqual(
      kept.filter(({ code }) => code === strange).map(({ name, expression }) => ({ name, expression })),
      [{ name: 'Last visit', expression: { jawOpen: 0.5 } }],
    );
    assert.equal(await after.evaluate(() => localStorage.getItem('phiz-face-people-/other/')), elsewhere);
    // What an earlier version of the page kept is found.
    const mine = await codeOf(after);
    await after.evaluate(([key, mine]) => {
      localStorage.removeItem(key);
      localStorage.setItem('phiz-face-people', JSON.stringify({ code: mine, expression: '', colouring: '' }));
    }, [key, mine]);
    await after.goto('about:blank');
    await after.goto(site.url);
    await ready(after);
    assert.equal(await codeOf(after), mine);
    assert.equal(await toast(after), 'Your last face is back.');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('a link gives what of it can be read: shape without strange looks, and tildes as some programs write them', async () => {
    const { context, page, complaints } = await open(browser, site);
    await moveSlider(page, 'nose 1', 0.93);
    const mine = await codeOf(page);
    const colours = () => page.evaluate(() => window.designer.colouring);
    const encoded = (/** @type {number[]} */ ...bytes) => Buffer.from(bytes).toString('base64url');
    const visit = async (/** @type {string} */ hash) => {
      await page.goto('about:blank');
      await page.goto(`${site.url}#${hash}`);
      await ready(page);
    };
    // A newer version has more of them.
    await visit(`${mine}~~${encoded(0, 80, 200, 50)}`);
    assert.deepEqual([await codeOf(page), await colours()], [mine, { skin: 0.8 }]);
    await page.evaluate((hash) => (location.hash = hash), `${mine}%7E%7e${encoded(0, 70)}`);
    await page.waitForFunction(() => window.designer.colouring.skin === 0.7);
    // What stands behind it in a letter is none of it.
    await visit(`${mine}~~${encoded(0, 60)}).”`);
    assert.deepEqual([await codeOf(page), await colours()], [mine, { skin: 0.6 }]);
    for (const way of ['opened', 'followed']) {
      if (way === 'opened') await visit(`${mine}~~${encoded(0, 101)}`);
      else await page.evaluate((hash) => (location.hash = hash), `${mine}~~*`);
      await page.getByText('The link’s looks could not be read, so the face has the model’s own.').waitFor();
      assert.deepEqual([await codeOf(page), await colours()], [mine, {}], way);
      await page.getByRole('button', { name: 'Random face', exact: true }).click();
    }
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('where nothing can be stored it is said once; all faces go through one file; each that was deleted comes back to its place', async () => {
    const { context, page, complaints } = await open(browser, site, {
      prepare: (page) =>
        page.addInitScript(() => {
          window.persists = 0;
          StorageManager.prototype.persist = async () => (window.persists += 1) > 0;
          const { setItem } = Storage.prototype;
          Storage.prototype.setItem = function (key, value) {
            if (window.isFull) throw new DOMException('', 'QuotaExceededError');
            setItem.call(this, key, value);
          };
        }),
    });
    const says = (/** @type {string} */ sentence) => page.waitForFunction((sentence) => document.querySelector('.toast')?.textContent === sentence, sentence);
    const full = 'This browser does not let the page store anything, or its storage is full. Download the face or copy its link.';
    await page.evaluate(() => (window.isFull = true));
    await moveSlider(page, 'nose 1', 0.9);
    await says(full);
    await page.evaluate(() => (document.querySelector('.toast').textContent = ''));
    await moveSlider(page, 'nose 2', 0.9);
    assert.equal(await toast(page), '', 'it is said once');
    await page.evaluate(() => (window.isFull = false));

    await page.getByRole('tab', { name: 'Faces' }).click();
    const save = page.getByRole('button', { name: 'Save', exact: true });
    assert.equal(await page.evaluate(() => window.persists), 0);
    await save.click();
    assert.equal(await page.evaluate(() => window.persists), 1, 'the browser was asked to keep it');
    for (const value of [0.2, 0.4]) {
      await page.evaluate((value) => void window.designer.face.set('chin 1', value), value);
      await save.click();
    }
    assert.equal(await page.evaluate(() => window.persists), 1);
    const names = () => page.locator('.saved .open').allTextContents();
    assert.deepEqual(await names(), ['My face 3', 'My face 2', 'My face 1']);
    for (const name of ['My face 2', 'My face 1']) await page.getByRole('button', { name: `Delete ${name}` }).click();
    // A name that is taken is not given again, and what was deleted is not forgotten for a save.
    await page.getByRole('button', { name: 'Rename My face 3' }).click();
    await page.keyboard.type('My face 2');
    await page.keyboard.press('Enter');
    await save.click();
    assert.deepEqual(await names(), ['My face 3', 'My face 2']);
    const undo = page.locator('.restore').getByRole('button', { name: 'Undo' });
    await page.getByText('Deleted “My face 1”.').waitFor();
    await undo.click();
    await page.getByText('Deleted “My face 2”.').waitFor();
    await undo.click();
    assert.equal(await undo.count(), 0);
    assert.deepEqual(await names(), ['My face 3', 'My face 2', 'My face 2 (2)', 'My face 1']);

    // What composes a word of several keys takes Enter and Escape for itself.
    await page.getByRole('button', { name: 'Rename My face 3' }).click();
    const box = page.locator('.saved input');
    await box.fill('Tarō');
    for (const key of ['Enter', 'Escape']) {
      await box.evaluate((box, key) => box.dispatchEvent(new KeyboardEvent('keydown', { key, isComposing: true, bubbles: true })), key);
      assert.equal(await box.inputValue(), 'Tarō');
    }
    await box.press('Enter');
    assert.equal((await names())[0], 'Tarō');

    const stranger = { id: 'own-stranger', name: 'Stranger', code: 'AAAAAAAA' };
    await page.evaluate((stranger) => {
      const key = Object.keys(localStorage).find((name) => name.startsWith('phiz-faces-'));
      localStorage.setItem(key, JSON.stringify([...JSON.parse(localStorage.getItem(key)), stranger]));
    }, stranger);
    await page.reload();
    await ready(page);
    await page.getByRole('tab', { name: 'Faces' }).click();
    const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download all' }).click()]);
    assert.equal(file.suggestedFilename(), 'faces.phiz.json');
    const content = readFileSync(await file.path(), 'utf8');
    assert.deepEqual(JSON.parse(content).map(({ name }) => name), [...(await names()), 'Stranger']);
    const before = await codeOf(page);
    const give = (/** @type {string} */ body) =>
      page.locator('input[type=file][accept*=json]').setInputFiles({ name: 'faces.json', mimeType: 'application/json', buffer: Buffer.from(body) });
    await page.getByRole('button', { name: 'Delete Tarō' }).click();
    await give(content);
    await says('One face was added to yours; 3 were there; 1 is of another model or damaged.');
    assert.equal((await names())[0], 'Tarō');
    await give(content);
    await says('No face of it is new; 1 is of another model or damaged.');
    assert.equal((await names()).length, 4);
    assert.equal(await codeOf(page), before, 'who is worked on stays');
    await give('[]');
    await page.waitForFunction(() => /faces\.json is not a face from this page/.test(document.querySelector('.toast')?.textContent ?? ''));

    // A picture of a kind that the browser does not know has no type.
    await page.evaluate(() => {
      const files = new DataTransfer();
      files.items.add(new File(['nothing'], 'IMG_1.HEIC', { type: '' }));
      window.dispatchEvent(new DragEvent('drop', { dataTransfer: files, bubbles: true, cancelable: true }));
    });
    await page.waitForFunction(() => document.querySelector('#mode-photo')?.getAttribute('aria-selected') === 'true');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('faces are saved, renamed, deleted, brought back, and go through files', async () => {
    const { context, page, complaints } = await open(browser, site, { drawn: true });
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

    // A name ends with Enter, and with a press of anything else, which is done as well.
    await page.getByRole('button', { name: 'Rename Old sailor' }).click();
    await page.keyboard.type('Sai');
    // Another tab saves meanwhile.
    await page.evaluate(() => window.dispatchEvent(new StorageEvent('storage', { key: Object.keys(localStorage).find((name) => name.startsWith('phiz-faces-')) })));
    await page.keyboard.type('lor');
    await page.getByRole('button', { name: 'Rename My face 2' }).click();
    await page.keyboard.type('Somebody');
    await page.getByRole('button', { name: 'Delete Sailor' }).click();
    await page.locator('.restore').getByRole('button', { name: 'Undo' }).click();
    await page.getByRole('button', { name: 'Rename Somebody' }).click();
    await page.keyboard.type('My face 2');
    await page.keyboard.press('Tab');
    await page.getByRole('button', { name: 'Open My face 2' }).waitFor();
    await page.getByRole('button', { name: 'Rename Sailor' }).click();
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
      other.page.locator('input[type=file][accept*=json]').setInputFiles({ name, mimeType: 'application/json', buffer: Buffer.from(body) });
    await give('sailor.json', JSON.stringify(content));
    await other.page.getByRole('button', { name: 'Open Young sailor' }).waitFor();
    assert.equal(await codeOf(other.page), mine);
    for (const [name, body, sentence] of [
      ['notes.json', 'dear diary', /notes\.json is not a face from this page\. Faces saved here \(\.json\) and photos can be opened\./],
      ['empty.json', '', /empty\.json is not a face/],
      ['list.json', '[1, 2]', /list\.json is not a face/],
      ['null.json', 'null', /null\.json is not a face/],
      ['cut.json', JSON.stringify({ ...content, code: content.code.slice(0, -3) }), /cut\.json is damaged: ./],
      ['new.json', JSON.stringify({ ...content, version: 9 }), /new\.json was written by a newer version of this page/],
      ['theirs.json', JSON.stringify({ ...content, model: 'Cats', code: 'AAAAAAAA' }), /face of another model, “Cats”/],
      ['old.json', JSON.stringify({ ...content, version: undefined }), /old\.json is damaged: it does not say of which version it is\./],
      ['long.json', 'x'.repeat(21_000_000), /long\.json is not a face: it is far too big\. Faces saved here/],
    ]) {
      await give(name, body);
      await other.page.waitForFunction(
        (source) => new RegExp(source).test(document.querySelector('.toast')?.textContent ?? ''),
        sentence.source,
      );
      assert.equal(await codeOf(other.page), mine, `${name} changed the face`);
      assert.equal(await other.page.locator('.saved li').count(), 1, `${name} changed the list`);
    }
    // What is there is not there twice; of several files each is told of.
    await give('again.json', JSON.stringify(content));
    await other.page.getByText('Opened “Young sailor”, which is among your faces.').waitFor();
    assert.equal(await other.page.locator('.saved li').count(), 1);
    await other.page.evaluate(() => {
      const { setTimeout } = window;
      window.delays = [];
      window.setTimeout = (what, delay, ...more) => {
        window.delays.push(delay ?? 0);
        return setTimeout(what, delay, ...more);
      };
    });
    await other.page.locator('input[type=file][accept*=json]').setInputFiles(
      [
        ['notes.json', 'dear diary'],
        ['mate.json', JSON.stringify({ ...content, name: 'Mate' })],
        ['crew.json', JSON.stringify([content, { ...content, version: 9 }])],
      ].map(([name, body]) => ({ name, mimeType: 'application/json', buffer: Buffer.from(body) })),
    );
    await other.page
      .getByText('One face was added to yours; 1 was there; 1 is of a newer version of this page: reload to get it. notes.json is not a face from this page. Faces saved here (.json) and photos can be opened.')
      .waitFor();
    assert.deepEqual(await other.page.locator('.saved .open').allTextContents(), ['Mate', 'Young sailor']);
    assert.ok(await other.page.evaluate(() => Math.max(...window.delays)) > 10_000, 'a long sentence goes before it can be read');
    await other.page.getByRole('button', { name: 'Delete Mate' }).click();
    // Files have the name that the face was saved under, as long as it is that face.
    const written = async () => {
      await other.page.getByRole('button', { name: 'Take the face with you' }).click();
      const [file] = await Promise.all([other.page.waitForEvent('download'), other.page.getByRole('button', { name: 'STL' }).click()]);
      await other.page.getByRole('button', { name: 'Close', exact: true }).last().click();
      return file.suggestedFilename();
    };
    assert.equal(await written(), 'young-sailor.stl');
    await other.page.getByRole('button', { name: 'Random face', exact: true }).click();
    assert.equal(await written(), 'face.stl');
    assert.deepEqual([...complaints, ...other.complaints], []);
    await other.context.close();

    // What is saved survives the page, and what is locked, though the address has the face as well.
    await page.keyboard.press('Control+z');
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.getByRole('button', { name: 'Lock the nose' }).click();
    await page.getByRole('tab', { name: 'Lengths' }).click();
    await page.getByRole('button', { name: 'Lock the mouth width' }).click();
    assert.equal(new URL(page.url()).hash, `#${await codeOf(page)}`);
    await page.reload();
    await ready(page);
    assert.deepEqual(await locks(page), [['nose'], ['mouth width']]);
    await page.evaluate(() => window.designer.face.unlockMeasure('mouth width'));
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('button', { name: 'Open My face 2' }).click();
    assert.equal(await codeOf(page), random);
    await context.close();
  });

  test('no two faces have one name: the later gets a number, and is told of it', async () => {
    const { context, page, complaints } = await open(browser, site);
    const names = () => page.locator('.saved .open').evaluateAll((all) => all.map((one) => one.getAttribute('aria-label')));
    const keepAs = async (/** @type {string} */ name) => {
      await page.getByRole('textbox', { name: 'Save this face as' }).fill(name);
      await page.keyboard.press('Enter');
    };
    await moveSlider(page, 'nose 1', 0.9);
    await page.getByRole('tab', { name: 'Faces' }).click();
    await keepAs('Ann');
    assert.equal(await toast(page), 'Saved as “Ann”');
    const first = await codeOf(page);
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    const second = await codeOf(page);
    await keepAs('Ann');
    assert.equal(await toast(page), 'Another face is called “Ann”: saved as “Ann (2)”');
    assert.deepEqual(await names(), ['Open Ann (2)', 'Open Ann']);
    await page.getByRole('button', { name: 'Open Ann', exact: true }).click();
    assert.equal(await codeOf(page), first);
    await page.getByRole('button', { name: 'Open Ann (2)', exact: true }).click();
    assert.equal(await codeOf(page), second);
    // Nor by another name.
    await keepAs('Bea');
    await page.getByRole('button', { name: 'Rename Bea' }).click();
    await page.keyboard.type('Ann');
    await page.keyboard.press('Enter');
    assert.equal(await toast(page), 'Another face is called “Ann”: saved as “Ann (3)”');
    assert.deepEqual(await names(), ['Open Ann (3)', 'Open Ann (2)', 'Open Ann']);
    // One that was deleted comes back beside who has its name by then.
    await page.getByRole('button', { name: 'Delete Ann (3)' }).click();
    await keepAs('Ann (3)');
    await page.locator('.restore').getByRole('button', { name: 'Undo' }).click();
    assert.deepEqual(await names(), ['Open Ann (3)', 'Open Ann (4)', 'Open Ann (2)', 'Open Ann']);
    await page.getByRole('button', { name: 'Delete Ann (4)' }).click();
    // Nor from a file, which brings nobody twice.
    const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download all' }).click()]);
    const all = JSON.parse(readFileSync(await file.path(), 'utf8'));
    assert.equal(all.length, 3);
    const give = (/** @type {unknown} */ content) =>
      page.locator('input[type=file][accept*=json]').setInputFiles({ name: 'faces.json', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify(content)) });
    const cleos = all.map((face, i) => ({ ...face, name: 'Cleo', colouring: { skin: 0.1 * (i + 5) } }));
    await give(cleos);
    await page.waitForFunction(() => document.querySelector('.toast')?.textContent === '3 faces were added to yours.');
    assert.deepEqual((await names()).slice(0, 3), ['Open Cleo', 'Open Cleo (2)', 'Open Cleo (3)']);
    await give(cleos);
    await page.waitForFunction(() => document.querySelector('.toast')?.textContent === 'No face of it is new.');
    assert.equal((await names()).length, 6);
    await give({ ...cleos[0], colouring: { skin: 0.9 } });
    await page.waitForFunction(() => document.querySelector('.toast')?.textContent === 'Opened “Cleo (4)” and added it to your faces.');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('who saves a face again under its name may have it in place of the former, which can be brought back', async () => {
    const { context, page, complaints } = await open(browser, site);
    const names = () => page.locator('.saved .open').allTextContents();
    const keepAs = async (/** @type {string} */ name) => {
      await page.getByRole('textbox', { name: 'Save this face as' }).fill(name);
      await page.keyboard.press('Enter');
    };
    const shape = async (/** @type {number} */ value) => {
      await page.getByRole('tab', { name: 'Features' }).click();
      await moveSlider(page, 'nose 1', value);
      await page.getByRole('tab', { name: 'Faces' }).click();
    };
    const instead = page.getByRole('button', { name: 'Put it in place of “Ann”' });
    await page.getByRole('tab', { name: 'Faces' }).click();
    await keepAs('Bea');
    await shape(0.9);
    await keepAs('Ann');
    assert.equal(await instead.count(), 0, 'nobody else is called so');
    const first = await codeOf(page);
    await shape(0.1);
    await keepAs('Ann');
    assert.deepEqual(await names(), ['Ann (2)', 'Ann', 'Bea']);
    const second = await codeOf(page);
    await instead.click();
    assert.deepEqual(await names(), ['Ann', 'Bea']);
    assert.equal(await toast(page), 'Saved as “Ann”, in place of the former');
    assert.equal(await instead.isVisible(), false);
    // Also for who does it by keyboard: what was done can be undone at once.
    await page.keyboard.press('Enter');
    assert.deepEqual(await names(), ['Ann', 'Ann (2)', 'Bea']);
    await page.getByRole('button', { name: 'Open Ann (2)' }).click();
    assert.equal(await codeOf(page), first);
    await page.getByRole('button', { name: 'Open Ann', exact: true }).click();
    assert.equal(await codeOf(page), second);
    // What was asked of a name is not asked of another.
    await keepAs('Ann');
    assert.ok(await instead.isVisible());
    await page.getByRole('button', { name: 'Rename Ann', exact: true }).click();
    await page.keyboard.type('Cleo');
    await page.keyboard.press('Enter');
    assert.equal(await instead.isVisible(), false);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('a saved face keeps its expression, in the browser and in a file; one from before says nothing of it', async () => {
    const { context, page, complaints } = await open(browser, site);
    const shown = (/** @type {any} */ page) =>
      page.evaluate(() => Object.fromEntries(Object.entries(window.designer.face.expression).map(([name, weight]) => [name, Math.round(100 * weight)])));
    const smile = { mouthSmileLeft: 80, mouthSmileRight: 80 };
    await page.getByRole('tab', { name: 'Expressions' }).click();
    await page.getByRole('slider', { name: 'mouthSmile' }).first().waitFor({ timeout: 60_000 });
    await moveSlider(page, 'Smile mouthSmile', 0.8);
    const code = await codeOf(page);
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('textbox', { name: 'Save this face as' }).fill('Smiler');
    await page.keyboard.press('Enter');
    const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download Smiler' }).click()]);
    const path = join(SCREENSHOTS, 'smiler.json');
    await file.saveAs(path);
    const content = JSON.parse(readFileSync(path, 'utf8'));
    assert.equal(content.version, 2);
    assert.deepEqual(content.expression, { mouthSmileLeft: 0.8, mouthSmileRight: 0.8 });

    // A face at rest, saved, opens at rest; the smiler smiles; both are steps.
    await page.getByRole('button', { name: 'Reset all' }).click();
    await page.getByRole('button', { name: 'Save', exact: true }).click();
    const wait = (/** @type {any} */ page, /** @type {Record<string, number>} */ wanted) =>
      page.waitForFunction(
        (count) => Object.keys(window.designer.face.expression).length === count,
        Object.keys(wanted).length,
      );
    await page.getByRole('button', { name: 'Open Smiler' }).click();
    await wait(page, smile);
    assert.deepEqual(await shown(page), smile);
    await page.getByRole('button', { name: 'Open My face 2' }).click();
    assert.deepEqual(await shown(page), {});
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(await shown(page), smile);

    // One shape that was saved at rest and with a smile is called by what it shows.
    const written = async () => {
      await page.getByRole('button', { name: 'Take the face with you' }).click();
      const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'STL' }).click()]);
      await page.getByRole('button', { name: 'Close', exact: true }).last().click();
      return file.suggestedFilename();
    };
    assert.equal(await written(), 'smiler.stl');
    await page.getByRole('button', { name: 'Open My face 2' }).click();
    assert.equal(await written(), 'my-face-2.stl');

    // To mix takes the shape alone, and says so.
    await page.getByRole('button', { name: 'Reset all' }).click();
    await page.getByRole('tab', { name: 'Mix' }).click();
    await page.locator('.tray').getByRole('button', { name: 'Smiler' }).click();
    await page.getByText('Only its shape is mixed in').waitFor();
    await page.getByRole('button', { name: 'Take over' }).click();
    assert.deepEqual(await shown(page), {});
    await page.getByLabel('To', { exact: true }).selectOption({ label: 'Smiler' });
    await page.getByText('Morphs use shape only').waitFor();

    // The page again, without the panel having been opened: the expressions come with the face.
    await page.reload();
    await ready(page);
    await page.getByRole('tab', { name: 'Faces' }).click();
    // On a slow line what was opened last is what is shown.
    const come = await holdBack(page, '**/expressions.phiz');
    await page.getByRole('button', { name: 'Open Smiler' }).click();
    await page.getByRole('button', { name: 'Open My face 2' }).click();
    come();
    await page.waitForFunction(() => window.designer.model.expressions.length > 0);
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(done)));
    assert.deepEqual(await shown(page), {});
    await page.getByRole('button', { name: 'Open Smiler' }).click();
    await wait(page, smile);
    assert.deepEqual([await codeOf(page), await shown(page)], [code, smile]);

    // Files: the new one, one with an expression that nobody has, and the old ones, which leave what there is.
    const give = (/** @type {object} */ body) =>
      page.locator('input[type=file][accept*=json]').setInputFiles({ name: 'face.json', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify(body)) });
    await give({ ...content, name: 'Odd', expression: { jawOpen: 0.5, wiggleEars: 1, mouthClose: 'much', browInnerUp: -1 } });
    await page.getByRole('button', { name: 'Open Odd' }).waitFor();
    await wait(page, { jawOpen: 50 });
    assert.deepEqual(await shown(page), { jawOpen: 50 });
    const { expression, ...old } = content;
    await give({ ...old, version: 1, name: 'Old' });
    await page.getByRole('button', { name: 'Open Old' }).waitFor();
    assert.deepEqual(await shown(page), { jawOpen: 50 });
    await give({ ...content, name: 'Calm', expression: {} });
    await page.getByRole('button', { name: 'Open Calm' }).waitFor();
    await wait(page, {});
    // A face that the browser kept before there were expressions, and one of a model that was trained before this one.
    const stranger = { id: 'own-stranger', name: 'Stranger', code: 'AAAAAAAA', expression: { smirk: 1 } };
    await page.evaluate((stranger) => {
      const key = Object.keys(localStorage).find((name) => name.startsWith('phiz-faces-'));
      const kept = JSON.parse(localStorage.getItem(key));
      localStorage.setItem(key, JSON.stringify([stranger, ...kept.map(({ id, name, code }) => ({ id, name, code }))]));
    }, stranger);
    await page.reload();
    await ready(page);
    await page.getByRole('tab', { name: 'Faces' }).click();
    await page.getByRole('button', { name: 'Open Smiler' }).click();
    assert.deepEqual([await codeOf(page), await shown(page)], [code, {}]);
    assert.equal(await toast(page), 'One of your faces is of another version of this model and cannot be shown here. The browser keeps it.');
    await page.getByRole('button', { name: 'Delete Odd' }).click();
    const last = await page.evaluate(() => {
      const key = Object.keys(localStorage).find((name) => name.startsWith('phiz-faces-'));
      return JSON.parse(localStorage.getItem(key)).at(-1);
    });
    assert.deepEqual(last, stranger, 'what cannot be read is written back');
    assert.deepEqual(complaints, []);
    await context.close();
  });
});
