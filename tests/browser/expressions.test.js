// What the face does: the panel of expressions, driven as a person would.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { FEELINGS, VISEMES } from '../../www/src/panel/feelings.js';
import { differing, fingerOn, holdBack, landmarkOnScreen, moveSlider, open, picture, pictureOfPage, siteAndBrowser, TALL } from './site.js';

const { browser, site } = await siteAndBrowser();

/** @param {import('playwright-core').Page} page @returns {Promise<Record<string, number>>} in whole per cents */
const shown = (page) =>
  page.evaluate(() => Object.fromEntries(Object.entries(window.designer.face.expression).map(([name, weight]) => [name, Math.round(100 * weight)])));

/** @param {import('playwright-core').Page} page */
async function openPanel(page) {
  await page.getByRole('tab', { name: 'Expressions' }).click();
  await page.getByRole('slider', { name: 'mouthSmile' }).first().waitFor({ timeout: 60_000 });
}

/** A box of the picture around a landmark, in fractions. */
async function around(page, name, size) {
  const at = await landmarkOnScreen(page, name);
  const box = await page.locator('canvas.view').boundingBox();
  assert.ok(box);
  const [x, y] = [(at.x - box.x) / box.width, (at.y - box.y) / box.height];
  return /** @type {[number, number, number, number]} */ ([x - size, y - size, x + size, y + size]);
}

describe('expressions', () => {
  for (const [device, options] of /** @type {const} */ ([
    ['desktop', {}],
    ['phone', { viewport: { width: 320, height: 640 }, hasTouch: true, isMobile: true, colorScheme: 'dark' }],
  ])) {
    test(`a smile, a wink, a glance, and back, on a ${device}`, async () => {
      const { context, page, complaints, requests } = await open(browser, site, { sharp: true, ...options });
      assert.ok(!requests.some((url) => url.endsWith('/expressions.phiz')), 'they come when they are wanted');
      const rest = await picture(page, `expressions-${device}-rest`);
      const code = await page.evaluate(() => window.designer.face.code);
      await openPanel(page);
      // All of them are there: 15 by themselves, 14 on both sides, 8 glances; and how strong a preset is.
      assert.equal(await page.locator('.expressions input[type=range]').count(), 37 + 1);

      // Both sides by default.
      await moveSlider(page, 'Smile mouthSmile', 0.8);
      assert.deepEqual(await shown(page), { mouthSmileLeft: 80, mouthSmileRight: 80 });
      const mouth = await around(page, 'ibug_57', 0.15);
      const brow = await around(page, 'ibug_27', 0.04);
      const smile = await picture(page, `expressions-${device}-smile`);
      assert.ok(differing(rest, smile, mouth) > 200, `${differing(rest, smile, mouth)} pixels of the mouth`);
      assert.equal(differing(rest, smile, [0, 0, 0.12, 0.12]), 0, 'not the backdrop');
      assert.ok(differing(rest, smile, brow) < 0.2 * differing(rest, smile, mouth));
      assert.equal(await page.evaluate(() => window.designer.face.code), code, 'the face is the same face');

      // Undo and redo are of the expression, too.
      await page.getByRole('button', { name: 'Undo', exact: true }).click();
      assert.deepEqual(await shown(page), {});
      assert.equal(differing(rest, await picture(page, `expressions-${device}-undone`)), 0);
      await page.getByRole('button', { name: 'Redo', exact: true }).click();
      assert.deepEqual(await shown(page), { mouthSmileLeft: 80, mouthSmileRight: 80 });

      // One side alone.
      await page.getByLabel('Left and right together').uncheck();
      await moveSlider(page, 'Blink, left eyeBlinkLeft', 1);
      assert.deepEqual(await shown(page), { eyeBlinkLeft: 100, mouthSmileLeft: 80, mouthSmileRight: 80 });
      const wink = await picture(page, `expressions-${device}-wink`);
      const [open1, shut] = [await around(page, 'ibug_37', 0.03), await around(page, 'ibug_43', 0.03)];
      assert.ok(differing(smile, wink, shut) > 5 * differing(smile, wink, open1) + 20, `${differing(smile, wink, shut)}, ${differing(smile, wink, open1)}`);

      // The pupil goes where it is dragged; the subject's left is on the right.
      await page.getByRole('button', { name: 'Neutral' }).click();
      assert.deepEqual(await shown(page), {});
      const field = page.locator('.gaze');
      await field.scrollIntoViewIfNeeded();
      const box = await field.boundingBox();
      assert.ok(box);
      const [from, to] = /** @type {[number, number][]} */ ([
        [box.x + box.width / 2, box.y + box.height / 2],
        [box.x + box.width - 20, box.y + box.height / 2 - 12],
      ]);
      if (device === 'phone') await (await fingerOn(context, page))(from, to);
      else {
        await page.mouse.move(...from);
        await page.mouse.down();
        await page.mouse.move(...to, { steps: 4 });
        await page.mouse.up();
      }
      const glance = await shown(page);
      assert.ok(glance.eyeLookOutLeft > 60 && glance.eyeLookOutLeft === glance.eyeLookInRight && !glance.eyeLookInLeft, JSON.stringify(glance));
      assert.ok(glance.eyeLookUpLeft > 10 && !glance.eyeLookDownLeft);
      const looking = await picture(page, `expressions-${device}-glance`);
      assert.ok(differing(rest, looking, await around(page, 'ibug_43', 0.03)) > 15, 'the eyes turn');
      await page.getByRole('slider', { name: 'Gaze' }).press('Home');
      assert.deepEqual(await shown(page), {});

      const shutBoth = page.getByRole('button', { name: 'Eyes shut' });
      await shutBoth.click();
      assert.deepEqual(await shown(page), { eyeBlinkLeft: 100, eyeBlinkRight: 100 });
      assert.equal(await shutBoth.getAttribute('aria-pressed'), 'true');
      await picture(page, `expressions-${device}-shut`);
      await pictureOfPage(page, `expressions-${device}-page`);
      await shutBoth.click();
      assert.deepEqual(await shown(page), {});
      assert.equal(differing(rest, await picture(page, `expressions-${device}-again`)), 0);
      assert.deepEqual(complaints, []);
      await context.close();
    });
  }

  for (const [device, options] of /** @type {const} */ ([
    ['desktop', {}],
    ['phone', { viewport: { width: 320, height: 640 }, hasTouch: true, isMobile: true, colorScheme: 'dark' }],
  ])) {
    test(`presets by pointer and key, one step each, on a ${device}`, async () => {
      const { context, page, complaints } = await open(browser, site, { sharp: true, ...options });
      const rest = await picture(page, `presets-${device}-rest`);
      await openPanel(page);
      const preset = (/** @type {string} */ name) => page.locator('.presets').getByRole('button', { name, exact: true });
      const pressed = () => page.locator('.presets [aria-pressed=true]').allTextContents();
      const undo = page.getByRole('button', { name: 'Undo', exact: true });
      const together = page.getByLabel('Left and right together');
      assert.deepEqual(await pressed(), []);

      // The eyes stay where they look.
      await page.getByRole('slider', { name: 'Gaze' }).press('Shift+ArrowRight');
      const glance = { eyeLookInRight: 25, eyeLookOutLeft: 25 };
      assert.deepEqual(await shown(page), glance);
      const looking = await picture(page, `presets-${device}-looking`);
      await (device === 'phone' ? preset('Smile').tap() : preset('Smile').click());
      assert.deepEqual(await pressed(), ['Smile']);
      const smile = await shown(page);
      assert.ok(smile.mouthSmileLeft > 50 && smile.mouthSmileLeft === smile.mouthSmileRight && smile.cheekSquintLeft > 20, JSON.stringify(smile));
      assert.ok(smile.eyeLookOutLeft === 25 && smile.eyeLookInRight === 25);
      const smiling = await picture(page, `presets-${device}-smile`);
      const mouth = await around(page, 'ibug_57', 0.15);
      assert.ok(differing(looking, smiling, mouth) > 200, `${differing(looking, smiling, mouth)} pixels of the mouth`);
      const [left, , right] = await around(page, 'ibug_27', 0.1);
      assert.equal(differing(looking, smiling, [left, 0, right, 0.2]), 0, 'not the crown');

      // Another one replaces it.
      await preset('Angry').focus();
      await page.keyboard.press('Enter');
      assert.deepEqual(await pressed(), ['Angry']);
      const angry = await shown(page);
      assert.ok(angry.browDownLeft > 50 && !('mouthSmileLeft' in angry) && angry.eyeLookOutLeft === 25, JSON.stringify(angry));
      await undo.click();
      assert.deepEqual(await shown(page), smile);
      assert.deepEqual(await pressed(), ['Smile']);

      // Half a smile is one, and so much of the next; all of its way is one step.
      const strength = page.getByRole('slider', { name: 'Strength', exact: true });
      await strength.focus();
      await strength.fill('0.3');
      await strength.fill('0.5');
      await strength.dispatchEvent('change');
      assert.equal((await shown(page)).mouthSmileLeft, Math.round(smile.mouthSmileLeft / 2));
      assert.deepEqual(await pressed(), ['Smile']);
      await undo.click();
      assert.deepEqual(await shown(page), smile);
      assert.equal(await strength.inputValue(), '1', 'the slider follows');
      await page.getByRole('button', { name: 'Redo', exact: true }).click();
      assert.equal(await strength.inputValue(), '0.5');
      await preset('Surprised').press('Space');
      assert.equal((await shown(page)).browOuterUpLeft, Math.round(50 * FEELINGS.surprised.browOuterUpLeft), 'as strong as the last one');
      await strength.press('Delete');
      assert.equal(await strength.inputValue(), '1');

      // With a slider moved it is no longer that one.
      await moveSlider(page, 'Open jawOpen', 0.11);
      assert.deepEqual(await pressed(), []);

      // One side alone parts the sliders as long as it lasts.
      await preset('Wink').click();
      assert.deepEqual(await pressed(), ['Wink']);
      assert.equal(await together.isChecked(), false);
      await page.getByText('Mouth shapes of speech').click();
      await preset('OO').click();
      assert.ok((await shown(page)).mouthPucker > 50);
      assert.equal(await together.isChecked(), true);
      assert.deepEqual(await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth), 0);
      const wide = await page.locator('.presets button').evaluateAll((all) => all.filter((it) => it.scrollWidth > it.clientWidth || it.clientHeight < 24).map((it) => it.textContent));
      assert.deepEqual(wide, []);
      await page.locator('.presets').scrollIntoViewIfNeeded();
      await pictureOfPage(page, `presets-${device}-page`);

      // Pressed again it goes, and only the glance is left, which the whole of Neutral takes, too.
      await preset('OO').click();
      assert.deepEqual(await shown(page), glance);
      await preset('Kiss').click();
      await page.getByRole('button', { name: 'Neutral' }).click();
      assert.deepEqual(await shown(page), {});
      assert.deepEqual(await pressed(), []);
      assert.equal(differing(rest, await picture(page, `presets-${device}-again`)), 0);
      assert.deepEqual(complaints, []);
      await context.close();
    });
  }

  test('a wink that is taken back leaves sliders of both sides, as they were', async () => {
    const { context, page, complaints } = await open(browser, site);
    await openPanel(page);
    const press = (/** @type {string} */ name) => page.getByRole('button', { name, exact: true }).click();
    const together = page.getByLabel('Left and right together');
    const count = () => page.locator('.expressions input[type=range]').count();
    const both = await count();
    await press('Wink');
    assert.ok(!(await together.isChecked()));
    const each = await count();
    assert.ok(each > both);
    await press('Undo');
    assert.deepEqual([await together.isChecked(), await count()], [true, both]);
    await press('Redo');
    assert.deepEqual([await together.isChecked(), await count()], [false, each]);
    // What has the focus has it in the new sliders.
    const blink = () => page.evaluate(() => document.activeElement?.id);
    await page.getByRole('slider', { name: 'Blink, right eyeBlinkRight' }).focus();
    await page.keyboard.press('Control+z');
    assert.deepEqual([await together.isChecked(), await blink()], [true, 'expression-eyeBlink']);
    await page.keyboard.press('Control+y');
    assert.deepEqual([await together.isChecked(), await blink()], [false, 'expression-eyeBlinkLeft']);
    // Another section is open.
    await page.getByRole('tab', { name: 'Looks' }).click();
    await press('Undo');
    await page.getByRole('tab', { name: 'Expressions' }).click();
    assert.deepEqual([await together.isChecked(), await count()], [true, both]);
    // A slider that passes what the other side has is still in hand.
    await press('Redo');
    await moveSlider(page, 'Blink, left eyeBlinkLeft', 0);
    await moveSlider(page, 'Blink, right eyeBlinkRight', 0);
    assert.deepEqual([await together.isChecked(), await count()], [false, each]);
    // Who asked for each side has it.
    await press('Neutral');
    assert.ok(await together.isChecked());
    await together.uncheck();
    await press('Wink');
    await press('Undo');
    assert.deepEqual([await together.isChecked(), await count()], [false, each]);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('every preset is told by what the face does at every strength, and differs from the others', async () => {
    const { context, page, complaints } = await open(browser, site);
    await openPanel(page);
    await page.getByText('Mouth shapes of speech').click();
    const buttons = page.locator('.presets button.small');
    assert.equal(await buttons.count(), Object.keys({ ...FEELINGS, ...VISEMES }).length);
    const names = await page.evaluate(() => window.designer.model.expressions);
    for (const weights of Object.values({ ...FEELINGS, ...VISEMES })) {
      // With less, a tenth of it would be none.
      for (const [name, weight] of Object.entries(weights)) assert.ok(names.includes(name) && weight >= 0.05 && weight <= 1, name);
    }
    const strength = page.getByRole('slider', { name: 'Strength', exact: true });
    for (const amount of ['0.1', '0.37', '1']) {
      await page.getByRole('button', { name: 'Neutral' }).evaluate((button) => button.click());
      await strength.fill(amount);
      await strength.dispatchEvent('change');
      for (const button of await buttons.all()) {
        await button.click();
        const name = await button.textContent();
        assert.deepEqual(await page.locator('.presets [aria-pressed=true]').allTextContents(), [name], `${name} at ${amount}`);
        assert.equal(await strength.inputValue(), amount);
      }
    }
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('the address and the browser keep it, and a new face takes it over', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    await openPanel(page);
    await moveSlider(page, 'Open jawOpen', 0.37);
    await page.getByLabel('Left and right together').uncheck();
    await moveSlider(page, 'Frown, right mouthFrownRight', 0.52);
    const wanted = { jawOpen: 37, mouthFrownRight: 52 };
    assert.deepEqual(await shown(page), wanted);
    const median = new URL(page.url()).hash;
    assert.match(median, /^#~[\w-]+$/, 'of the median face there is only the expression');

    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    assert.deepEqual(await shown(page), wanted, 'another person, the same face made');
    const face = await picture(page, 'expressions-kept');
    const { hash } = new URL(page.url());
    assert.match(hash, /^#[\w-]+~[\w-]+~[\w-]+$/, 'shape, expression, colours');

    // Somebody else opens the link.
    const other = await open(browser, site, { sharp: true, hash });
    assert.deepEqual(await shown(other.page), wanted);
    const mesh = (/** @type {import('playwright-core').Page} */ where) => where.evaluate(() => Array.from(window.designer.face.positions));
    assert.deepEqual(await mesh(other.page), await mesh(page), 'bit for bit');
    const linkedTo = await picture(other.page, 'expressions-linked');
    assert.ok(differing(face, linkedTo) < 20, `${differing(face, linkedTo)} pixels`);
    await other.page.getByRole('tab', { name: 'Expressions' }).click();
    await other.page.getByRole('slider', { name: 'mouthFrownRight' }).waitFor();
    assert.equal(await other.page.getByLabel('Left and right together').isChecked(), false, 'one side alone is not shown as both');
    await other.context.close();
    const damaged = await open(browser, site, { sharp: true, hash: '#~____' });
    assert.match((await damaged.page.locator('.toast').textContent()) ?? '', /expression could not be shown/);
    assert.deepEqual(await shown(damaged.page), {});
    await damaged.context.close();

    // The last visit, on a slow line: who shapes the face meanwhile loses nothing of it.
    const again = await context.newPage();
    const come = await holdBack(again, '**/expressions.phiz');
    await again.goto(site.url);
    await again.getByRole('slider', { name: 'nose 1', exact: true }).waitFor();
    await moveSlider(again, 'nose 1', 0.9);
    const [, expression] = hash.split('~');
    assert.equal(new URL(again.url()).hash.split('~')[1], expression, 'the address has what is still to come');
    come();
    await again.waitForFunction(() => document.documentElement.dataset.ready === 'true');
    assert.deepEqual(await shown(again), wanted);
    assert.equal(new URL(again.url()).hash.split('~')[1], expression);
    await again.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(await shown(again), wanted);
    assert.equal(new URL(again.url()).hash, hash);
    await again.close();

    // All of the face goes back, and comes back: by keys, wherever nobody writes, and not behind a dialog.
    await page.getByRole('button', { name: 'Reset all' }).click();
    assert.deepEqual(await shown(page), {});
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    await page.keyboard.press('Control+z');
    assert.deepEqual(await shown(page), {});
    await page.keyboard.press('Escape');
    await page.getByLabel('Left and right together').focus();
    await page.keyboard.press('Control+z');
    assert.deepEqual(await shown(page), wanted);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('it blinks by itself, on the screen alone, and not where less motion is asked for', async () => {
    for (const reducedMotion of /** @type {const} */ (['no-preference', 'reduce'])) {
      const { context, page, complaints } = await open(browser, site, { reducedMotion });
      await openPanel(page);
      await page.evaluate(() => {
        // Blinks follow each other, and what is told to the head is kept.
        Math.random = () => 0;
        const { face } = window.designer;
        const descriptor = Object.getOwnPropertyDescriptor(Object.getPrototypeOf(face), 'expression');
        window.lids = [];
        Object.defineProperty(face, 'expression', {
          get: () => descriptor.get.call(face),
          set(value) {
            window.lids.push(value.eyeBlinkLeft ?? 0);
            descriptor.set.call(face, value);
          },
        });
      });
      const before = await page.evaluate(() => ({ code: window.designer.face.code, positions: [...window.designer.face.positions], hash: location.hash }));
      const alone = page.getByRole('checkbox', { name: 'Blink now and then' });
      await alone.focus();
      await page.keyboard.press('Space');
      if (reducedMotion === 'reduce') {
        // Twice the time until the first one.
        await page.waitForTimeout(4000);
        assert.deepEqual(await page.evaluate(() => window.lids), []);
      } else {
        // A slow machine takes its time, and draws few frames of one, and one that is shut.
        await page.waitForFunction(() => Math.max(...window.lids) > 0.99);
      }
      await alone.uncheck();
      const after = await page.evaluate(() => ({ code: window.designer.face.code, positions: [...window.designer.face.positions], hash: location.hash }));
      assert.deepEqual(after, before);
      assert.deepEqual(await shown(page), {});
      assert.ok(await page.getByRole('button', { name: 'Undo', exact: true }).isDisabled());
      assert.deepEqual(complaints, []);
      await context.close();
    }
  });

  test('when the file does not come, the panel says so and tries again', async () => {
    const { context, page } = await open(browser, site);
    await page.route('**/expressions.phiz', (route) => route.abort());
    await page.getByRole('tab', { name: 'Expressions' }).click();
    await page.getByText('The expressions could not be loaded').waitFor();
    await page.unroute('**/expressions.phiz');
    await page.getByRole('button', { name: 'Try again' }).click();
    await page.getByRole('slider', { name: 'mouthSmile' }).first().waitFor();
    await context.close();
  });

  test('a model that has none has no such panel', async () => {
    const { context, page } = await open(browser, site, { hash: '?model=synthetic' });
    assert.equal(await page.getByRole('tab', { name: 'Expressions' }).count(), 0);
    await context.close();
  });

  test('a mouth that opens has teeth, which stay behind the lips of every face', async () => {
    const { context, page, complaints } = await open(browser, site, { viewport: TALL, sharp: true });
    await openPanel(page);
    /** Pixels of the mouth that are paler than lips and skin are: green nearly as much as red. */
    async function teeth(name) {
      const shot = await picture(page, `teeth-${name}`);
      const [left, top, right, bottom] = await around(page, 'ibug_66', 0.1);
      let count = 0;
      for (let y = Math.floor(top * shot.height); y < bottom * shot.height; y++) {
        for (let x = Math.floor(left * shot.width); x < right * shot.width; x++) {
          const [r, g] = shot.rgb.subarray(3 * (y * shot.width + x));
          if (r > 60 && g > 0.875 * r) count++;
        }
      }
      return count;
    }
    const smile = async () => {
      for (const [name, weight] of /** @type {const} */ ([['Smile mouthSmile', 1], ['Upper lip up mouthUpperUp', 0.6], ['Lower lip down mouthLowerDown', 0.4]])) {
        await moveSlider(page, name, weight);
      }
    };
    // A shine on the lip may be as pale.
    assert.ok((await teeth('rest')) < 15, 'lips that are shut show none');
    await smile();
    const smiling = await teeth('smile');
    assert.ok(smiling > 150, `${smiling} pixels`);
    // Of faces whose mouths are higher, lower, thicker, further out.
    for (const seed of [1, 2, 3]) {
      await page.evaluate((value) => {
        const other = window.designer.model.face();
        other.randomize({ seed: value, spread: 1.3 });
        location.hash = other.code;
        other.free();
      }, seed);
      await page.waitForFunction(() => window.designer.face.code === location.hash.slice(1).split('~')[0]);
      await smile();
      const count = await teeth(`smile-${seed}`);
      assert.ok(count > 60 && count < 4 * smiling, `${count} pixels of face ${seed}, ${smiling} of the median one`);
    }
    // They are of the mouth for who clicks them.
    await moveSlider(page, 'Open jawOpen', 0.8);
    const [above, below] = [await landmarkOnScreen(page, 'ibug_62'), await landmarkOnScreen(page, 'ibug_66')];
    for (const share of [0.15, 0.85]) {
      await page.mouse.click(above.x, above.y + share * (below.y - above.y));
      assert.equal(await page.locator('.tab[aria-pressed=true]').getAttribute('data-group'), 'mouth', `a click ${share} of the way down`);
    }
    assert.deepEqual(complaints, []);
    await context.close();
  });
});
