// Small things that a panel owes to who uses it.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { onePage, siteAndBrowser } from './site.js';

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
