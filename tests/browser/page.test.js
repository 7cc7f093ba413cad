import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { decodePng, differing, download, landmarkOnScreen, loseCard, moveSlider, onePage, open, picture, pictureOfPage, serve, settled, siteAndBrowser, TALL } from './site.js';

const { browser, site } = await siteAndBrowser();

/**
 * Of the rows between the brows and the mouth, the part in which the wall turns into the head by way of a pixel that is
 * neither: where edges have steps there is next to none.
 * @param {{ width: number, height: number, rgb: Buffer }} picture
 */
function soft({ width, height, rgb }) {
  let [rows, between] = [0, 0];
  for (let y = Math.round(0.35 * height); y < 0.6 * height; y++) {
    const blue = (/** @type {number} */ x) => rgb[3 * (y * width + x) + 2];
    for (let x = 4; x < width / 2; x++) {
      const [wall, head] = [blue(x - 3), blue(x + 3)];
      if (wall - head < 60 || wall - blue(x) < 8) continue;
      rows += 1;
      const part = (wall - blue(x)) / (wall - head);
      if (part > 0.15 && part < 0.85) between += 1;
      break;
    }
  }
  assert.ok(rows > 0.2 * height, `the head begins in ${rows} rows`);
  return between / rows;
}

/** The positions on the page as a string that shows any changed bit. */
const positions = (page) =>
  page.evaluate(() => {
    const { face } = window.designer;
    const bytes = new Uint8Array(face.positions.slice().buffer);
    let hash = 0xcbf29ce484222325n;
    for (const byte of bytes) hash = ((hash ^ BigInt(byte)) * 0x100000001b3n) & 0xffffffffffffffffn;
    return `${bytes.length}:${hash.toString(16)}`;
  });

describe('the page', () => {
  test('shows a face, says nothing on the console and asks only its own origin', async () => {
    const { context, page, complaints, requests } = await open(browser, site, { sharp: true });
    const shown = await picture(page, 'first');
    // Skin is redder than blue; the backdrop is grey. A face fills a good part of the stage.
    let skin = 0;
    for (let o = 0; o < shown.rgb.length; o += 3) if (shown.rgb[o] > shown.rgb[o + 2] + 25) skin++;
    const share = skin / (shown.width * shown.height);
    assert.ok(share > 0.12 && share < 0.6, `skin covers ${(100 * share).toFixed(1)} % of the stage`);
    // Skin has light and shadow: one flat colour is no face.
    const tones = new Set();
    for (let o = 0; o < shown.rgb.length; o += 3 * 7) tones.add(shown.rgb[o] >> 3);
    assert.ok(tones.size > 16, `only ${tones.size} tones of red`);
    assert.deepEqual(complaints, []);
    assert.ok(requests.length > 3);
    for (const url of requests) {
      assert.ok(url.startsWith(site.origin) || /^(data|blob):/.test(url), `asked for ${url}`);
    }
    await context.close();
  });

  test('a slider of the nose changes the nose, not the backdrop; undo restores every pixel', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true, fine: true });
    const [nose, chin, brow] = [
      await landmarkOnScreen(page, 'ibug_30'),
      await landmarkOnScreen(page, 'ibug_08'),
      await landmarkOnScreen(page, 'ibug_19'),
    ];
    const atRest = await picture(page, 'nose-median');
    const box = await page.locator('canvas').boundingBox();
    assert.ok(box);
    const size = (chin.y - brow.y) / box.height;
    const [x, y] = [(nose.x - box.x) / box.width, (nose.y - box.y) / box.height];

    await moveSlider(page, 'nose 1', 0.98);
    const moved = await picture(page, 'nose-98');
    const around = differing(atRest, moved, [x - 0.2 * size, y - 0.25 * size, x + 0.2 * size, y + 0.2 * size]);
    assert.ok(around > 150, `only ${around} pixels changed around the nose`);
    for (const corner of [[0, 0, 0.12, 0.12], [0.88, 0, 1, 0.12], [0, 0.88, 0.12, 1], [0.88, 0.88, 1, 1]]) {
      assert.equal(differing(atRest, moved, corner), 0, `the backdrop changed at ${corner}`);
    }
    // The crown is far from the nose.
    assert.ok(differing(atRest, moved, [0.3, 0, 0.7, y - 1.2 * size]) < 0.1 * around);
    assert.equal(await page.evaluate(() => Math.round(window.designer.face.get('nose 1') * 100)), 98);

    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    const back = await picture(page, 'nose-undone');
    assert.ok(back.rgb.equals(atRest.rgb), 'undo left a difference');
    await page.keyboard.press('Control+y');
    const again = await picture(page, 'nose-redone');
    assert.ok(again.rgb.equals(moved.rgb), 'redo left a difference');
    await page.keyboard.press('Control+z');
    await page.keyboard.press('Control+Shift+Z');
    assert.ok((await picture(page, 'nose-redone-2')).rgb.equals(moved.rgb));
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('between lids is an eyeball and nothing behind the head, and none comes out of the skin beside them', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    /** The outer corners of the eyes, as fractions of the stage. */
    const corners = async () => {
      const box = await page.locator('canvas').boundingBox();
      assert.ok(box);
      const at = await Promise.all(['ibug_36', 'ibug_45'].map((name) => landmarkOnScreen(page, name)));
      return at.map(({ x, y }) => [(x - box.x) / box.width, (y - box.y) / box.height]);
    };
    /** @param {number} seed of a face, 0 of one with short eyes */
    const show = async (seed) => {
      await page.evaluate((value) => {
        const other = window.designer.model.face();
        if (value) other.randomize({ seed: value });
        else other.set('eyes length', 0);
        location.hash = other.code;
        other.free();
      }, seed);
      await page.waitForFunction(() => window.designer.face.code === location.hash.slice(1));
    };
    // Their lids meet outside of what an eyeball covers.
    for (const seed of [123, 118]) {
      await show(seed);
      const before = await picture(page, `eyes-${seed}`);
      await page.emulateMedia({ colorScheme: 'dark' });
      const after = await picture(page, `eyes-${seed}-dark`);
      assert.ok(differing(before, after, [0, 0, 0.2, 0.2]) > 1000);
      for (const [x, y] of await corners()) {
        assert.equal(differing(before, after, [x - 0.04, y - 0.04, x + 0.04, y + 0.04]), 0, `the wall is seen through face ${seed}`);
      }
      await page.emulateMedia({ colorScheme: 'light' });
    }
    // Theirs meet before much of it.
    await show(0);
    const { width, height, rgb } = await picture(page, 'eyes-short');
    for (const [x, y] of await corners()) {
      let dark = 0;
      for (let v = Math.round(y * height) + 3; v < y * height + 9; v++) {
        for (let u = Math.round(x * width) - (x < 0.5 ? 10 : -2); u < x * width + (x < 0.5 ? -2 : 10); u++) if (rgb[3 * (v * width + u)] < 150) dark++;
      }
      assert.equal(dark, 0, `${dark} pixels of an eyeball below the corner of the lids`);
    }
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('a random face is another face, and its link gives it back bit for bit', async () => {
    const { context, page } = await open(browser, site, { sharp: true });
    const median = await positions(page);
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    const random = await positions(page);
    assert.notEqual(random, median);
    await picture(page, 'random');
    const { hash } = new URL(page.url());
    assert.ok(hash.length > 10);

    const second = await open(browser, site, { sharp: true, hash });
    assert.equal(await positions(second.page), random);
    await second.context.close();

    // The seed gives the same person again.
    await page.getByText('Advanced').click();
    const seed = await page.getByRole('spinbutton', { name: 'Seed' }).inputValue();
    await page.getByRole('button', { name: 'Reset all' }).click();
    assert.equal(await positions(page), median);
    await page.getByRole('spinbutton', { name: 'Seed' }).fill(seed);
    await page.getByRole('button', { name: 'Use', exact: true }).click();
    assert.equal(await positions(page), random);
    await context.close();
  });

  test('a link with nonsense shows the median face and says so', async () => {
    const { context, page } = await open(browser, site, { hash: '#not-a-face' });
    assert.equal(await page.locator('.toast').textContent(), 'This link holds no face of this model, so you see the median face.');
    // One that comes while a face is worked on takes nothing of it.
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    const mine = await page.evaluate(() => window.designer.face.code);
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await page.evaluate(() => (location.hash = '#not-a-face'));
    await page.getByText('This link holds no face of this model, so yours stays.').waitFor();
    assert.equal(await page.evaluate(() => window.designer.face.code), mine);
    assert.ok((await page.evaluate(() => location.hash)).startsWith(`#${mine}`), 'the address is the face\u2019s again');
    assert.ok(await page.getByRole('button', { name: 'Redo', exact: true }).isEnabled());
    await context.close();
  });

  test('a picture that rests has smooth edges, on the screen and saved', async () => {
    const { context, page } = await open(browser, site, { sharp: true, fine: true });
    const rests = soft(await picture(page, 'smooth'));
    // Evenly spread over pixels, edges would be between in 0.7 of the rows.
    assert.ok(rests > 0.4, `${rests}`);
    await page.getByRole('button', { name: 'Take the face with you' }).click();
    const saved = soft(decodePng((await download(page, 'PNG')).bytes));
    assert.ok(saved > 0.4, `${saved}`);
    await context.close();
  });

  test('a graphics card that was lost and is back keeps no books of what is gone', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true, fine: true });
    const before = await picture(page, 'card-before');
    await loseCard(page.locator('canvas.view'));
    assert.equal(differing(before, await picture(page, 'card-back')), 0);
    // Of another size what rests is kept anew.
    const { width, height } = before;
    await page.setViewportSize({ width: width + 100, height });
    await settled(page);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('dragging turns the head, the views turn it back, and an idle page draws nothing', async () => {
    const { context, page } = await open(browser, site, { sharp: true, fine: true });
    const front = await picture(page, 'front');
    const at = await landmarkOnScreen(page, 'ibug_30');
    await page.mouse.move(at.x, at.y);
    await page.mouse.down();
    await page.mouse.move(at.x + 180, at.y, { steps: 5 });
    await page.mouse.up();
    await page.mouse.move(5, 5);
    const turned = await picture(page, 'turned');
    assert.ok(differing(front, turned) > 0.05 * front.width * front.height);
    await page.getByRole('button', { name: 'Profile' }).click();
    await picture(page, 'profile');
    await page.getByRole('button', { name: 'Front' }).click();
    assert.equal(differing(front, await picture(page, 'front-again')), 0);
    await page.locator('canvas').focus();
    await page.keyboard.press('ArrowLeft');
    assert.ok(differing(front, await picture(page, 'turned-by-key')) > 0.01 * front.width * front.height);
    const frames = await page.evaluate(() => window.designer.frames);
    await page.waitForTimeout(700);
    assert.equal(await page.evaluate(() => window.designer.frames), frames);

    // One comes closer to what is pointed at, and moves along it; the head is never lost, and the views bring it back.
    await page.evaluate(() => window.designer.refine(false));
    const view = await page.locator('canvas').boundingBox();
    assert.ok(view);
    const see = async (/** @type {string[]} */ ...names) => {
      await settled(page);
      return Promise.all(names.map((name) => landmarkOnScreen(page, name)));
    };
    const apart = ([a, b]) => Math.hypot(a.x - b.x, a.y - b.y);
    const reset = page.getByRole('button', { name: 'Reset the view' });
    await reset.click();
    const [mouth, ...apartAtFirst] = await see('ibug_66', 'ibug_36', 'ibug_45');
    const eyes = apart(apartAtFirst);
    await page.mouse.move(mouth.x, mouth.y);
    for (let i = 0; i < 3; i++) await page.mouse.wheel(0, -600);
    const [close, ...larger] = await see('ibug_66', 'ibug_36', 'ibug_45');
    assert.ok(apart(larger) > 1.6 * eyes, `eyes are ${eyes} px apart, and then ${apart(larger)}`);
    assert.ok(apart([mouth, close]) < 40, `the mouth goes ${apart([mouth, close])} px from the pointer`);
    await page.keyboard.down('Shift');
    await page.mouse.down();
    await page.mouse.move(mouth.x + 60, mouth.y - 30, { steps: 3 });
    await page.mouse.up();
    const [moved] = await see('ibug_66');
    assert.ok(moved.x - close.x > 40 && close.y - moved.y > 20, `the mouth goes from ${close.x}, ${close.y} to ${moved.x}, ${moved.y}`);
    await page.keyboard.press('ArrowLeft');
    assert.ok((await see('ibug_66'))[0].x > moved.x + 20, 'Shift and an arrow move nothing');
    await page.keyboard.up('Shift');
    await reset.click();
    await page.mouse.move(mouth.x, mouth.y);
    await page.mouse.down({ button: 'right' });
    await page.mouse.move(mouth.x + 3000, mouth.y, { steps: 3 });
    await page.mouse.up({ button: 'right' });
    const [far] = await see('ibug_66');
    assert.ok(far.x > mouth.x + 40 && far.x < view.x + view.width, `the mouth is at ${far.x}`);
    await reset.click();
    await page.locator('canvas').focus();
    for (let i = 0; i < 12; i++) await page.keyboard.press('ArrowDown');
    const [chin, jaw, ...both] = await see('ibug_08', 'gonion left', 'ibug_36', 'ibug_45');
    assert.ok(jaw.y > chin.y + 0.05 * apart(both), 'nobody looks under the chin');
    await reset.click();
    assert.ok(apart([mouth, ...(await see('ibug_66'))]) < 0.01, 'the view is reset to another one');
    await context.close();
  });

  test('hair, an open mouth and what is said have room on a low screen', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true, viewport: { width: 1100, height: 640 } });
    await page.locator('.invitation').getByRole('button', { name: 'Close' }).click();
    const chin = await landmarkOnScreen(page, 'ibug_08');
    const hint = await page.locator('.hint').boundingBox();
    assert.ok(hint);
    await page.getByRole('tab', { name: 'Looks' }).click();
    assert.ok(await page.locator('.hint').isHidden(), 'who chooses colours is not told to shape');
    await page.getByRole('button', { name: 'Wavy', exact: true }).click();
    await page.getByRole('tab', { name: 'Expressions' }).click();
    await moveSlider(page, 'Open jawOpen', 1);
    const opened = await landmarkOnScreen(page, 'ibug_08');
    const box = async (/** @type {string} */ part) => {
      const found = await page.locator(part).boundingBox();
      assert.ok(found, part);
      return found;
    };
    const [views, canvas] = [await box('.views'), await box('canvas')];
    assert.ok(opened.y > chin.y + 10 && opened.y < views.y, `the jaw is at ${opened.y}, the buttons at ${views.y}`);
    const shown = await picture(page, 'room');
    const dark = (/** @type {number} */ o) => shown.rgb[o] < 90;
    let top = 0;
    while (![...Array(shown.width).keys()].some((x) => dark(3 * (top * shown.width + x)))) top++;
    assert.ok(top + canvas.y > hint.y + hint.height, `hair begins at ${top + canvas.y}, the hint ends at ${hint.y + hint.height}`);
    await page.getByRole('button', { name: 'Neutral' }).click();
    await page.getByRole('button', { name: 'Copy link' }).click();
    const toast = await box('.toast');
    assert.ok(toast.y + toast.height < (await landmarkOnScreen(page, 'trichion')).y, 'what is said lies over the face');

    // A long beard has room as well, from any side; who went elsewhere stays there until a view is chosen.
    await page.getByRole('tab', { name: 'Looks' }).click();
    const [shaved, long] = ['Shaved', 'Long and full'].map((name) => page.getByRole('button', { name, exact: true }));
    await settled(page);
    // What of a long one is shaved has none.
    const small = await landmarkOnScreen(page, 'ibug_08');
    await moveSlider(page, 'Beard, short to long', 0.8);
    await settled(page);
    const room = await landmarkOnScreen(page, 'ibug_08');
    assert.ok(room.y < small.y - 5, `the chin is at ${small.y}, and above a beard at ${room.y}`);
    for (const part of ['Beard on the chin', 'Beard on the cheeks', 'Moustache']) await moveSlider(page, part, 0);
    await settled(page);
    const gone = await landmarkOnScreen(page, 'ibug_08');
    assert.ok(Math.abs(gone.y - small.y) < 1, `shaved off it leaves the chin at ${gone.y}`);
    await shaved.click();
    await settled(page);
    const before = await landmarkOnScreen(page, 'ibug_08');
    await long.click();
    for (const side of ['front', 'profile']) {
      if (side === 'profile') await page.getByRole('button', { name: 'Profile' }).click();
      await settled(page);
      // What is written on the buttons is dark, too.
      await page.locator('.views').evaluate((buttons) => (buttons.style.opacity = '0'));
      const { width, height, rgb } = await picture(page, `room-beard-${side}`);
      await page.locator('.views').evaluate((buttons) => (buttons.style.opacity = ''));
      let bottom = height - 1;
      while (![...Array(width).keys()].some((x) => rgb[3 * (bottom * width + x)] < 60)) bottom--;
      assert.ok(bottom + canvas.y < views.y, `the beard ends at ${bottom + canvas.y}, the buttons begin at ${views.y}`);
    }
    await page.locator('canvas').focus();
    await page.keyboard.press('ArrowLeft');
    await settled(page);
    const stays = await landmarkOnScreen(page, 'ibug_08');
    await shaved.click();
    await settled(page);
    const stayed = await landmarkOnScreen(page, 'ibug_08');
    // Numbers of a camera that comes back have other last digits.
    assert.ok(Math.hypot(stayed.x - stays.x, stayed.y - stays.y) < 1e-6, 'a view that somebody set is moved');
    await page.getByRole('button', { name: 'Reset the view' }).click();
    await settled(page);
    assert.ok(Math.abs((await landmarkOnScreen(page, 'ibug_08')).y - before.y) < 1, 'without a beard the view is another than it was');

    // Where the stage is narrow, curls are wider than a head.
    await page.setViewportSize({ width: 900, height: 900 });
    await moveSlider(page, 'Length, cropped to below the chin', 1);
    await moveSlider(page, 'Straight, wavy, curly', 1);
    await settled(page);
    await page.getByRole('button', { name: 'Profile' }).click();
    const { width, height, rgb } = await picture(page, 'room-curls');
    const cut = [0, width - 1].map((x) => [...Array(height).keys()].filter((y) => rgb[3 * (y * width + x)] < 90).length);
    assert.deepEqual(cut, [0, 0], 'hair is cut by the edges of the picture');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('on a phone nothing overflows, and a finger turns the head', async () => {
    for (const width of [390, 320]) {
      const { context, page, complaints } = await open(browser, site, {
        viewport: { width, height: width === 390 ? 844 : 568 },
        deviceScaleFactor: 2,
        hasTouch: true,
        isMobile: true,
      });
      const before = await picture(page, `phone-${width}`);
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
      assert.ok(overflow <= 0, `${overflow} px too wide at ${width}`);
      const at = await landmarkOnScreen(page, 'ibug_30');
      const fingers = await context.newCDPSession(page);
      const touch = (type, x) =>
        fingers.send('Input.dispatchTouchEvent', { type, touchPoints: type === 'touchEnd' ? [] : [{ x, y: at.y }] });
      await touch('touchStart', at.x);
      for (let i = 1; i <= 5; i++) await touch('touchMove', at.x + 16 * i);
      await touch('touchEnd', 0);
      const turned = await picture(page, `phone-${width}-turned`);
      assert.ok(differing(before, turned) > 0.03 * before.width * before.height);
      await pictureOfPage(page, `phone-${width}-page`);
      assert.deepEqual(complaints, []);
      await context.close();
    }
  });

  test('follows the dark scheme of the system, and the toggle overrules it', async () => {
    const { context, page } = await open(browser, site, { sharp: true, colorScheme: 'dark' });
    const luminance = (shown) => (shown.rgb[0] + shown.rgb[1] + shown.rgb[2]) / 3;
    assert.ok(luminance(await picture(page, 'dark')) < 60);
    await pictureOfPage(page, 'dark-page');
    await page.getByRole('button', { name: 'Light or dark' }).click();
    assert.ok(luminance(await picture(page, 'light')) > 150);
    await context.close();
  });
});

describe('one page after another of these', () => {
  const visit = onePage(browser, site);

  test('one gesture is one step of undo; a double click goes back to the median', async () => {
    const { page } = visit;
    const slider = page.getByRole('slider', { name: 'nose 1', exact: true });
    const value = () => page.evaluate(() => window.designer.face.get('nose 1'));
    const median = await value();
    const box = await slider.boundingBox();
    assert.ok(box);
    const y = box.y + box.height / 2;
    await page.mouse.move(box.x + box.width / 2, y);
    await page.mouse.down();
    for (let i = 1; i <= 8; i++) await page.mouse.move(box.x + box.width * (0.5 + 0.05 * i), y);
    await page.mouse.up();
    assert.ok((await value()) > 0.75);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.equal(await value(), median);
    assert.ok(await page.getByRole('button', { name: 'Undo', exact: true }).isDisabled());

    await moveSlider(page, 'nose 1', 0.2);
    const thumb = await slider.boundingBox();
    assert.ok(thumb);
    await page.mouse.dblclick(thumb.x + 0.2 * thumb.width, thumb.y + thumb.height / 2);
    assert.ok(Math.abs((await value()) - 0.5) < 0.005);
  });

  test('Escape, and a pointer that is taken away, give up what is being dragged; another pointer moves nothing', async () => {
    const { page } = visit;
    const undo = page.getByRole('button', { name: 'Undo', exact: true });
    const state = () => page.evaluate(() => JSON.stringify([window.designer.face.code, window.designer.face.expression, window.designer.colouring]));
    const press = (/** @type {string} */ key) => page.keyboard.press(key);
    const middle = async (/** @type {import('playwright-core').Locator} */ on) => {
      await on.scrollIntoViewIfNeeded();
      const box = await on.boundingBox();
      assert.ok(box);
      return { x: box.x + box.width / 2, y: box.y + box.height / 2, far: 0.3 * box.width };
    };
    /** Whatever is dragged, the face is the one of before, also when the pointer goes on. */
    const givenUp = async (/** @type {string} */ what, /** @type {{ x: number, y: number, far: number }} */ { x, y, far }, give = () => press('Escape')) => {
      const [before, steps] = [await state(), await undo.isEnabled()];
      await page.mouse.move(x, y);
      await page.mouse.down();
      for (let i = 1; i <= 4; i++) await page.mouse.move(x + (i * far) / 4, y + (i * far) / 8);
      await settled(page);
      assert.notEqual(await state(), before, `${what} was dragged`);
      await give();
      assert.equal(await state(), before, `${what} is as it was`);
      await page.mouse.move(x - far, y);
      await settled(page);
      await page.mouse.up();
      assert.equal(await state(), before, `${what} stays so`);
      assert.equal(await undo.isEnabled(), steps, `${what}: there is no step`);
    };
    /** As a browser does when it takes a gesture for its own. */
    const takenAway = (/** @type {string} */ selector) => () =>
      page.locator(selector).first().evaluate((on) => on.dispatchEvent(new PointerEvent('pointercancel', { pointerId: 1, bubbles: true })));

    await page.getByRole('button', { name: 'Reset all' }).click();
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.locator('.tab[data-group="nose"]').click();
    const slider = page.getByRole('slider', { name: 'nose 1', exact: true });
    await givenUp('a slider', await middle(slider));
    await givenUp('a slider', await middle(slider), takenAway('#control-nose-1'));

    // What composes a word of several keys takes Enter and Escape for itself.
    await slider.focus();
    await press('7');
    const typed = page.getByRole('spinbutton', { name: 'Percentile of nose 1' });
    for (const key of ['Enter', 'Escape']) {
      await typed.evaluate((field, key) => field.dispatchEvent(new KeyboardEvent('keydown', { key, isComposing: true, bubbles: true })), key);
      assert.ok(await typed.isVisible(), `${key} is not the field's`);
    }
    await press('Escape');
    assert.ok(await typed.isHidden());

    const nose = await landmarkOnScreen(page, 'ibug_30');
    await page.mouse.click(nose.x, nose.y);
    await page.getByText('Drag the nose: what is not locked follows').waitFor();
    for (const give of [undefined, takenAway('canvas.view')]) {
      await givenUp('the surface', { ...nose, far: 24 }, give);
      assert.equal(await page.locator('.grip:visible').count(), 0);
      assert.match((await page.locator('.hint').textContent()) ?? '', /^Drag the nose/, 'the nose stays chosen');
    }
    await page.locator('canvas.view').focus();
    await press('Escape');
    assert.equal(await page.locator('.hint').textContent(), 'Click a feature to shape it');

    await page.getByRole('tab', { name: 'Looks' }).click();
    await givenUp('a colour', await middle(page.locator('#colour-skin')));
    await page.getByRole('tab', { name: 'Mix' }).click();
    for (const face of ['Preset 1', 'Preset 2']) {
      await page.locator('.tray').getByRole('button', { name: face, exact: true }).click();
      await page.getByRole('button', { name: 'Add to the circle' }).click();
    }
    const puck = page.getByRole('slider', { name: 'Mixture' });
    const shares = await puck.getAttribute('aria-valuetext');
    await givenUp('the puck', { ...(await middle(page.locator('.ring'))), far: 30 });
    assert.equal(await puck.getAttribute('aria-valuetext'), shares);
    await givenUp('an amount', await middle(page.locator('#mix-amount')));
    assert.equal(await page.locator('#mix-amount').inputValue(), '0');
    await page.getByRole('tab', { name: 'Expressions' }).click();
    await page.getByRole('slider', { name: 'mouthSmile' }).first().waitFor({ timeout: 60_000 });
    await givenUp('the gaze', { ...(await middle(page.locator('.gaze'))), far: 20 });
    await givenUp('an expression', await middle(page.locator('#expression-jawOpen')));

    // A second pointer over what the first one holds.
    for (const [tab, selector] of /** @type {const} */ ([['Expressions', '.gaze'], ['Mix', '.ring']])) {
      await page.getByRole('tab', { name: tab }).click();
      const { x, y } = await middle(page.locator(selector));
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + 12, y);
      const before = await state();
      await page.locator(selector).evaluate((on, [x, y]) => {
        for (const type of ['pointermove', 'pointerup']) on.dispatchEvent(new PointerEvent(type, { pointerId: 77, clientX: x, clientY: y, bubbles: true }));
      }, [x - 20, y - 20]);
      assert.equal(await state(), before, selector);
      await page.mouse.move(x + 16, y + 10);
      assert.notEqual(await state(), before, `${selector} is still held`);
      await page.mouse.up();
    }
    await page.getByRole('button', { name: 'Reset all' }).click();
    await page.getByRole('tab', { name: 'Features' }).click();
  });

  test('a locked feature stays as it is when the rest is random', async () => {
    const { page } = visit;
    await moveSlider(page, 'nose 1', 0.9);
    const nose = () => page.evaluate(() => window.designer.face.get('nose 1'));
    const kept = await nose();
    await page.getByRole('button', { name: 'Lock the nose' }).click();
    await page.getByRole('button', { name: 'Random face', exact: true }).click();
    assert.equal(await nose(), kept);
    await page.getByRole('button', { name: 'Lock the nose' }).click();
    await page.getByRole('button', { name: 'Random nose' }).click();
    assert.notEqual(await nose(), kept);
  });

  test('every slider has the name of its control, a value in words and a description', async () => {
    const { page } = visit;
    // Those that set lengths have a section of their own, and a test.
    const groups = await page.evaluate(() => [...new Set(window.designer.model.controls.filter((c) => !c.measure).map((c) => c.group))]);
    assert.ok(groups.length >= 5, groups.join());
    for (const group of groups) {
      await page.locator(`.tab[data-group="${group}"]`).click();
      const more = page.getByRole('button', { name: /^Show \d+ more$/ });
      if (await more.isVisible()) await more.click();
      const expected = await page.evaluate(
        (g) => window.designer.model.controls.filter((c) => c.group === g && !c.measure).map((c) => c.name),
        group,
      );
      for (const name of expected) {
        const slider = page.getByRole('slider', { name, exact: true });
        assert.match((await slider.getAttribute('aria-valuetext')) ?? '', /^\d+(st|nd|rd|th)$/);
        const about = page.locator(`#${await slider.getAttribute('aria-describedby')}`);
        assert.ok(((await about.textContent()) ?? '').length > 3, `${name} has no description`);
      }
    }
  });

  test('clicking a feature on the face opens its sliders', async () => {
    const { page } = visit;
    for (const [landmark, group] of [
      ['ibug_57', 'mouth'],
      ['ibug_30', 'nose'],
      ['ibug_41', 'eyes'],
      ['ibug_46', 'eyes'],
      ['ibug_08', 'chin'],
    ]) {
      const at = await landmarkOnScreen(page, landmark);
      // The chin's landmark lies on the outline: aim a little above it.
      await page.mouse.click(at.x, at.y - (group === 'chin' ? 8 : 0));
      assert.equal(
        await page.locator('.tab[aria-pressed=true]').getAttribute('data-group'),
        group,
        `a click at ${landmark}`,
      );
    }
    await settled(page);
  });

  test('a display with other pixels gets a picture of as many', async () => {
    const { context, page } = visit;
    const session = await context.newCDPSession(page);
    const pixels = () => page.evaluate(() => document.querySelector('canvas.view')?.width);
    const before = await pixels();
    for (const [deviceScaleFactor, factor] of [[0.5, 2], [0.25, 1]]) {
      await session.send('Emulation.setDeviceMetricsOverride', { ...TALL, deviceScaleFactor, mobile: false });
      // Chromium 156 tells nobody of pixels that are only played before another question of the kind has another answer.
      await page.emulateMedia({ contrast: 'more' });
      await page.emulateMedia({ contrast: null });
      await page.waitForFunction((wanted) => document.querySelector('canvas.view')?.width === wanted, factor * before, { timeout: 5000 });
      if (deviceScaleFactor < 0.5) continue;
      // A page that is zoomed out to half of its size is refined all the same.
      await settled(page);
      const draws = await page.evaluate(async () => {
        const { frames } = window.designer;
        window.designer.refine(true);
        while (!window.designer.isFine) await new Promise((next) => requestAnimationFrame(next));
        window.designer.refine(false);
        return window.designer.frames - frames;
      });
      assert.ok(draws > 3, `${draws} drawings`);
    }
    await session.detach();
  });

  test('a stage that gets another size is drawn before it is shown', async () => {
    const { page } = visit;
    await settled(page);
    const drawn = await page.evaluate(
      () =>
        new Promise((done) => {
          const canvas = document.querySelector('canvas.view');
          // With the size goes the picture: what was drawn before does not count.
          let frames = Infinity;
          const { get, set } = Object.getOwnPropertyDescriptor(HTMLCanvasElement.prototype, 'width');
          Object.defineProperty(canvas, 'width', {
            configurable: true,
            get,
            set(width) {
              frames = window.designer.frames;
              set.call(this, width);
            },
          });
          const before = canvas.width;
          // Hears of it after the stage does.
          const observer = new ResizeObserver(() => {
            if (canvas.width === before) return;
            observer.disconnect();
            delete canvas.width;
            document.body.style.width = '';
            done(window.designer.frames - frames);
          });
          observer.observe(canvas);
          document.body.style.width = '70%';
        }),
    );
    assert.ok(drawn >= 1, `${drawn} drawings`);
    await settled(page);
  });

  test('explains itself', async () => {
    const { page } = visit;
    await page.getByRole('button', { name: 'What is this?' }).click();
    const dialog = page.getByRole('dialog');
    for (const word of ['eigenmesh', 'percentile', 'population']) {
      assert.ok(await dialog.getByText(word).first().isVisible(), word);
    }
    const { population } = await page.evaluate(() => window.designer.model.about);
    assert.ok(await dialog.getByText(population).isVisible());
    await page.keyboard.press('Escape');
    assert.ok(await dialog.isHidden());
  });
});

describe('the models of the page', () => {
  test('the synthetic one is chosen in the panel that explains, and by the address', async () => {
    const { context, page, complaints, requests } = await open(browser, site);
    const own = await page.evaluate(() => window.designer.model.about);
    await moveSlider(page, 'nose 1', 0.9);
    await page.getByRole('button', { name: 'What is this?' }).click();
    const list = page.locator('.models');
    assert.match((await list.locator('[aria-current]').textContent()) ?? '', /scanned/);
    assert.ok(!requests.some((url) => url.endsWith('/synthetic.phiz')), 'one model is enough');
    await list.getByRole('link', { name: 'synthetic people' }).click();
    await page.waitForURL(/\?model=synthetic$/);
    await page.waitForFunction(() => document.documentElement.dataset.ready === 'true');
    assert.ok(requests.some((url) => url.endsWith('/synthetic.phiz')));
    const other = await page.evaluate(() => window.designer.model.about);
    assert.match(other.population, /[Ss]ynthetic/);
    // A link to a face of it names it too.
    await moveSlider(page, 'nose 1', 0.9);
    const address = new URL(page.url());
    assert.equal(address.search, '?model=synthetic');
    assert.ok(address.hash.length > 10);
    await page.getByRole('button', { name: 'What is this?' }).click();
    await list.getByRole('link', { name: 'scanned people' }).click();
    await page.waitForFunction(() => !location.search && document.documentElement.dataset.ready === 'true');
    assert.deepEqual(await page.evaluate(() => window.designer.model.about), own);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('an address with a model that is not there says so and shows the usual one', async () => {
    const { context, page } = await open(browser, site, { hash: '?model=constructor' });
    assert.match((await page.getByRole('status').first().textContent()) ?? '', /model that is not here/);
    assert.ok(await page.evaluate(() => window.designer.face.positions.length > 0));
    await context.close();
  });
});

describe('when something is missing, the page says what', () => {
  for (const [name, model, sentence] of /** @type {const} */ ([
    ['a damaged model', Buffer.from('this is no model'), /The face model on this site cannot be used: .+/],
    ['no model', null, /could not be downloaded \(404/],
  ])) {
    test(name, async () => {
      const broken = await serve({ model });
      const { context, page } = await open(browser, broken);
      assert.match((await page.getByRole('alert').textContent()) ?? '', sentence);
      await context.close();
      await broken.close();
    });
  }

  test('no WebGL 2', async () => {
    const context = await browser.newContext();
    await context.addInitScript(() => {
      const real = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
        return kind === 'webgl2' ? null : real.call(this, kind, ...rest);
      };
    });
    const page = await context.newPage();
    await page.goto(site.url);
    assert.match((await page.getByRole('alert').textContent()) ?? '', /WebGL 2/);
    await context.close();
  });

  test('no WebAssembly', async () => {
    const context = await browser.newContext();
    await context.addInitScript(() => delete window.WebAssembly);
    const page = await context.newPage();
    await page.goto(site.url);
    assert.match((await page.getByRole('alert').textContent()) ?? '', /WebAssembly/);
    await context.close();
  });
});
