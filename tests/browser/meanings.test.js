import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { moveSlider, onePage, open, pictureOfPage, siteAndBrowser } from './site.js';

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
      // Nothing is nothing to both sides.
      const shown = mm.toFixed(1).replace(/^-(?=0\.0$)/, '');
      assert.match(words ?? '', new RegExp(`^${shown.replace('.', '\\.').replace('-', '−')} mm, \\d+(st|nd|rd|th)$`));
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
    // One step back after the other, with the lock in between.
    const undo = page.getByRole('button', { name: 'Undo', exact: true });
    for (let i = 0; i < 3; i++) await undo.click();
    assert.equal(await lock.getAttribute('aria-pressed'), 'false');
    assert.ok(Math.abs((await length()) - goal) <= 0.011);
    await page.getByRole('button', { name: `Undo what ${said(name)} did`, exact: true }).click();
    assert.ok(Math.abs((await length()) - start) < 0.2, `cleared it is ${await length()}, it was ${start}`);
    // A length that people do not have ends at the slider's end, and a sentence says so and how it goes on.
    await type(0.1);
    assert.equal(await page.evaluate((control) => window.designer.face.get(control), name), 0);
    const ended = page.getByRole('alert');
    assert.match((await ended.textContent()) ?? '', /^It ends at [−\d.]+ mm\. Go beyond people$/);
    const least = await length();
    await ended.getByRole('button').click();
    assert.equal(await page.locator('.notice').count(), 0);
    assert.ok(await page.locator('#section-meanings').getByLabel('Go beyond people').isChecked());
    await type(least - 0.5);
    assert.ok(Math.abs((await length()) - (least - 0.5)) <= 0.011, `${await length()} mm, not ${least - 0.5}`);
    assert.equal(await page.locator('.notice').count(), 0);
    // One that no face has is refused in one sentence, or reached; never half of either.
    await type(0.1);
    const after = await length();
    const told = (await page.locator('.toast').textContent()) ?? '';
    assert.ok(Math.abs(after - 0.1) <= 0.011 || (await page.locator('.notice').count()) > 0 || /^That cannot be done: .+/.test(told), `${after} mm, “${told}”`);
  }
  assert.deepEqual(complaints, []);
  await context.close();
});

test('lengths without a control are set, too: a long narrow face', async () => {
  const { context, page, complaints } = await open(browser, site, { sharp: true });
  const lengths = () => page.evaluate(() => Object.fromEntries(window.designer.model.measures.map(({ name }) => [name, window.designer.face.measure(name)])));
  const middle = await lengths();
  await page.getByRole('tab', { name: 'Lengths' }).click();
  const slider = (/** @type {string} */ name) => page.getByRole('slider', { name, exact: true });
  await slider('face height').waitFor();
  await page.waitForFunction(() => !document.querySelector('#section-meanings .awaited'));
  // All of them, each once.
  assert.equal(await page.locator('#section-meanings input[type=range]').count(), Object.keys(middle).length);
  assert.equal(await page.locator('#section-meanings .is-moved').count(), 0, 'a new face is the middle');
  const whole = page.locator('#section-meanings .part').filter({ has: page.getByRole('heading', { name: 'Whole face' }) });
  assert.equal(await whole.getByRole('slider').count(), 4);

  // Where people are: of 4000 random faces the height is 113.15 mm, with a deviation of 5.92 mm; the width 97.61 and 4.93.
  const place = async (/** @type {string} */ name, /** @type {number} */ value) => {
    await slider(name).fill(String(value));
    return (await lengths())[name];
  };
  for (const [name, mean, deviation] of /** @type {const} */ ([['face height', 113.15, 5.92], ['face width', 97.61, 4.93]])) {
    const [low, high] = [await place(name, 0.159), await place(name, 0.841)];
    assert.ok(Math.abs((low + high) / 2 - mean) < 0.15 * deviation, `${name}: the middle is ${(low + high) / 2}`);
    assert.ok(Math.abs((high - low) / 2 / deviation - 1) < 0.1, `${name}: the deviation is ${(high - low) / 2}`);
    await slider(name).press('Delete');
    assert.ok(Math.abs((await lengths())[name] - middle[name]) < 0.05, `${name} is ${(await lengths())[name]} once reset`);
  }
  await page.getByRole('button', { name: 'Reset all' }).click();
  // Lips take neither the jaw nor the nose with them, nor a brow the forehead: in people they would.
  for (const [name, others] of /** @type {const} */ ([
    ['lip height', ['tragion width', 'jaw width', 'face height', 'nose length', 'mouth vertical position']],
    ['brow distance', ['forehead width', 'tragion width', 'inner eye distance']],
    ['chin height', ['mouth vertical position', 'tragion width']],
  ])) {
    for (const at of [0.05, 0.95]) {
      const mm = await place(name, at);
      assert.ok(Math.abs(mm - middle[name]) > 2, `${name} is ${mm}`);
      const present = await lengths();
      for (const other of others) assert.ok(Math.abs(present[other] - middle[other]) < 0.02, `${name} at ${at} takes ${other} ${present[other] - middle[other]} mm along`);
    }
    await page.getByRole('button', { name: 'Reset all' }).click();
  }

  const narrow = await place('face width', 0.023);
  const long = await place('face height', 0.977);
  const both = await lengths();
  assert.ok(Math.abs(both['face width'] - narrow) < 0.02, `the width is ${both['face width']}, it was ${narrow}`);
  assert.ok(narrow < 89 && long > 124, `${narrow} wide, ${long} high`);
  await pictureOfPage(page, 'meanings-narrow');
  const rank = (await slider('face height').getAttribute('aria-valuetext')) ?? '';
  assert.match(rank, /^12\d\.\d mm, 98th$/);
  // The link has it.
  const other = await open(browser, site, { hash: new URL(page.url()).hash });
  assert.equal(await other.page.evaluate(() => window.designer.face.code), await page.evaluate(() => window.designer.face.code));
  await other.context.close();
  // A percentile that is typed is read.
  for (const rank of ['95th', '3rd', '77th']) {
    await slider('nose width').press('Enter');
    await page.keyboard.type(rank);
    await page.keyboard.press('Enter');
    assert.match((await slider('nose width').getAttribute('aria-valuetext')) ?? '', new RegExp(`mm, ${rank}$`));
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
  }
  // Typed, locked, and one step each.
  await slider('jaw width').press('Enter');
  await page.getByRole('spinbutton', { name: 'jaw width in mm', exact: true }).fill('120,5');
  await page.keyboard.press('Enter');
  let now = await lengths();
  assert.ok(Math.abs(now['jaw width'] - 120.5) < 0.02 && Math.abs(now['face width'] - narrow) < 0.02 && Math.abs(now['face height'] - long) < 0.02, JSON.stringify(now));
  await page.getByRole('button', { name: 'Lock the jaw width', exact: true }).click();
  await place('face width', 0.3);
  now = await lengths();
  assert.ok(Math.abs(now['jaw width'] - 120.5) < 0.02, `the lock did not hold: ${now['jaw width']}`);
  assert.ok(now['face width'] > narrow + 3);
  const undo = page.getByRole('button', { name: 'Undo', exact: true });
  for (let i = 0; i < 3; i++) await undo.click();
  now = await lengths();
  assert.ok(Math.abs(now['jaw width'] - both['jaw width']) < 1e-4 && Math.abs(now['face width'] - narrow) < 0.02);
  // A drag there and back again leaves no trace.
  const code = await page.evaluate(() => window.designer.face.code);
  const box = /** @type {{ x: number, y: number, width: number, height: number }} */ (await slider('face height').boundingBox());
  const thumb = /** @type {{ x: number, y: number, width: number, height: number }} */ (await whole.locator('.control').first().locator('.thumb').boundingBox());
  const at = [thumb.x + thumb.width / 2, box.y + box.height - 9];
  await page.mouse.move(at[0], at[1]);
  await page.mouse.down();
  await page.mouse.move(at[0] - 120, at[1], { steps: 5 });
  assert.notEqual(await page.evaluate(() => window.designer.face.code), code);
  await page.mouse.move(at[0], at[1], { steps: 5 });
  await page.mouse.up();
  now = await lengths();
  for (const [name, mm] of Object.entries(both)) assert.ok(Math.abs(now[name] - mm) < 0.1, `${name} is ${now[name]}, it was ${mm}`);
  await page.getByRole('button', { name: 'Reset the face height', exact: true }).click();
  assert.ok(Math.abs((await lengths())['face height'] - middle['face height']) < 0.05);
  assert.deepEqual(complaints, []);
  await context.close();
});

describe('the lengths of one page', () => {
  const visit = onePage(browser, site);

  test('what lies to a side is said of the subject’s', async () => {
    const { page } = visit;
    // Rows come while the page is never idle, and not all at once: first those that can be seen.
    const { atOnce, order } = await page.evaluate(async () => {
      const { requestIdleCallback } = window;
    window.requestIdleCallback = () => 0;
      const section = document.querySelector('#section-meanings');
      const names = () => [...section.querySelectorAll('input[type=range]')].map(({ id }) => id);
      const order = new Set();
      new MutationObserver(() => names().forEach((name) => order.add(name))).observe(section, { childList: true, subtree: true });
      document.querySelector('#mode-meanings').click();
      const atOnce = names().length;
      for (const end = performance.now() + 20_000; section.querySelector('.awaited') && performance.now() < end; ) await new Promise((done) => setTimeout(done, 20));
      window.requestIdleCallback = requestIdleCallback;
    return { atOnce, order: [...order] };
    });
    const { length } = await page.evaluate(() => window.designer.model.measures);
    assert.ok(atOnce < length / 2, `${atOnce} of ${length} rows in the click`);
    assert.equal(order.length, length);
    assert.ok(order.indexOf('meaning-face-height') < order.indexOf('meaning-chin-height'), order.join());
    const said = await page.locator('#section-meanings .about').allTextContents();
    assert.equal(said.filter((words) => /lies? to the subject’s left of/.test(words)).length, 2, said.join());
    // Each says from where to where it goes, whatever it is called: what surgeons call the length is the height here.
    assert.equal(said.length, length);
    assert.deepEqual(said.filter((words) => !/from|between|how (far|high)|mean of/i.test(words)), []);
    for (const [name, words] of [['nose-length', /stands out before the base/], ['nose-height', /surgeons call the length/], ['face-width', /on the front/]]) {
      const described = await page.locator(`#meaning-${name}`).getAttribute('aria-describedby');
      assert.match((await page.locator(`#${described}`).textContent()) ?? '', /** @type {RegExp} */ (words));
    }
  });

  test('a decimal comma is a point, and what is typed keeps to the slider', async () => {
    const { page } = visit;
    await page.getByRole('tab', { name: 'Lengths' }).click();
    const length = (/** @type {string} */ name) => page.evaluate((m) => window.designer.face.measure(m), name);
    const typed = page.getByRole('spinbutton', { name: 'mouth width in mm', exact: true });
    // As people type it, not all at once.
    const type = async (/** @type {string} */ keys) => {
      await page.getByRole('slider', { name: 'mouth width', exact: true }).focus();
      await page.keyboard.press('Enter');
      await page.keyboard.type(keys);
      await page.keyboard.press('Enter');
    };
    await type('50,5');
    assert.ok(Math.abs((await length('mouth width')) - 50.5) <= 0.011, `${await length('mouth width')} mm`);
    await type('five');
    assert.ok(Math.abs((await length('mouth width')) - 50.5) <= 0.011, 'nonsense changes nothing');
    assert.equal(await page.getByRole('alert').textContent(), 'Type it like “50.5”.');
    for (const [typed, mm] of /** @type {const} */ ([['48.2 mm', 48.2], ['4.9cm', 49], ['−', 49]])) {
      await type(typed);
      assert.ok(Math.abs((await length('mouth width')) - mm) <= 0.011, `${typed} is ${await length('mouth width')} mm`);
    }
    await type('95th');
    assert.match((await page.getByRole('slider', { name: 'mouth width', exact: true }).getAttribute('aria-valuetext')) ?? '', /, 95th$/);
    await page.getByRole('slider', { name: 'mouth width', exact: true }).press('4');
    await page.keyboard.type('9,25');
    assert.equal(await typed.inputValue(), '49,25');
    await page.keyboard.press('ArrowUp');
    assert.equal(await typed.inputValue(), '49.35');
    assert.equal(await typed.getAttribute('aria-valuenow'), '49.35');
    await page.keyboard.press('Escape');
    await type('400');
    assert.ok((await length('mouth width')) < 65, `${await length('mouth width')} mm`);
    assert.match((await page.locator('.notice').textContent()) ?? '', /^It ends at 6\d\.\d mm\./);
    // What is below zero can be typed, too.
    const low = page.getByRole('slider', { name: 'mouth vertical position', exact: true });
    await low.press('-');
    await page.keyboard.type('52.5');
    await page.keyboard.press('Enter');
    assert.ok(Math.abs((await length('mouth vertical position')) + 52.5) <= 0.011, `${await length('mouth vertical position')} mm`);
    assert.deepEqual(visit.complaints, []);
  });

  test('a sign is a change where lengths have none, and with an equals sign where they have', async () => {
    const { page } = visit;
    await page.getByRole('tab', { name: 'Lengths' }).click();
    await page.getByRole('button', { name: 'Reset all' }).click();
    const length = (/** @type {string} */ name) => page.evaluate((m) => window.designer.face.measure(m), name);
    const type = async (/** @type {string} */ name, /** @type {string} */ keys) => {
      await page.getByRole('slider', { name, exact: true }).focus();
      // A sign opens the number as a digit does.
      await page.keyboard.type(keys);
      await page.keyboard.press('Enter');
    };
    const nose = await length('nose length');
    const near = async (/** @type {string} */ name, /** @type {number} */ goal) => {
      const mm = await length(name);
      assert.ok(Math.abs(mm - goal) <= 0.061, `${name} is ${mm} mm, not ${goal}`);
    };
    await type('nose length', '+3');
    await near('nose length', nose + 3);
    await type('nose length', '+0,5 mm');
    await near('nose length', nose + 3.5);
    await type('nose length', '-2');
    await near('nose length', nose + 1.5);
    await type('nose length', '+=0.1 cm');
    await near('nose length', nose + 2.5);
    const place = await length('mouth vertical position');
    await type('mouth vertical position', '+2');
    await near('mouth vertical position', place + 2);
    await type('mouth vertical position', '-=1.5');
    await near('mouth vertical position', place + 0.5);
    await type('mouth vertical position', '-49');
    await near('mouth vertical position', -49);
    for (const keys of ['+', '+3rd', '--3']) {
      await type('mouth vertical position', keys);
      assert.match((await page.getByRole('alert').textContent()) ?? '', /^Type it like/, keys);
      await page.keyboard.press('Escape');
    }
    await near('mouth vertical position', -49);
    const field = page.getByRole('spinbutton', { name: 'mouth vertical position in mm', includeHidden: true });
    assert.equal(await field.getAttribute('title'), 'A number, or a change: +2 for 2 more, −=2 for 2 less');
    await page.getByRole('button', { name: 'Reset all' }).click();
  });

  test('a length that was typed and is moved by another is named, with how far it went', async () => {
    const { page } = visit;
    await page.getByRole('tab', { name: 'Lengths' }).click();
    await page.getByRole('button', { name: 'Reset all' }).click();
    const length = (/** @type {string} */ name) => page.evaluate((m) => window.designer.face.measure(m), name);
    const type = async (/** @type {string} */ name, /** @type {string} */ keys) => {
      await page.getByRole('slider', { name, exact: true }).press('Enter');
      await page.keyboard.type(keys);
      await page.keyboard.press('Enter');
    };
    const notices = () => page.locator('#section-meanings .notice').allTextContents();
    await page.getByRole('slider', { name: 'mouth width', exact: true }).press('PageUp');
    await type('nose width', '38');
    assert.deepEqual(await notices(), [], 'what was not typed is not named');
    await type('eye width', '30');
    const [nose, eyes] = [await length('nose width'), await length('eyes length')];
    // What goes with the size of the whole face takes most with it.
    await type('jaw width', '+8');
    const by = [(await length('nose width')) - nose, (await length('eyes length')) - eyes];
    assert.ok(by.every((mm) => Math.abs(mm) > 0.06), `${by}`);
    const change = (/** @type {number} */ mm) => `${mm < 0 ? '−' : '+'}${Math.abs(mm).toFixed(1)} mm`;
    const named = [['nose width', by[0]], ['eye width', by[1]]].sort(([, a], [, b]) => Math.abs(b) - Math.abs(a));
    assert.deepEqual(await notices(), [`Typed before, and moved by this: ${named.map(([name, mm]) => `${name} (${change(mm)})`).join(', ')}. A locked length stays.`]);
    assert.ok(await page.locator('#section-meanings .control', { has: page.locator('#meaning-jaw-width') }).locator('.notice').isVisible());
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(await notices(), []);
    // What is locked stays, and of what was typed anew nothing is said.
    await page.getByRole('button', { name: 'Lock the nose width', exact: true }).click();
    await type('jaw width', '+8');
    assert.match((await notices()).join(), /^Typed before, and moved by this: eye width \([+−]\d\.\d mm\)\. /);
    await type('eye width', '29');
    assert.ok(!(await notices()).join().includes('eye width'));
    // Nor of the lengths of another face, though one is by chance as it was typed.
    await page.getByRole('button', { name: 'Lock the nose width', exact: true }).click();
    // (Of a random one in some the jaw hardly moves the mouth.)
    const [another, chance] = await page.evaluate(() => {
      const one = window.designer.model.face();
      one.randomize({ seed: 7 });
      const found = [one.code, one.measure('mouth width')];
      one.free();
      return found;
    });
    await type('mouth width', (chance + 0.02).toFixed(2));
    await page.evaluate((hash) => void (location.hash = hash), another);
    await page.waitForFunction((mm) => Math.abs(window.designer.face.measure('mouth width') - mm) < 1e-4, chance);
    await type('jaw width', '+6');
    assert.ok(Math.abs((await length('mouth width')) - chance) > 0.06, `${(await length('mouth width')) - chance}`);
    assert.deepEqual(await notices(), []);
    await page.getByRole('button', { name: 'Reset all' }).click();
    assert.deepEqual(visit.complaints, []);
  });

  test('a length stops where its part has no room, and goes on once that is unlocked', async () => {
    const { page } = visit;
    await page.getByRole('button', { name: 'Reset all' }).click();
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
    assert.deepEqual(visit.complaints, []);
  });
});
