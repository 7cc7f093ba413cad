import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { describe, test } from 'node:test';
import { differing, landmarkOnScreen, moveSlider, open, picture, pictureOfPage, pressQuickly, settled, siteAndBrowser } from './site.js';

const { browser, site } = await siteAndBrowser();

const colouring = (page) => page.evaluate(() => window.designer.colouring);
const codeOf = (page) => page.evaluate(() => window.designer.face.code);
const choose = (page) => page.getByRole('tab', { name: 'Looks' }).click();

/** How light a colour is, 0 to 255. */
const light = ([r, g, b]) => 0.3 * r + 0.59 * g + 0.11 * b;

/** Where to look at colours in a picture of the stage, and how. */
async function looking(page) {
  const box = await page.locator('canvas.view').boundingBox();
  assert.ok(box);
  /** @type {Record<string, { x: number, y: number }>} */
  const at = {};
  for (const name of ['ibug_19', 'ibug_30', 'ibug_31', 'ibug_32', 'ibug_33', 'ibug_36', 'ibug_39', 'ibug_48', 'ibug_54', 'ibug_57', 'ibug_66', 'ibug_08', 'metopion', 'trichion', 'intertragic notch left', 'superaurale left', 'gonion left']) {
    const { x, y } = await landmarkOnScreen(page, name);
    at[name] = { x: x - box.x, y: y - box.y };
  }
  const middle = (a, b, t = 0.5) => ({ x: at[a].x + t * (at[b].x - at[a].x), y: at[a].y + t * (at[b].y - at[a].y) });
  const eye = middle('ibug_36', 'ibug_39');
  const across = at.ibug_39.x - at.ibug_36.x;
  const places = {
    // Between the nose and the corner of the mouth, away from what is painted.
    cheek: { x: at.ibug_36.x, y: at.ibug_33.y },
    'under the eye': { x: at.ibug_36.x + 0.4 * across, y: 0.55 * at.ibug_36.y + 0.45 * at.ibug_33.y },
    lip: middle('ibug_57', 'ibug_66'),
    // Beside the pupil, below the window that is mirrored in it.
    iris: { x: eye.x - 0.14 * across, y: eye.y + 0.07 * across },
    brow: at.ibug_19,
    // Half a forehead above the hairline, and below it.
    scalp: middle('metopion', 'trichion', 1.6),
    forehead: at.metopion,
    chin: middle('ibug_57', 'ibug_08'),
    'above the lip': middle('ibug_33', 'ibug_66', 0.4),
    ear: at['intertragic notch left'],
    'above the ear': { x: at['superaurale left'].x, y: at['superaurale left'].y - 0.6 * Math.abs(at.metopion.y - at.trichion.y) },
    jaw: middle('ibug_54', 'gonion left', 0.6),
    nostril: { x: middle('ibug_31', 'ibug_32').x, y: middle('ibug_32', 'ibug_30', 0.3).y },
  };
  /** The pixels around a place. @param {{ width: number, rgb: Buffer }} shown @param {keyof typeof places} name @param {number} half */
  const square = (shown, name, half) => {
    const [left, top] = [Math.round(places[name].x) - half, Math.round(places[name].y) - half];
    const side = 2 * half + 1;
    return Array.from({ length: side * side }, (_, i) => {
      const o = 3 * ((top + Math.floor(i / side)) * shown.width + left + (i % side));
      return [...shown.rgb.subarray(o, o + 3)];
    });
  };
  return {
    places,
    size: across,
    square,
    /** @param {{ width: number, rgb: Buffer }} shown @param {keyof typeof places} name @param {number} [half] */
    colour(shown, name, half = 2) {
      const all = square(shown, name, half);
      return [0, 1, 2].map((k) => all.reduce((sum, rgb) => sum + rgb[k], 0) / all.length);
    },
    /** How dark the darkest tenth and the lightest tenth of a square around a place are, 0 to 255. */
    extremes(shown, name, half) {
      const lights = square(shown, name, half).map(light).sort((a, b) => a - b);
      return [lights[Math.floor(0.1 * lights.length)], lights[Math.floor(0.9 * lights.length)]];
    },
    /** How many pixels differ in a square around a place. */
    around(a, b, name, half) {
      const { x, y } = places[name];
      return differing(a, b, [(x - half) / a.width, (y - half) / a.height, (x + half) / a.width, (y + half) / a.height]);
    },
  };
}

describe('colours', () => {
  test('each slider paints what it is named for and nothing else; undo takes the paint off again', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    await choose(page);
    const look = await looking(page);
    const code = await codeOf(page);
    const rest = await picture(page, 'colours-rest');

    // Skin goes from fair to deep all the way, and redder as it goes.
    let before = Infinity;
    let redness = 0;
    for (const skin of [0, 0.25, 0.5, 0.75, 1]) {
      await moveSlider(page, 'Skin, fair to deep', skin);
      const shown = await picture(page, `colours-skin-${skin}`);
      const cheek = look.colour(shown, 'cheek');
      assert.ok(light(cheek) < before - 8, `a skin of ${skin} is no deeper: ${light(cheek)} after ${before}`);
      assert.ok(cheek[0] > cheek[1] && cheek[1] > cheek[2], `skin is no colour of skin: ${cheek}`);
      assert.ok(cheek[0] / cheek[2] > redness - 0.05, 'melanin takes blue first');
      redness = cheek[0] / cheek[2];
      before = light(cheek);
      // Nostrils are holes in everybody: dark, and of no red that the skin around them does not have.
      const [dark] = look.extremes(shown, 'nostril', 5);
      assert.ok(dark < 0.55 * light(cheek), `nostrils are ${dark}, cheeks ${light(cheek)}`);
      const red = look.square(shown, 'nostril', 5).filter(([r, g]) => r > 0.5 * cheek[0] && r > 3.5 * g);
      assert.deepEqual(red, [], 'nostrils are red');
      // The eye's own colours stay.
      const [was, is] = [look.colour(rest, 'iris', 1), look.colour(shown, 'iris', 1)];
      assert.ok(was.every((value, k) => Math.abs(value - is[k]) < 12), `the iris changed with the skin: ${was} to ${is}`);
    }
    await page.getByRole('button', { name: 'The model’s own' }).click();
    const own = await picture(page, 'colours-own');
    assert.ok(own.rgb.equals(rest.rgb), 'the model’s own colours are not what they were');

    for (const [name, value, place, near] of [
      ['Lips, pale to red', 1, 'lip', 1.2],
      ['Hair, fair to black', 0.05, 'brow', 1.4],
      ['Brows, thin to bushy', 0, 'brow', 1.4],
      ['Brows, straight to arched', 1, 'brow', 1.4],
      ['Brows, narrow to broad', 1, 'brow', 1.4],
      ['Iris, blue to brown', 0, 'iris', 0.7],
    ]) {
      await moveSlider(page, name, value);
      const shown = await picture(page, `colours-${name.split(',')[0]}`);
      const here = look.around(rest, shown, place, near * look.size);
      assert.ok(here > 20, `${name} changed only ${here} pixels where it should`);
      assert.equal(look.around(rest, shown, 'cheek', 6), 0, `${name} changed the cheek`);
      await page.getByRole('button', { name: 'Undo', exact: true }).click();
      const back = await picture(page, 'colours-undone');
      assert.ok(back.rgb.equals(rest.rgb), `undo left some of ${name}`);
    }

    // What is painted of brows and the hairs on it go together, as high as the slider says: 5 mm, an eye is 30 wide.
    const height = async (/** @type {number} */ value) => {
      await moveSlider(page, 'Brows, low to high', value);
      const shown = await picture(page, `colours-brows-${value}`);
      const half = Math.round(0.7 * look.size);
      const side = 2 * half + 1;
      const lights = look.square(shown, 'brow', half).map(light);
      const skin = look.extremes(shown, 'brow', half)[1];
      const dark = lights.map((value) => Math.max(0, skin - 25 - value));
      return dark.reduce((sum, value, i) => sum + value * Math.floor(i / side), 0) / dark.reduce((sum, value) => sum + value, 0);
    };
    const [low, high] = [await height(0.3), await height(0.7)];
    const risen = (low - high) / look.size;
    assert.ok(risen > 0.07 && risen < 0.2, `brows rose by ${risen} of an eye, not by 4 mm`);
    await page.getByRole('button', { name: 'The model’s own' }).click();

    // Years fold a face, and freckles dot it; neither touches eyes or the skin under hair.
    for (const [name, place] of [['Lines, none to deep', 'forehead'], ['Freckles, none to many', 'under the eye']]) {
      await moveSlider(page, name, 1);
      const shown = await picture(page, `colours-${name.split(',')[0]}`);
      assert.ok(look.around(rest, shown, place, 20) > 60, `${name}: ${look.around(rest, shown, place, 20)} pixels changed at the ${place}`);
      for (const other of ['iris', 'scalp']) assert.equal(look.around(rest, shown, other, 4), 0, `${name} changed the ${other}`);
      await page.getByRole('button', { name: 'Undo', exact: true }).click();
      assert.ok((await picture(page, 'colours-undone')).rgb.equals(rest.rgb), `undo left some of ${name}`);
    }

    // Hair and beard grow where they do on people, and nowhere else; their colour is the hair's.
    for (const view of ['Front', 'Profile']) {
      await page.getByRole('button', { name: view, exact: true }).click();
      await settled(page);
      const seen = await looking(page);
      const bald = await picture(page, `colours-bald-${view}`);
      for (const [name, grows, bare] of view === 'Front'
        ? /** @type {const} */ ([
            ['Hair on the head, none to dense', ['scalp'], ['forehead', 'chin', 'cheek', 'lip', 'iris']],
            ['Stubble, none to dense', ['chin'], ['scalp', 'forehead', 'lip', 'iris']],
          ])
        : /** @type {const} */ ([
            ['Hair on the head, none to dense', ['above the ear'], ['ear', 'jaw']],
            ['Stubble, none to dense', ['jaw'], ['ear', 'above the ear']],
          ])) {
        await moveSlider(page, name, 0.9);
        const grown = await picture(page, `colours-${view}-${name.split(',')[0]}`);
        for (const place of grows) {
          const [was, is] = [seen.colour(bald, place, 4), seen.colour(grown, place, 4)];
          assert.ok(light(is) < 0.6 * light(was), `${view}: ${name} at the ${place}: ${was} to ${is}`);
        }
        for (const place of bare) assert.equal(seen.around(bald, grown, place, 4), 0, `${view}: ${name} grows at the ${place}`);
        await moveSlider(page, 'Hair, fair to black', 0);
        const fair = await picture(page, 'colours-fair');
        for (const place of grows) assert.ok(light(seen.colour(fair, place, 4)) > 1.3 * light(seen.colour(grown, place, 4)), `${view}: fair hair at the ${place}`);
        await page.getByRole('button', { name: 'The model’s own' }).click();
      }
    }
    await page.getByRole('button', { name: 'Front', exact: true }).click();

    await moveSlider(page, 'Iris, blue to brown', 0);
    const blue = look.colour(await picture(page, 'colours-blue'), 'iris', 1);
    assert.ok(blue[2] > blue[0] + 10, `a blue iris is ${blue}`);
    await moveSlider(page, 'Lips, pale to red', 1);
    const painted = look.colour(await picture(page, 'colours-red'), 'lip');
    const plain = look.colour(rest, 'lip');
    assert.ok(painted[1] / painted[0] < 0.8 * (plain[1] / plain[0]), `red lips are ${painted}, and were ${plain}`);
    assert.deepEqual(await colouring(page), { iris: 0, lips: 1 });
    assert.equal(await codeOf(page), code, 'colours changed the shape');

    // Keys and numbers work as on every slider; a run of keys is one step.
    const skin = page.getByRole('slider', { name: 'Skin, fair to deep', exact: true });
    await skin.focus();
    await page.keyboard.press('ArrowRight');
    assert.equal((await colouring(page)).skin, 0.31);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await pressQuickly(skin, 'ArrowRight', 5);
    assert.equal((await colouring(page)).skin, 0.35);
    assert.equal(await skin.getAttribute('aria-valuetext'), '35%');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(await colouring(page), { iris: 0, lips: 1 });
    await page.getByRole('button', { name: 'Random looks' }).click();
    assert.ok(Object.keys(await colouring(page)).length > 3);
    await page.getByRole('button', { name: 'Reset all' }).click();
    assert.deepEqual(await colouring(page), {});

    // A few days' beard is dark hairs with skin between them, which takes pixels to be seen.
    await page.setViewportSize({ width: 1280, height: 800 });
    // Hair that was there a moment ago had the view go back.
    await settled(page);
    const close = await looking(page);
    const shaven = close.extremes(await picture(page, 'colours-shaven'), 'chin', 10);
    await moveSlider(page, 'Stubble, none to dense', 0.3);
    const stubble = close.extremes(await picture(page, 'colours-stubble'), 'chin', 10);
    assert.ok(stubble[0] < 0.85 * shaven[0] && stubble[1] > 0.9 * shaven[1], `stubble is a tint: ${stubble}, shaven ${shaven}`);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('hair is as long as it is asked to be, lies as it is combed, and is not measured', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    await choose(page);
    const look = await looking(page);
    const bald = await picture(page, 'hair-none');
    // Beside the cheek, where there is nothing but long hair; on the forehead, where a fringe is.
    const cheek = look.places.cheek;
    const nose = (await looking(page)).places.chin.x;
    const beside = { x: cheek.x - 0.75 * (nose - cheek.x), y: cheek.y };
    look.places.beside = beside;
    const long = 'Length, cropped to below the chin';
    await moveSlider(page, long, 0.9);
    const hanging = await picture(page, 'hair-long');
    assert.ok(look.around(bald, hanging, 'scalp', 10) > 300, 'no hair on the head');
    assert.ok(look.around(bald, hanging, 'beside', 12) > 300, 'long hair does not hang beside the cheeks');
    for (const place of ['iris', 'lip', 'chin']) assert.equal(look.around(bald, hanging, place, 4), 0, `hair hangs over the ${place}`);
    await moveSlider(page, long, 0.25);
    const short = await picture(page, 'hair-short');
    assert.equal(look.around(bald, short, 'beside', 12), 0, 'short hair hangs beside the cheeks');
    assert.ok(look.around(bald, short, 'scalp', 10) > 300);
    // The shortest covers the head as well.
    await moveSlider(page, long, 0.05);
    const shortest = await picture(page, 'hair-shortest');
    const [none, least, more] = [bald, shortest, short].map((shown) => light(look.colour(shown, 'scalp', 10)));
    assert.ok(least < none - 0.6 * (none - more), `the scalp is ${none} without hair, ${least} with the shortest, ${more} with short hair`);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    // It is thinned as a crop is: some stands where all of it stood, and in the end none.
    const density = 'Hair on the head, none to dense';
    assert.equal(await page.getByRole('slider', { name: density, exact: true }).getAttribute('aria-valuetext'), '100%');
    await moveSlider(page, density, 0.2);
    const thin = await picture(page, 'hair-thin');
    const lights = [bald, thin, short].map((shown) => light(look.colour(shown, 'scalp', 10)));
    assert.ok(lights[0] > lights[1] + 10 && lights[1] > lights[2] + 20, `the scalp is ${lights}: bald, thin, whole`);
    await moveSlider(page, density, 0);
    assert.equal(differing(bald, await picture(page, 'hair-thinned-off')), 0, 'hair of which there is none');
    for (let step = 0; step < 2; step++) await page.getByRole('button', { name: 'Undo', exact: true }).click();
    // It recedes from the forehead, and stays above the ears.
    await moveSlider(page, 'Hairline, full to bald on top', 1);
    const receded = await picture(page, 'hair-receded');
    assert.ok(light(look.colour(receded, 'scalp', 6)) > 0.9 * light(look.colour(bald, 'scalp', 6)), 'hair on top of who is bald there');
    assert.ok(differing(bald, receded) > 300, 'no hair at the sides');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await moveSlider(page, long, 0.55);
    await moveSlider(page, 'Combed back, aside, forward', 0);
    const back = await picture(page, 'hair-back');
    await moveSlider(page, 'Combed back, aside, forward', 1);
    const fringe = await picture(page, 'hair-fringe');
    assert.equal(look.around(bald, back, 'forehead', 4), 0, 'hair that is combed back falls on the forehead');
    assert.ok(look.around(bald, fringe, 'forehead', 6) > 60, 'a fringe leaves the forehead free');
    for (const [name, value] of [['Parting, left to right', 0.9], ['Straight, wavy, curly', 0.8]]) {
      await moveSlider(page, 'Combed back, aside, forward', 0.5);
      const before = await picture(page, 'hair-before');
      await moveSlider(page, name, value);
      assert.ok(differing(before, await picture(page, `hair-${name.split(',')[0]}`)) > 3000, `${name} changes nothing`);
    }
    // A beard grows around the mouth, and not over it.
    const clean = await picture(page, 'hair-shaved');
    await moveSlider(page, 'Beard, short to long', 0.5);
    const bearded = await picture(page, 'hair-beard');
    assert.ok(look.around(clean, bearded, 'chin', 10) > 250, 'no beard on the chin');
    for (const place of ['lip', 'iris', 'forehead']) assert.equal(look.around(clean, bearded, place, 4), 0, `a beard at the ${place}`);
    for (const part of ['chin', 'cheeks']) await moveSlider(page, `Beard on the ${part}`, 0);
    const moustache = await picture(page, 'hair-moustache');
    assert.equal(look.around(clean, moustache, 'chin', 6), 0, 'a shaved chin has a beard');
    assert.ok(look.around(clean, moustache, 'above the lip', 4) > 40, 'no moustache');
    for (let step = 0; step < 2; step++) await page.getByRole('button', { name: 'Undo', exact: true }).click();
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.ok((await picture(page, 'hair-shaved-again')).rgb.equals(clean.rgb), 'undo leaves some of a beard');
    // Styles to begin from are one step each, and say when they are worn.
    const bob = page.getByRole('button', { name: 'Bob', exact: true });
    const own = await colouring(page);
    assert.equal(await bob.getAttribute('aria-pressed'), 'false');
    await bob.click();
    assert.equal(await bob.getAttribute('aria-pressed'), 'true');
    assert.ok(look.around(bald, await picture(page, 'hair-bob'), 'beside', 12) > 300, 'a bob does not hang beside the cheeks');
    await page.getByRole('button', { name: 'Trimmed', exact: true }).click();
    assert.ok((await colouring(page)).beardLength > 0 && (await bob.getAttribute('aria-pressed')) === 'true', 'a beard changes the hair');
    await page.getByRole('button', { name: 'Bald', exact: true }).click();
    await page.getByRole('button', { name: 'Shaved', exact: true }).click();
    assert.equal(differing(bald, await picture(page, 'hair-off')), 0, 'who is bald and shaved has hair');
    for (let step = 0; step < 4; step++) await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(await colouring(page), own);
    // A link keeps all of it.
    const kept = await colouring(page);
    assert.deepEqual(kept, { length: 0.55, comb: 0.5, parting: 0.9, curl: 0.8 });
    const { hash } = new URL(page.url());
    const linked = await open(browser, site, { sharp: true, hash });
    assert.deepEqual(await colouring(linked.page), kept);
    assert.equal(differing(await picture(page, 'hair-kept'), await picture(linked.page, 'hair-linked')), 0);
    await linked.context.close();

    // It can be hidden, by a key and a button, and is the face's all the same; who picks a style sees it.
    const hide = page.getByRole('button', { name: 'Hide hair and glasses' });
    await page.locator('.view').focus();
    await page.keyboard.press('h');
    assert.equal(await hide.getAttribute('aria-pressed'), 'true');
    // A view that is chosen is on what is shown: on less than with curls.
    const front = page.getByRole('button', { name: 'Front' });
    await front.click();
    const hidden = await picture(page, 'hair-hidden');
    for (const place of ['scalp', 'beside', 'forehead']) assert.equal(look.around(bald, hidden, place, 10), 0, `hair that is hidden is seen at the ${place}`);
    assert.deepEqual(await colouring(page), kept);
    assert.equal(new URL(page.url()).hash, hash);
    await hide.click();
    assert.ok(look.around(bald, await picture(page, 'hair-shown'), 'scalp', 10) > 300, 'hair that is shown again is not seen');
    await hide.click();
    await page.getByRole('button', { name: 'Bob', exact: true }).click();
    assert.equal(await hide.getAttribute('aria-pressed'), 'false');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();

    // Distances are the head's: with hair and without they look the same.
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.locator('.tab[data-group="head"]').click();
    await moveSlider(page, 'head 1', 0.98);
    await page.getByRole('tab', { name: 'Compare' }).click();
    await page.getByLabel('Distance as colour').check();
    await front.click();
    const heat = await picture(page, 'hair-heat');
    await choose(page);
    await page.getByRole('button', { name: 'The model’s own' }).click();
    assert.equal(differing(heat, await picture(page, 'hair-heat-bald')), 0, 'hair lies over the distances');
    assert.ok(await hide.isHidden(), 'there is nothing to hide');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('whole faces bring theirs, features do not, and what is locked stays as it looks', async () => {
    const { context, page, complaints } = await open(browser, site);
    await page.getByRole('tab', { name: 'Mix' }).click();
    const preset = (name) => page.locator('.tray-face').filter({ hasText: new RegExp(`^${name}$`) });
    await preset('Preset 5').click();
    await page.getByRole('button', { name: 'Take over' }).click();
    const five = await colouring(page);
    assert.ok(Object.keys(five).length > 3);
    await page.getByRole('button', { name: 'Undo', exact: true }).click();
    assert.deepEqual(await colouring(page), {});
    await page.getByLabel('Where').selectOption('Nose');
    await page.getByRole('button', { name: 'Take over' }).click();
    assert.deepEqual(await colouring(page), {}, 'a nose has no colours');
    await page.getByRole('button', { name: 'Undo', exact: true }).click();

    // Half of the way there in an amount, and on the way between two.
    await page.getByLabel('Where').selectOption('Whole face');
    const amount = page.getByRole('slider', { name: 'How much', exact: true });
    await amount.fill('50');
    const half = (await colouring(page)).skin ?? 0.3;
    assert.ok(Math.abs(half - (0.3 + five.skin) / 2) < 0.0051, `half of the way from 0.3 to ${five.skin} is ${half}`);
    await amount.fill('0');
    assert.deepEqual(await colouring(page), {});
    await page.getByLabel('To', { exact: true }).selectOption('Preset 5');
    await page.getByRole('slider', { name: 'Progress', exact: true }).fill('100');
    assert.deepEqual(await colouring(page), {}, 'the way is only shown');
    await page.getByRole('button', { name: 'Keep this face' }).click();
    assert.deepEqual(await colouring(page), five);

    // A random face is someone else, the same for a seed.
    const random = page.getByRole('button', { name: 'Random face', exact: true });
    await random.click();
    const another = await colouring(page);
    assert.notDeepEqual(another, five);
    await page.getByRole('tab', { name: 'Features' }).click();
    await page.locator('summary').filter({ hasText: 'Advanced' }).click();
    const seed = await page.getByLabel('Seed').inputValue();
    await random.click();
    assert.notDeepEqual(await colouring(page), another);
    await page.getByLabel('Seed').fill(seed);
    await page.getByRole('button', { name: 'Use' }).click();
    assert.deepEqual(await colouring(page), another);
    const lock = page.getByRole('button', { name: 'Lock the nose', exact: true });
    await lock.click();
    await random.click();
    assert.deepEqual(await colouring(page), another, 'a locked nose changed its colour');
    assert.ok(await page.getByText('While a feature is locked, all looks stay').isVisible());
    await lock.click();
    await page.getByLabel('With their own looks').uncheck();
    await random.click();
    assert.deepEqual(await colouring(page), another);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('the address, the browser, saved faces and files keep them', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true, drawn: true });
    await moveSlider(page, 'nose 1', 0.9);
    await choose(page);
    await moveSlider(page, 'Skin, fair to deep', 0.9);
    await moveSlider(page, 'Iris, blue to brown', 0.1);
    const kept = { skin: 0.9, iris: 0.1 };
    const shown = await picture(page, 'colours-kept');
    const { hash } = new URL(page.url());
    assert.match(hash, /^#[\w-]+~~[\w-]+$/);

    // A link shows them, in another browser.
    const second = await open(browser, site, { sharp: true, hash });
    assert.deepEqual(await colouring(second.page), kept);
    await choose(second.page);
    await second.page.evaluate(() => document.activeElement?.blur());
    assert.equal(differing(shown, await picture(second.page, 'colours-linked')), 0);
    // Of one that names a colour that there is not, as of a newer page, all else is taken; of one whose looks cannot be read the
    // shape is, which is said.
    const code = await codeOf(second.page);
    await second.page.evaluate((to) => (location.hash = to), `#${code}~~_2Q`);
    await second.page.waitForFunction(() => Object.keys(window.designer.colouring).length === 0);
    assert.equal(await codeOf(second.page), code);
    await second.page.evaluate((to) => (location.hash = to), `#${code}~~AP8`);
    await second.page.waitForFunction(() => /looks could not be read/.test(document.querySelector('.toast')?.textContent ?? ''));
    assert.equal(await codeOf(second.page), code);
    await second.context.close();

    // Saved, with a picture of its own; another one in the model's colours opens in those.
    await page.getByRole('tab', { name: 'Faces' }).click();
    const save = async (name) => {
      await page.getByLabel('Save this face as').fill(name);
      await page.keyboard.press('Enter');
    };
    await save('deep');
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Download deep' }).click();
    const file = JSON.parse(readFileSync(await (await download).path(), 'utf8'));
    assert.deepEqual(file.colouring, kept);
    await choose(page);
    await page.getByRole('button', { name: 'The model’s own' }).click();
    await page.getByRole('tab', { name: 'Faces' }).click();
    await save('plain');
    await page.waitForFunction(() => [...document.querySelectorAll('.saved img')].every((image) => image.src && image.naturalWidth > 0));
    const brightness = await page.locator('.saved img').evaluateAll((images) =>
      images.map((image) => {
        const sheet = document.createElement('canvas');
        sheet.width = sheet.height = 1;
        const draw = sheet.getContext('2d');
        draw.drawImage(image, image.naturalWidth * 0.4, image.naturalHeight * 0.15, image.naturalWidth * 0.2, image.naturalHeight * 0.12, 0, 0, 1, 1);
        return draw.getImageData(0, 0, 1, 1).data[1];
      }),
    );
    assert.ok(brightness[0] > brightness[1] + 40, `the portraits’ foreheads: ${brightness}`);
    await pictureOfPage(page, 'colours-saved');
    await page.getByRole('button', { name: 'Open deep' }).click();
    assert.deepEqual(await colouring(page), kept);
    await page.getByRole('button', { name: 'Open plain' }).click();
    assert.deepEqual(await colouring(page), {});

    // A file brings them; one from before they were kept leaves what is there.
    const bring = (/** @type {object} */ content) =>
      page.locator('input[type=file][accept*=json]').setInputFiles({ name: 'face.json', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify(content)) });
    await bring({ ...file, name: 'from a file', colouring: { skin: 0.7, iris: 7, tail: 1, hair: 'no' } });
    await page.getByRole('button', { name: 'Open from a file' }).waitFor();
    assert.deepEqual(await colouring(page), { skin: 0.7, iris: 1 }, 'numbers are brought within their limits, and all else is left out');
    const { colouring: _, ...older } = file;
    await bring({ ...older, name: 'older' });
    await page.getByRole('button', { name: 'Open older' }).waitFor();
    assert.deepEqual(await colouring(page), { skin: 0.7, iris: 1 });
    await settled(page);
    await page.close();

    // The next visit begins with them.
    const again = await context.newPage();
    await again.goto(site.url);
    await again.waitForFunction(() => document.documentElement.dataset.ready === 'true');
    assert.deepEqual(await again.evaluate(() => window.designer.colouring), { skin: 0.7, iris: 1 });
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('a picture of a skin is worn where its layout has it, until it is taken off', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    await choose(page);
    const look = await looking(page);
    const before = await picture(page, 'own-skin-before');
    /** Green, with a blue spot where the forehead is. @param {number} width @param {number} height */
    const drawn = (width, height) =>
      page.evaluate(
        async ([w, h]) => {
          const { model } = window.designer;
          const { stencil } = model.landmarks.find(({ name }) => name === 'metopion');
          const [vertex] = stencil.reduce((best, entry) => (entry[1] > best[1] ? entry : best));
          const canvas = new OffscreenCanvas(w, h);
          const context = canvas.getContext('2d');
          context.fillStyle = 'rgb(60, 170, 60)';
          context.fillRect(0, 0, w, h);
          context.fillStyle = 'rgb(50, 60, 200)';
          context.arc(w * model.uvs[2 * vertex], h * (1 - model.uvs[2 * vertex + 1]), 0.02 * w, 0, 7);
          context.fill();
          return [...new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer())];
        },
        [width, height],
      );
    const picker = page.getByLabel('Wear a picture…').and(page.locator('input'));
    const give = (/** @type {string} */ name, /** @type {number[]} */ bytes) => picker.setInputFiles({ name, mimeType: 'image/png', buffer: Buffer.from(bytes) });
    const said = () => page.locator('.toast').textContent();
    await give('skin.png', await drawn(256, 256));
    const off = page.getByRole('button', { name: 'Take it off' });
    await off.waitFor();
    assert.match((await said()) ?? '', /wears “skin\.png”/);
    const worn = await picture(page, 'own-skin-worn');
    const [cheek, forehead] = ['cheek', 'forehead'].map((name) => look.colour(worn, name));
    assert.ok(cheek[1] > 1.5 * cheek[0] && cheek[1] > 1.5 * cheek[2], `the cheek is ${cheek}`);
    assert.ok(forehead[2] > 1.5 * forehead[0] && forehead[2] > 1.5 * forehead[1], `the forehead is ${forehead}`);
    // It is nobody's face: another has it too, and what is no skin leaves it on.
    await page.getByRole('button', { name: 'Random face' }).click();
    const other = await picture(page, 'own-skin-other');
    assert.ok(look.colour(other, 'cheek')[1] > 1.4 * look.colour(other, 'cheek')[0]);
    for (const [name, bytes, sentence] of /** @type {const} */ ([
      ['portrait.png', await drawn(256, 200), /“portrait\.png” is not square/],
      ['tiny.png', await drawn(16, 16), /“tiny\.png” is too small/],
      ['broken.png', [137, 80, 78, 71], /“broken\.png” is no picture/],
    ])) {
      await give(name, [...bytes]);
      await page.waitForFunction((words) => new RegExp(words).test(document.querySelector('.toast')?.textContent ?? ''), sentence.source);
    }
    await page.getByRole('button', { name: 'Undo' }).click();
    await off.click();
    assert.ok((await picture(page, 'own-skin-off')).rgb.equals(before.rgb), 'the head is not what it was');
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('lines and cropped hair are painted beside the page before anybody wants them, and longer hair grows there; where they cannot be, all the same', async () => {
    const shown = [];
    for (const blocked of [false, true]) {
      /** @type {Promise<unknown> | undefined} */
      let painted;
      /** @type {Promise<unknown> | undefined} */
      let grown;
      const { context, page, complaints } = await open(browser, site, {
        sharp: true,
        prepare: async (page) => {
          if (blocked) return void (await page.addInitScript(() => delete window.Worker));
          painted = page.waitForEvent('worker', (worker) => /finework/.test(worker.url())).then((worker) => worker.waitForEvent('close'));
          grown = page.waitForEvent('worker', (worker) => /hair/.test(worker.url()));
        },
      });
      await painted;
      await choose(page);
      for (const [name, value] of /** @type {const} */ ([
        ['Lines, none to deep', 1],
        ['Stubble, none to dense', 0.8],
        ['Length, cropped to below the chin', 0.5],
        ['Beard, short to long', 0.4],
      ])) {
        await moveSlider(page, name, value);
        shown.push(await picture(page, `colours-${name.split(',')[0]}-${blocked ? 'at-once' : 'beside'}`));
      }
      await grown;
      assert.deepEqual(complaints, []);
      await context.close();
    }
    const half = shown.length / 2;
    for (let i = 0; i < half; i++) {
      assert.equal(differing(shown[i], shown[half + i]), 0, `picture ${i}`);
      if (i > 0) assert.ok(differing(shown[i], shown[i - 1]) > 100, `picture ${i} is that before`);
    }
  });

  test('who sits for a portrait leaves no hair on the stage, however long its own takes to grow', async () => {
    const { context, page, complaints } = await open(browser, site, { sharp: true });
    await choose(page);
    const long = 'Length, cropped to below the chin';
    await moveSlider(page, long, 0.5);
    const before = await picture(page, 'sitters-before');
    await page.evaluate(() => {
      const { prototype } = Worker;
      const { postMessage } = prototype;
      /** @type {(() => void)[]} */
      const held = [];
      prototype.postMessage = function (message, ...rest) {
        if (message.style) held.push(() => postMessage.call(this, message, ...rest));
        else postMessage.call(this, message, ...rest);
      };
      window.release = () => {
        prototype.postMessage = postMessage;
        for (const send of held) send();
      };
    });
    await moveSlider(page, long, 0.9);
    await page.getByRole('tab', { name: 'Mix' }).click();
    await page.waitForFunction(() => document.querySelectorAll('.tray img[src]').length > 5 && !document.querySelector('.tray img:not([src])'));
    // Only what is the stage's own is not unfinished.
    await page.waitForFunction(() => window.designer.isFine, null, { timeout: 15_000 });
    const after = await picture(page, 'sitters-after');
    await page.evaluate(() => window.release());
    await page.waitForTimeout(1000);
    assert.equal(differing(after, await picture(page, 'sitters-grown')), 0, 'the hair on the stage is another’s');
    assert.ok(differing(before, after) > 1000);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  test('hair follows a slider while it is drawn, and whoever takes the face along takes what was asked for', async () => {
    const { context, page, complaints } = await open(browser, site);
    await choose(page);
    const length = page.getByRole('slider', { name: 'Length, cropped to below the chin', exact: true });
    const box = await page.locator('canvas.view').boundingBox();
    assert.ok(box);
    // The head, and nothing that lies over it.
    const clip = { x: box.x + 0.3 * box.width, y: box.y + 0.25 * box.height, width: 0.4 * box.width, height: 0.5 * box.height };
    const shot = async () => (await page.screenshot({ clip })).toString('base64');
    await moveSlider(page, 'Length, cropped to below the chin', 0.3);
    await settled(page);
    assert.equal(await shot(), await shot(), 'a page at rest');
    // Drawn at every frame: what is asked for last is never there yet.
    const drawn = length.evaluate(async (input) => {
      for (let k = 0; !document.body.dataset.enough; k++) {
        input.value = String(0.3 + 0.5 * ((k / 97) % 1));
        input.dispatchEvent(new Event('input', { bubbles: true }));
        await new Promise((next) => requestAnimationFrame(next));
      }
    });
    // However long a picture takes where others are at work, too.
    const seen = new Set();
    for (let k = 0; k < 20 && seen.size < 3; k++) seen.add(await shot());
    await page.evaluate(() => (document.body.dataset.enough = 'yes'));
    await drawn;
    assert.equal(seen.size, 3, 'different pictures among 20');

    // A picture is asked for in the moment in which a style is.
    const png = async (/** @type {number | null} */ asked) => {
      const [download] = await Promise.all([
        page.waitForEvent('download'),
        length.evaluate((input, asked) => {
          if (asked !== null) {
            input.value = String(asked);
            for (const type of ['input', 'change']) input.dispatchEvent(new Event(type, { bubbles: true }));
          }
          const form = document.querySelector('form.picture');
          const [width, height] = form.querySelectorAll('input[type=number]');
          width.value = '160';
          height.value = '200';
          form.requestSubmit();
        }, asked),
      ]);
      return readFileSync(await download.path());
    };
    const [short, long] = [await png(0.2), await png(0.8)];
    await settled(page);
    assert.ok(long.equals(await png(null)), 'the picture shows what was asked for');
    assert.ok(!long.equals(short));
    assert.deepEqual(complaints, []);
    await context.close();
  });
});
