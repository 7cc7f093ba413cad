import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { fingerOn, later, moveSlider, open, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

const valueOf = (page, name) => page.evaluate((control) => window.designer.face.get(control), name);
const sliderOf = (page, name) => page.getByRole('slider', { name, exact: true });
const rowOf = (page, name) => page.locator('.control').filter({ has: sliderOf(page, name) });
/** Where the thumb is drawn, 0 at the slider's left end and 1 at its right. */
const thumbAt = async (page, name) => {
  const track = await rowOf(page, name).locator('.track').boundingBox();
  const thumb = await rowOf(page, name).locator('.thumb').boundingBox();
  assert.ok(track && thumb);
  return (thumb.x - track.x) / (track.width - thumb.width);
};

describe('a slider', () => {
  test('is laid out by the size of the change, takes the pointer, keys and numbers, and resets', async () => {
    const { context, page, complaints } = await open(browser, site);
    const value = () => valueOf(page, 'nose 1');
    const slider = sliderOf(page, 'nose 1');

    // Equal steps of the thumb are equal steps of the coefficient: 2.5 % of people are further
    // than two standard deviations, and there the thumb is five sixths of the way.
    const coefficient = () =>
      page.evaluate(() => {
        const { model, face } = window.designer;
        const median = model.face();
        const low = face.coefficients;
        const at = low.findIndex((c, i) => c !== median.coefficients[i]);
        median.free();
        return low[at];
      });
    for (const percentile of [0.05, 0.3, 0.975]) {
      await moveSlider(page, 'nose 1', percentile);
      const sigmas = await coefficient();
      // A pixel of the track is 0.02 standard deviations; the read-out's table has steps of 2 %.
      const drawn = 6 * (await thumbAt(page, 'nose 1')) - 3;
      assert.ok(Math.abs(drawn - sigmas) < 0.06, `${percentile}: thumb at ${drawn}, face at ${sigmas}`);
    }
    const bell = await rowOf(page, 'nose 1').locator('.bell path').getAttribute('d');
    assert.ok((bell ?? '').split('L').length > 40, 'no density behind the track');

    // A drag, seen by what else it moves; the marks go with it.
    await moveSlider(page, 'nose 1', 0.5);
    const box = await slider.boundingBox();
    assert.ok(box);
    const y = box.y + box.height - 9;
    await page.mouse.move(box.x + box.width / 2, y);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.72 * box.width, y, { steps: 4 });
    assert.ok(await rowOf(page, 'nose 1').locator('.ghost').isVisible());
    assert.equal(await rowOf(page, 'nose 2').locator('.ghost').isVisible(), false, 'modes do not move each other');
    assert.match((await page.locator('.measures .change').allTextContents()).join(' '), /[+−]\d/);
    await page.mouse.up();
    assert.equal(await rowOf(page, 'nose 1').locator('.ghost').isVisible(), false);
    assert.equal((await page.locator('.measures .change').allTextContents()).join(''), '');
    assert.ok(Math.abs((await thumbAt(page, 'nose 1')) - 0.72) < 0.03);
    // A drag that follows at once is a step of its own, unlike a run of key presses.
    const dragged = await value();
    await page.mouse.down();
    await page.mouse.move(box.x + 0.4 * box.width, y, { steps: 4 });
    await page.mouse.up();
    assert.ok((await value()) < dragged - 0.1);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await value(), dragged);

    // Typed: click the number.
    await rowOf(page, 'nose 1').getByRole('button').click();
    const typed = page.getByRole('spinbutton', { name: 'Percentile of nose 1' });
    await typed.fill('91.5');
    await typed.press('Enter');
    assert.ok(Math.abs((await value()) - 0.915) < 1e-4);
    await page.keyboard.press('Enter');
    await typed.fill('3');
    await typed.press('Escape');
    assert.ok(Math.abs((await value()) - 0.915) < 1e-4, 'Escape changes nothing');
    // A number that is out of reach goes to the limit; nonsense changes nothing.
    await slider.focus();
    await page.keyboard.press('Enter');
    await typed.fill('400');
    await typed.press('Enter');
    assert.equal(await value(), 1);
    assert.match((await page.getByRole('alert').textContent()) ?? '', /^It ends at 100\. Go beyond people$/);
    assert.equal(await rowOf(page, 'nose 1').locator('.legend').textContent(), 'percentile');
    assert.equal(await page.locator('.features .legend').count(), 1, 'what the number is, is said once');
    await slider.focus();
    await page.keyboard.press('Enter');
    await page.keyboard.type('37,5');
    await page.keyboard.press('Enter');
    assert.ok(Math.abs((await value()) - 0.375) < 1e-4, 'a comma is a point');
    assert.equal(await page.getByRole('alert').count(), 0);
    // As it is written beside the slider.
    await page.keyboard.press('Enter');
    await page.keyboard.type('95th');
    await page.keyboard.press('Enter');
    assert.ok(Math.abs((await value()) - 0.95) < 1e-4, 'a rank is read');
    // What cannot be read stays to be mended, also when one goes elsewhere, until it is left.
    for (const key of ['Enter', 'Tab']) {
      await rowOf(page, 'nose 1').getByRole('button').click();
      await typed.fill('40 mm');
      await typed.press(key);
      assert.equal(await typed.getAttribute('aria-invalid'), 'true');
      assert.equal(await page.getByRole('alert').textContent(), 'Type it like “95”.');
      await typed.press('Escape');
      assert.equal(await typed.isVisible() || (await page.getByRole('alert').count()) > 0, false);
    }
    await rowOf(page, 'nose 1').getByRole('button').click();
    await typed.fill('abc');
    await typed.press('Enter');
    await typed.press('9');
    assert.equal(await typed.getAttribute('aria-invalid'), null, 'being mended');
    assert.ok(Math.abs((await value()) - 0.95) < 1e-4);
    await slider.focus();
    await page.keyboard.press('End');
    assert.equal(await typed.isVisible(), false, 'the slider is another way');

    // Keys: a hundredth, with Shift a tenth; a digit opens the number; Delete resets.
    await slider.focus();
    await page.keyboard.press('Shift+ArrowLeft');
    await page.keyboard.press('ArrowLeft');
    assert.ok(Math.abs((await value()) - 0.89) < 1e-3);
    await page.keyboard.press('4');
    await page.keyboard.press('2');
    await page.keyboard.press('Enter');
    assert.ok(Math.abs((await value()) - 0.42) < 1e-4);
    await slider.focus();
    await page.keyboard.press('Delete');
    assert.ok(Math.abs((await value()) - 0.5) < 1e-4);

    // An open number gives the focus to what is pressed next.
    await rowOf(page, 'nose 1').getByRole('button').click();
    await typed.fill('70');
    /** Where the panel has scrolled to since. @param {number} part */
    const over = async (part) => {
      await sliderOf(page, 'nose 2').scrollIntoViewIfNeeded();
      const second = await sliderOf(page, 'nose 2').boundingBox();
      assert.ok(second);
      await page.mouse.move(second.x + part * second.width, second.y + second.height - 9, { steps: 3 });
    };
    await over(0.5);
    await page.mouse.down();
    await page.mouse.up();
    assert.ok(Math.abs((await value()) - 0.7) < 1e-4, 'what was typed counts');
    const where = await valueOf(page, 'nose 2');
    await page.keyboard.press('Shift+ArrowRight');
    assert.ok((await valueOf(page, 'nose 2')) > where + 0.05, 'the pressed slider has the keys');
    await rowOf(page, 'nose 1').getByRole('button').click();
    await typed.fill('50');
    await page.locator('#seed').evaluate((input) => input.closest('details')?.setAttribute('open', ''));
    await page.locator('#seed').click();
    await page.keyboard.type('7');
    assert.equal(await page.locator('#seed').inputValue(), '7');

    // What is under way is what is undone, and may be done again.
    await later(page);
    await moveSlider(page, 'nose 1', 0.7);
    const [first, drawn] = [await value(), await valueOf(page, 'nose 2')];
    await over(0.5);
    await page.mouse.down();
    await over(0.2);
    assert.notEqual(await valueOf(page, 'nose 2'), drawn);
    await page.keyboard.press('Control+z');
    assert.deepEqual([await value(), await valueOf(page, 'nose 2')], [first, drawn]);
    await page.mouse.up();
    assert.ok(await page.getByRole('button', { name: 'Redo', exact: true }).isEnabled());
    // On a keyboard with other letters the key that stands there.
    const press = (/** @type {object} */ keys) => page.evaluate((keys) => window.dispatchEvent(new KeyboardEvent('keydown', { ctrlKey: true, cancelable: true, ...keys })), keys);
    await press({ key: 'я', code: 'KeyZ' });
    assert.notEqual(await value(), first);
    await press({ key: 'н', code: 'KeyY' });
    assert.equal(await value(), first);

    // Whoever opens another feature with the other hand ends what this one moves, which is a step.
    await over(0.5);
    await page.mouse.down();
    await over(0.3);
    const half = await page.evaluate(() => {
      document.querySelector('.tab[data-group="mouth"]').click();
      return window.designer.face.code;
    });
    await page.mouse.up();
    assert.equal(await page.evaluate(() => location.hash), `#${half}`);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await page.evaluate(() => window.designer.face.get('nose 2')), drawn);
    await page.locator('.tab[data-group="nose"]').click();

    // Another feature begins at its top.
    const scroll = page.locator('.features .scroll');
    await scroll.evaluate((element) => element.scrollTo(0, 400));
    await page.locator('.tab[data-group="mouth"]').click();
    assert.equal(await scroll.evaluate((element) => element.scrollTop), 0);

    // All of it can be undone, one after the other.
    const undo = page.getByRole('button', { name: 'Undo', exact: true });
    let undone = 0;
    while (await undo.isEnabled()) {
      await undo.click();
      undone += 1;
      assert.ok(undone < 40, 'undo never ends');
    }
    assert.equal(await page.evaluate(() => window.designer.face.code), await page.evaluate(() => window.designer.model.face().code));
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('under a finger moves sideways, and lets the page scroll', async () => {
    const { context, page } = await open(browser, site, {
      viewport: { width: 390, height: 844 },
      hasTouch: true,
      isMobile: true,
    });
    const touch = await fingerOn(context, page);
    const box = await sliderOf(page, 'nose 1').boundingBox();
    assert.ok(box);
    const y = box.y + box.height / 2;
    await touch([box.x + box.width / 2, y], [box.x + 0.8 * box.width, y]);
    assert.ok((await valueOf(page, 'nose 1')) > 0.9);
    const kept = await valueOf(page, 'nose 1');
    await touch([box.x + 0.2 * box.width, y], [box.x + 0.2 * box.width, y - 150]);
    await page.waitForFunction(() => (document.querySelector('.scroll')?.scrollTop ?? 0) > 40);
    assert.equal(await valueOf(page, 'nose 1'), kept, 'scrolling moved a slider');
    await context.close();
  });

  test('random faces keep what is locked, and are as unusual as asked for', async () => {
    const { context, page } = await open(browser, site);
    const away = () =>
      page.evaluate(() => {
        const { face } = window.designer;
        const c = face.coefficients;
        return Math.sqrt(c.reduce((sum, v) => sum + v * v, 0) / c.length);
      });
    const random = page.getByRole('button', { name: 'Random face', exact: true });
    await sliderOf(page, 'How unusual').fill('0.2');
    await random.click();
    const near = await away();
    await sliderOf(page, 'How unusual').fill('1.6');
    await random.click();
    const far = await away();
    // Of 115 coefficients the root mean square is the spread within some 7 % (one sigma).
    assert.ok(near < 0.3 && far > 1.1, `${near} and ${far} standard deviations`);
    // A lock can be undone like anything else.
    await page.getByRole('button', { name: 'Lock the nose' }).click();
    assert.deepEqual(await page.evaluate(() => window.designer.face.locked), ['nose']);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(await page.evaluate(() => window.designer.face.locked), []);
    await page.getByRole('button', { name: 'Redo', exact: true }).click();
    const nose = await valueOf(page, 'nose 3');
    // Not of one slider alone: at this spread one can stand at its end before and after.
    const mouth = async () => [await valueOf(page, 'mouth 1'), await valueOf(page, 'mouth 2'), await valueOf(page, 'mouth 3')];
    const before = await mouth();
    await random.click();
    assert.equal(await valueOf(page, 'nose 3'), nose);
    assert.notDeepEqual(await mouth(), before);
    // What is locked looks as it does, which needs all looks: whoever wished for others is told.
    assert.match((await page.locator('.toast').textContent()) ?? '', /^Random except what is locked, and the looks with it, seed \d+$/);
    assert.ok(await page.locator('#random-colours').isDisabled());
    // A reset says what it leaves, and all that it took comes back.
    const state = () => page.evaluate(() => [window.designer.face.code, window.designer.face.locked, window.designer.colouring]);
    const whole = await state();
    await page.getByRole('button', { name: 'Reset all' }).click();
    assert.equal(await valueOf(page, 'nose 3'), nose);
    assert.match((await page.locator('.toast').textContent()) ?? '', /^What is locked stays as it is/);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(await state(), whole);
    await context.close();
  });
});
