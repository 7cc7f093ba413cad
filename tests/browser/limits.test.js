// Sliders end where people do, until somebody wants to go on.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { differing, moveSlider, open, picture, pictureOfPage, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

/** The coefficient that a mode's slider moves, in standard deviations. */
const sigmas = (page, control) =>
  page.evaluate((name) => {
    const { model, face } = window.designer;
    const probe = model.face();
    probe.set(name, 0);
    const low = probe.coefficients;
    probe.set(name, 1);
    const at = probe.coefficients.findIndex((value, i) => value !== low[i]);
    probe.free();
    return face.coefficients[at];
  }, control);

/** Opens "Advanced", where the box is. @param {import('playwright-core').Page} page */
async function unlock(page) {
  const box = page.locator('.features').getByLabel('Go beyond people');
  if (!(await box.isVisible())) await page.getByText('Advanced').click();
  await box.check();
}

describe('limits', () => {
  for (const [device, options] of /** @type {const} */ ([
    ['desktop', {}],
    ['phone', { viewport: { width: 320, height: 640 }, hasTouch: true, isMobile: true, colorScheme: 'dark' }],
  ])) {
    test(`a mode goes beyond people only once it is unlocked, on a ${device}`, async () => {
      const { context, page, complaints } = await open(browser, site, { sharp: true, ...options });
      const slider = page.getByRole('slider', { name: 'nose 1', exact: true });
      await slider.focus();
      await page.keyboard.press('End');
      await page.keyboard.press('ArrowRight');
      assert.ok(Math.abs((await sigmas(page, 'nose 1')) - 3) < 0.01, 'three, and no more');
      const most = await picture(page, `limits-${device}-most`);
      assert.equal(await page.locator('.is-beyond').count(), 0);

      await unlock(page);
      // The same face on a longer track.
      assert.ok(Math.abs((await sigmas(page, 'nose 1')) - 3) < 0.01);
      await slider.scrollIntoViewIfNeeded();
      const box = await slider.boundingBox();
      assert.ok(box);
      // Three standard deviations are at three quarters now; four and a half at seven eighths.
      const at = (/** @type {number} */ part) => 12 + part * (box.width - 24) + box.x;
      await page.mouse.move(at(0.75), box.y + box.height - 12);
      await page.mouse.down();
      await page.mouse.move(at(0.8), box.y + box.height - 12);
      await page.mouse.move(at(0.875), box.y + box.height - 12, { steps: 3 });
      await page.mouse.up();
      const beyond = await sigmas(page, 'nose 1');
      assert.ok(beyond > 4.2 && beyond < 4.8, `${beyond} sigmas`);
      assert.match((await slider.getAttribute('aria-valuetext')) ?? '', /^\+4\.\d σ, beyond people$/);
      assert.equal(await page.locator('.is-beyond').count(), 1, 'and it shows');
      await pictureOfPage(page, `limits-${device}-page`);
      const far = await picture(page, `limits-${device}-beyond`);
      assert.ok(differing(most, far) > 60, `${differing(most, far)} pixels`);

      // The link has it, and a page that is not unlocked shows where it stands.
      const other = await open(browser, site, { ...options, hash: new URL(page.url()).hash });
      assert.ok(Math.abs((await sigmas(other.page, 'nose 1')) - beyond) < 1e-4);
      assert.equal(await other.page.locator('.is-beyond').count(), 1);
      await other.context.close();

      // Typed in standard deviations.
      await slider.focus();
      await page.keyboard.press('Enter');
      await page.getByRole('spinbutton', { name: 'nose 1 in standard deviations' }).fill('-5.25');
      await page.keyboard.press('Enter');
      assert.ok(Math.abs((await sigmas(page, 'nose 1')) + 5.25) < 0.01);
      await page.getByRole('button', { name: 'Undo', exact: true }).click();
      assert.ok(Math.abs((await sigmas(page, 'nose 1')) - beyond) < 1e-4, 'one step each');
      await page.getByRole('button', { name: 'Undo', exact: true }).click();
      assert.ok(Math.abs((await sigmas(page, 'nose 1')) - 3) < 0.01);
      assert.deepEqual(complaints, []);
      await context.close();
    });
  }

  test('a length goes beyond people by its slider, and what is held or locked stays so', async () => {
    const { context, page, complaints } = await open(browser, site);
    const length = (/** @type {string} */ name) => page.evaluate((measure) => window.designer.face.measure(measure), name);
    await page.getByRole('tab', { name: 'Lengths' }).click();
    await page.getByRole('button', { name: 'Lock the nose width' }).click();
    const held = await length('nose width');
    const slider = page.getByRole('slider', { name: 'mouth width', exact: true });
    await moveSlider(page, 'mouth width', 1);
    const most = await length('mouth width');
    assert.equal(await page.locator('.is-beyond').count(), 0, 'a limit is not beyond it');
    await page.locator('#section-meanings').getByLabel('Go beyond people').check();
    await moveSlider(page, 'mouth width', 1.2);
    const beyond = await length('mouth width');
    assert.ok(beyond > most + 1, `${most} mm, ${beyond} mm`);
    assert.match((await slider.getAttribute('aria-valuetext')) ?? '', new RegExp(`^${beyond.toFixed(1)} mm, \\+4\\.2 σ, beyond people$`));
    assert.ok(Math.abs((await length('nose width')) - held) < 0.011);

    // A mode that moves the held length: beyond people it still does not.
    await page.getByRole('tab', { name: 'Features' }).click();
    await moveSlider(page, 'nose 1', 1.25);
    assert.ok((await sigmas(page, 'nose 1')) > 4);
    assert.ok(Math.abs((await length('nose width')) - held) < 0.011, `${await length('nose width')} mm, not ${held}`);

    // One that would move a locked region, too.
    await page.getByRole('button', { name: 'Mouth', exact: true }).click();
    await page.getByRole('button', { name: 'Lock the mouth', exact: true }).click();
    await page.evaluate(() => (window.before = window.designer.face.positions.slice()));
    await page.getByRole('button', { name: 'Head', exact: true }).click();
    await moveSlider(page, 'head 1', 1.25);
    assert.ok((await sigmas(page, 'head 1')) > 4);
    const [mouth, rest] = await page.evaluate(() => {
      const { face, model } = window.designer;
      const most = [0, 0];
      face.positions.forEach((x, i) => {
        const at = model.regionGroups[model.regionOf[(i / 3) | 0]] === 'mouth' ? 0 : 1;
        most[at] = Math.max(most[at], Math.abs(x - window.before[i]));
      });
      return most;
    });
    assert.ok(mouth < 1e-4 && rest > 1, `the mouth ${mouth} mm, the rest ${rest} mm`);
    // All borders at once cannot move beside it.
    const { alpha } = await page.evaluate(() => ({ alpha: window.designer.face.alpha }));
    await page.getByText('Advanced').click();
    await moveSlider(page, 'Blending distance', 0.9);
    assert.equal(await page.evaluate(() => window.designer.face.alpha), alpha);
    await page.getByText('the blending distance moves the borders of all features').waitFor();
    assert.deepEqual(complaints, []);
    await context.close();
  });
});
