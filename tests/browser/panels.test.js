// Small things that a panel owes to who uses it.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { moveSlider, onePage, open, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

describe('the panels of one page', () => {
  const visit = onePage(browser, site);

  test('without a connection a part that never came says that it needs one, once', async () => {
    const { page } = visit;
    await page.route(/\/(room|export|gif)-[^/]*\.(js|css)$/, (route) => route.abort());
    await page.getByRole('tab', { name: 'Photo' }).click();
    const said = page.locator('.photo-panel [role=status]');
    await page.waitForFunction(() => /could not/.test(document.querySelector('.photo-panel [role=status]')?.textContent ?? ''));
    assert.equal(await said.textContent(), 'The photo tools could not be loaded: this needs a connection once.');
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    await page.getByRole('button', { name: 'STL' }).click();
    await page.getByText('The file could not be written: this needs a connection once.').waitFor();
    await page.getByRole('button', { name: 'Close', exact: true }).last().click();
    // It may come later.
    await page.unroute(/\/(room|export|gif)-[^/]*\.(js|css)$/);
    await page.getByRole('button', { name: 'Try again' }).click();
    await page.getByRole('button', { name: 'Choose a photo' }).waitFor();
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'STL' }).click()]);
    assert.equal(file.suggestedFilename(), 'face.stl');
    await page.getByRole('button', { name: 'Close', exact: true }).last().click();
  });

  test('what is dropped and is neither a face nor a photo is told what is', async () => {
    const { page } = visit;
    await page.evaluate(() => {
      const files = new DataTransfer();
      files.items.add(new File(['dear diary'], 'notes.txt', { type: 'text/plain' }));
      window.dispatchEvent(new DragEvent('drop', { dataTransfer: files, bubbles: true, cancelable: true }));
    });
    await page.getByText('notes.txt is not a face from this page. Faces saved here (.json) and photos can be opened.').waitFor();
  });

  test('the key that hides hair is the stage’s alone, and its button says so', async () => {
    const { page } = visit;
    await page.getByRole('tab', { name: 'Looks' }).click();
    await page.getByRole('button', { name: 'Bob', exact: true }).click();
    const hide = page.getByRole('button', { name: 'Hide the hair' });
    assert.match((await hide.getAttribute('title')) ?? '', /On the face, the key is H\./);
    await page.keyboard.press('h');
    assert.equal(await hide.getAttribute('aria-pressed'), 'false', 'a key on another control');
    // Who has clicked the button goes on with the key.
    await hide.click();
    assert.equal(await hide.getAttribute('aria-pressed'), 'true');
    await page.keyboard.press('h');
    assert.equal(await hide.getAttribute('aria-pressed'), 'false');
    await page.locator('.view').focus();
    await page.keyboard.press('h');
    assert.equal(await hide.getAttribute('aria-pressed'), 'true');
  });
});

test('where the person has chosen all colours, tracks and what is pressed are there', async () => {
  const { context, page, complaints } = await open(browser, site, { forcedColors: 'active' });
  await moveSlider(page, 'nose 1', 0.9);
  const colours = (/** @type {string} */ selector) =>
    page.locator(selector).first().evaluate((it) => {
      const { backgroundColor, backgroundImage, borderBottomColor } = getComputedStyle(it);
      return { backgroundColor, backgroundImage, borderBottomColor };
    });
  const panel = (await colours('.panel')).backgroundColor;
  const [line, fill] = [await colours('#section-features .line'), await colours('#section-features .fill')];
  assert.equal(new Set([panel, line.backgroundColor, fill.backgroundColor]).size, 3, 'the panel, a track, what of it is filled');
  for (const selector of ['.tab', '.mode']) {
    const [chosen, other] = [await colours(`${selector}:is([aria-pressed=true], [aria-selected=true])`), await colours(`${selector}:not([aria-pressed=true], [aria-selected=true])`)];
    assert.notEqual(chosen.backgroundColor, other.backgroundColor, selector);
  }
  assert.equal((await colours('.mode[aria-selected=false]')).borderBottomColor, panel, 'no line under what is not chosen');
  await page.getByRole('tab', { name: 'Looks' }).click();
  assert.match((await colours('.colours .line')).backgroundImage, /gradient/);
  assert.deepEqual(complaints, []);
  await context.close();
});

test('what is chosen is in sight on a phone on its side, and after the letters have grown', async () => {
  const { context, page } = await open(browser, site, { viewport: { width: 844, height: 390 }, hasTouch: true, isMobile: true });
  /** How much of the chosen one's row is between it and the nearer end, px; less than 0 when it is cut. */
  const room = (/** @type {string} */ row) =>
    page.locator(row).evaluate((it) => {
      const chosen = it.querySelector('[aria-pressed=true], [aria-selected=true]').getBoundingClientRect();
      const { left, right } = it.getBoundingClientRect();
      return Math.min(chosen.left - left, right - chosen.right);
    });
  assert.ok((await room('.tabs')) >= 0, 'the nose of a new face');
  await page.getByRole('tab', { name: 'Photo' }).tap();
  assert.ok((await room('.modes')) >= 0);
  await page.getByRole('tab', { name: 'Features' }).tap();
  assert.ok((await room('.modes')) >= 0, 'back from the last');
  await page.getByRole('tab', { name: 'Mix' }).tap();
  await page.evaluate(() => (document.documentElement.style.fontSize = '200%'));
  await page.waitForFunction(() => document.querySelector('.modes').scrollWidth > 2 * document.querySelector('.modes').clientWidth);
  await page.evaluate(() => new Promise((laid) => requestAnimationFrame(() => requestAnimationFrame(laid))));
  assert.ok((await room('.modes')) >= 0, 'in large letters');
  await context.close();
});
