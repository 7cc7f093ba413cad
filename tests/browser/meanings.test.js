import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { moveSlider, open, SCREENSHOTS, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

test('meanings are there exactly when the model has them: lengths are typed, locked and cleared', async () => {
  const { context, page, complaints } = await open(browser, site);
  const meanings = await page.evaluate(() =>
    window.designer.model.controls.filter(({ measure }) => measure).map(({ name, measure }) => ({ name, measure })),
  );
  const tab = page.getByRole('tab', { name: 'Lengths' });
  assert.equal(await tab.count(), meanings.length ? 1 : 0);
  if (meanings.length) {
    const [{ name, measure }, second] = meanings;
    await tab.click();
    for (const each of meanings) {
      const words = await page.getByRole('slider', { name: each.name, exact: true }).getAttribute('aria-valuetext');
      const mm = await page.evaluate((m) => window.designer.face.measure(m), each.measure);
      assert.match(words ?? '', new RegExp(`^${mm.toFixed(1).replace('.', '\\.')} mm, \\d+(st|nd|rd|th)$`));
    }
    const length = () => page.evaluate((m) => window.designer.face.measure(m), measure);
    const start = await length();
    const goal = Number((start + 2).toFixed(1));
    const typed = page.getByRole('spinbutton', { name: `${measure} in mm`, exact: true });
    const type = async (/** @type {number} */ mm) => {
      await page.getByRole('slider', { name, exact: true }).focus();
      await page.keyboard.press('Enter');
      await typed.fill(String(mm));
      await page.keyboard.press('Enter');
    };
    await type(goal);
    // The contract of `setMeasure` is a hundredth of a millimetre.
    assert.ok(Math.abs((await length()) - goal) <= 0.011, `${await length()}, not ${goal}`);
    const lock = page.getByRole('button', { name: `Lock the ${measure}`, exact: true });
    await lock.click();
    assert.equal(await lock.getAttribute('aria-pressed'), 'true');
    await moveSlider(page, second.name, 0.9);
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    assert.ok(Math.abs((await length()) - goal) <= 0.011, `the lock did not hold: ${await length()}, not ${goal}`);
    await page.screenshot({ path: join(SCREENSHOTS, 'meanings.png') });
    // One step back after the other, with the lock in between.
    const undo = page.getByRole('button', { name: 'Undo', exact: true });
    for (let i = 0; i < 3; i++) await undo.click();
    assert.equal(await lock.getAttribute('aria-pressed'), 'false');
    assert.ok(Math.abs((await length()) - goal) <= 0.011);
    await page.getByRole('button', { name: `Undo what ${name} did`, exact: true }).click();
    assert.ok(Math.abs((await length()) - start) < 0.2, `cleared it is ${await length()}, it was ${start}`);
    // A length that no face has is refused in one sentence, or reached; never half of either.
    await type(0.1);
    const after = await length();
    const said = (await page.locator('.toast').textContent()) ?? '';
    assert.ok(Math.abs(after - 0.1) <= 0.011 || /^That cannot be done: .+/.test(said), `${after} mm, “${said}”`);
  }
  assert.deepEqual(complaints, []);
  await context.close();
});
