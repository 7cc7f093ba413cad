import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { moveSlider, open, SCREENSHOTS, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

/** Names that are read otherwise than the model has them. */
const SAID = { 'eyes size': 'eye size', 'eyes length': 'eye width', 'eyes vertical position': 'eye vertical position', 'left eye length': 'left eye width', 'right eye length': 'right eye width' };
const said = (/** @type {string} */ name) => SAID[name] ?? name;

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
      const words = await page.getByRole('slider', { name: said(each.name), exact: true }).getAttribute('aria-valuetext');
      const mm = await page.evaluate((m) => window.designer.face.measure(m), each.measure);
      assert.match(words ?? '', new RegExp(`^${mm.toFixed(1).replace('.', '\\.').replace('-', '−')} mm, \\d+(st|nd|rd|th)$`));
    }
    // A new face is the middle that they go back to, wherever people have theirs.
    const section = page.locator('#section-meanings');
    assert.equal(await section.locator('.is-moved').count(), 0);
    const last = meanings[meanings.length - 1];
    const lastLength = () => page.evaluate((m) => window.designer.face.measure(m), last.measure);
    const middle = await lastLength();
    await moveSlider(page, said(last.name), 0.9);
    assert.equal(await section.locator('.is-moved').count() > 0, true);
    await page.getByRole('slider', { name: said(last.name), exact: true }).press('Delete');
    assert.ok(Math.abs((await lastLength()) - middle) < 0.03, `${await lastLength()} mm, not ${middle}`);
    await page.getByRole('button', { name: 'Reset all' }).click();

    const length = () => page.evaluate((m) => window.designer.face.measure(m), measure);
    const start = await length();
    const goal = Number((start + 2).toFixed(1));
    const typed = page.getByRole('spinbutton', { name: `${said(measure)} in mm`, exact: true });
    const type = async (/** @type {number} */ mm) => {
      await page.getByRole('slider', { name: said(name), exact: true }).focus();
      await page.keyboard.press('Enter');
      await typed.fill(String(mm));
      await page.keyboard.press('Enter');
    };
    await type(goal);
    // The contract of `setMeasure` is a hundredth of a millimetre.
    assert.ok(Math.abs((await length()) - goal) <= 0.011, `${await length()}, not ${goal}`);
    const lock = page.getByRole('button', { name: `Lock the ${said(measure)}`, exact: true });
    await lock.click();
    assert.equal(await lock.getAttribute('aria-pressed'), 'true');
    await moveSlider(page, said(second.name), 0.9);
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    assert.ok(Math.abs((await length()) - goal) <= 0.011, `the lock did not hold: ${await length()}, not ${goal}`);
    await page.screenshot({ path: join(SCREENSHOTS, 'meanings.png') });
    // One step back after the other, with the lock in between.
    const undo = page.getByRole('button', { name: 'Undo', exact: true });
    for (let i = 0; i < 3; i++) await undo.click();
    assert.equal(await lock.getAttribute('aria-pressed'), 'false');
    assert.ok(Math.abs((await length()) - goal) <= 0.011);
    await page.getByRole('button', { name: `Undo what ${said(name)} did`, exact: true }).click();
    assert.ok(Math.abs((await length()) - start) < 0.2, `cleared it is ${await length()}, it was ${start}`);
    // A length that no face has is refused in one sentence, or reached; never half of either.
    await type(0.1);
    const after = await length();
    const told = (await page.locator('.toast').textContent()) ?? '';
    assert.ok(Math.abs(after - 0.1) <= 0.011 || /^That cannot be done: .+/.test(told), `${after} mm, “${told}”`);
  }
  assert.deepEqual(complaints, []);
  await context.close();
});

test('a length stops where its part has no room, and goes on once that is unlocked', async () => {
  const { context, page, complaints } = await open(browser, site);
  const [name, limits] = await page.evaluate(() => {
    const controls = window.designer.model.controls.filter(({ measure }) => measure);
    const { name, limits } = controls.reduce((a, b) => (a.limits[1] < b.limits[1] ? a : b));
    return /** @type {const} */ ([name, limits]);
  });
  assert.ok(limits[1] < 0.97, `${name} has room up to ${limits[1]}`);
  await page.getByRole('tab', { name: 'Lengths' }).click();
  const slider = page.getByRole('slider', { name: said(name), exact: true });
  const stands = () => page.evaluate((control) => window.designer.face.get(control), name);
  await slider.press('End');
  // A slider goes by thousandths, and a length is met to a hundredth of a millimetre.
  assert.ok(Math.abs((await stands()) - limits[1]) < 0.003, `${name} is at ${await stands()}, its end is ${limits[1]}`);
  await slider.press('Delete');
  // A pointer on the rest of the track gets no farther.
  const box = /** @type {{ x: number, y: number, width: number, height: number }} */ (await slider.boundingBox());
  await page.mouse.click(box.x + box.width - 2, box.y + box.height / 2);
  assert.ok(Math.abs((await stands()) - limits[1]) < 0.003, `${name} is at ${await stands()}, its end is ${limits[1]}`);
  await page.locator('#section-meanings').getByLabel('Go beyond people').check();
  await slider.press('ArrowRight');
  await slider.press('PageUp');
  assert.ok((await stands()) > limits[1] + 0.02, `${name} is at ${await stands()} once unlocked`);
  assert.deepEqual(complaints, []);
  await context.close();
});
