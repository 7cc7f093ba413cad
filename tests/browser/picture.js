// Takes the README's pictures of the built page: node tests/browser/picture.js

import { writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';
import { decodePng, launch, moveSlider, open, picture, serve, settled } from './site.js';

const { PNG } = createRequire(new URL('../../www/package.json', import.meta.url))('pngjs');

/**
 * A picture at half the size: where a processor draws, edges are smooth in that alone.
 * @param {{ width: number, height: number, rgb: Buffer }} picture
 */
function halved({ width, height, rgb }) {
  const half = new PNG({ width: width >> 1, height: height >> 1 });
  for (let y = 0; y < half.height; y++) {
    for (let x = 0; x < half.width; x++) {
      const [o, p] = [3 * (2 * y * width + 2 * x), 4 * (y * half.width + x)];
      for (let k = 0; k < 3; k++) half.data[p + k] = (rgb[o + k] + rgb[o + 3 + k] + rgb[o + 3 * width + k] + rgb[o + 3 * width + 3 + k]) / 4;
      half.data[p + 3] = 255;
    }
  }
  return half;
}

/**
 * As a graphics card would draw it, however long a processor takes: all of the hair, which is finer, and smoother edges.
 * @param {import('playwright-core').Page} page
 */
const asByCard = (page) =>
  page.addInitScript(() => {
    const { getParameter } = WebGL2RenderingContext.prototype;
    const renderer = 0x9246; // UNMASKED_RENDERER_WEBGL
    WebGL2RenderingContext.prototype.getParameter = function (name) {
      return name === renderer ? 'a graphics card' : getParameter.call(this, name);
    };
  });

const site = await serve();
const browser = await launch();
/** A picture is drawn for minutes, and what is pressed meanwhile waits for it. */
const PATIENCE = 600_000;
const { page } = await open(browser, site, {
  prepare: asByCard,
  fine: true,
  sharp: true,
  deviceScaleFactor: 2,
  viewport: { width: 1280, height: 800 },
  colorScheme: 'light',
});
page.setDefaultTimeout(PATIENCE);
await page.locator('.invitation').getByRole('button', { name: 'Close' }).click();
await page.getByRole('tab', { name: 'Looks' }).click();
await moveSlider(page, 'Length, cropped to below the chin', 0.3);
await moveSlider(page, 'Combed back, aside, forward', 0.3);
await moveSlider(page, 'Stubble, none to dense', 0.2);
await page.getByRole('tab', { name: 'Features' }).click();
await page.getByRole('button', { name: 'Three-quarter' }).click();
await moveSlider(page, 'nose 1', 0.86);
await moveSlider(page, 'nose 3', 0.3);
await settled(page);
const place = (/** @type {string} */ name) => fileURLToPath(new URL(`../../www/docs/${name}.png`, import.meta.url));
const shoot = async (/** @type {string} */ name, of = page) => writeFileSync(place(name), PNG.sync.write(halved(decodePng(await of.screenshot()))));
await shoot('page');

// Someone who laughs.
await page.evaluate(() => {
  const { model } = window.designer;
  const other = model.face();
  other.randomize({ seed: 12, spread: 0.8 });
  // In the same colours.
  location.hash = other.code + location.hash.slice(location.hash.indexOf('~'));
  other.free();
});
await page.reload();
await page.waitForFunction(() => document.documentElement.dataset.ready === 'true');
await page.getByRole('tab', { name: 'Expressions' }).click();
await page.getByRole('slider', { name: 'mouthSmile' }).first().waitFor({ timeout: 60_000 });
await page.getByRole('button', { name: 'Laugh', exact: true }).click();
await settled(page);
await shoot('page-expressions');

// What an operation on nose and chin would do, seen from the side.
await page.getByRole('button', { name: 'Neutral', exact: true }).click();
await page.getByRole('tab', { name: 'Compare' }).click();
await page.getByRole('button', { name: 'Use this face as the start' }).click();
await page.getByRole('tab', { name: 'Features' }).click();
for (const [name, value] of /** @type {const} */ ([['nose 1', 0.1], ['chin 1', 0.12]])) {
  await page.locator(`.tab[data-group="${name.slice(0, -2)}"]`).click();
  await moveSlider(page, name, value);
}
await page.getByRole('tab', { name: 'Compare' }).click();
await page.getByLabel('The other’s outline over this face').check();
await page.getByRole('button', { name: 'Profile' }).click();
await settled(page);
await page.locator('.lengths').last().evaluate((table) => table.scrollIntoView({ block: 'end' }));
await shoot('page-compare');
await page.context().close();

// Somebody whom a description tells of: a scar through a brow, a mole under an eye, a birthmark on a cheek.
{
  const { page, context } = await open(browser, site, { prepare: asByCard, fine: true, sharp: true, deviceScaleFactor: 2, viewport: { width: 1280, height: 800 }, colorScheme: 'light' });
  page.setDefaultTimeout(PATIENCE);
  await page.locator('.invitation').getByRole('button', { name: 'Close' }).click();
  await page.evaluate(() => {
    const one = window.designer.model.face();
    one.randomize({ seed: 43, spread: 0.9 });
    location.hash = one.code;
    one.free();
  });
  await page.getByRole('tab', { name: 'Looks' }).click();
  for (const [name, value] of /** @type {const} */ ([['Skin, fair to deep', 0.34], ['Length, cropped to below the chin', 0.2], ['Stubble, none to dense', 0.35], ['Lines, none to deep', 0.35]])) await moveSlider(page, name, value);
  await page.getByRole('button', { name: 'Front', exact: true }).click();
  await settled(page);
  const canvas = await page.locator('canvas').first().boundingBox();
  if (!canvas) throw new Error('no stage');
  await page.mouse.move(canvas.x + canvas.width / 2, canvas.y + 0.55 * canvas.height);
  for (let i = 0; i < 4; i++) await page.mouse.wheel(0, -240);
  await settled(page);
  /** Beside a landmark, px on the screen. @param {string} name @param {number} x @param {number} y */
  const beside = async (name, x, y) => {
    const at = await page.evaluate((name) => window.designer.onScreen(name), name);
    return /** @type {const} */ ([at.x + x, at.y + y]);
  };
  await page.getByRole('button', { name: 'Mole', exact: true }).first().click();
  await page.mouse.click(...(await beside('ibug_41', -4, 34)));
  await page.getByRole('button', { name: 'Birthmark', exact: true }).first().click();
  await page.mouse.click(...(await beside('ibug_46', 34, 92)));
  await page.getByRole('button', { name: 'Scar', exact: true }).first().click();
  await page.mouse.click(...(await beside('ibug_24', 20, -22)));
  await page.mouse.click(...(await beside('ibug_24', 28, 56)));
  // Which is chosen then, and has its pins over it.
  await page.getByRole('group', { name: 'Marks that the face has' }).getByRole('button', { name: 'Scar' }).click();
  await page.mouse.move(canvas.x + 4, canvas.y + canvas.height - 4);
  await settled(page);
  await shoot('page-marks', page);
  await context.close();
}

// Random faces in colours of their own, side by side.
const PEOPLE = [
  { seed: 7, colours: { skin: 0.08, hair: 0.25, red: 0.75, iris: 0.05, blood: 0.4, length: 0.8, parting: 0.6, curl: 0.3 } },
  { seed: 20, colours: { skin: 0.85, hair: 1, iris: 1, crop: 0.9, length: 0.35, curl: 0.95, beard: 0.45, beardLength: 0.12 } },
  { seed: 12, colours: { skin: 0.42, hair: 0.95, iris: 0.95, lips: 0.75, length: 0.95, comb: 0.55, parting: 0.45, curl: 0 } },
  { seed: 43, colours: { skin: 0.25, hair: 0.6, iris: 0.38, brows: 0.7, length: 0.3, comb: 0.15, beard: 0.8, beardLength: 0.35 } },
  { seed: 24, colours: { skin: 0.66, hair: 1, iris: 0.9, lips: 0.5, length: 0.6, comb: 0.75, curl: 0.1 } },
  { seed: 58, colours: { skin: 0.2, hair: 0.7, grey: 0.9, iris: 0.2, lips: 0.25, length: 0.16, lines: 0.85, beard: 0.2 } },
];
const WIDTH = 300;
const HEIGHT = 400;
/** A page whose stage has so much room, without what lies on it. */
async function portraitPage() {
  const { page } = await open(browser, site, { prepare: asByCard, sharp: true, fine: true, deviceScaleFactor: 2, viewport: { width: 900, height: HEIGHT + 55 }, colorScheme: 'light' });
  page.setDefaultTimeout(PATIENCE);
  await page.locator('.invitation').getByRole('button', { name: 'Close' }).click();
  await page.locator('.explain-open').evaluate((button) => (button.style.visibility = 'hidden'));
  return page;
}
/**
 * Puts the middle of a picture on a sheet of three in a row.
 * @param {InstanceType<typeof PNG>} onto @param {number} place
 * @param {InstanceType<typeof PNG>} from
 */
function put(onto, place, { data, width }) {
  const left = Math.floor((width - WIDTH) / 2);
  for (let y = 0; y < HEIGHT; y++) {
    for (let x = 0; x < WIDTH; x++) {
      const o = 4 * ((Math.floor(place / 3) * HEIGHT + y) * onto.width + (place % 3) * WIDTH + x);
      for (let k = 0; k < 3; k++) onto.data[o + k] = data[4 * (y * width + left + x) + k];
      onto.data[o + 3] = 255;
    }
  }
}
const sheet = new PNG({ width: 3 * WIDTH, height: 2 * HEIGHT });
const small = await portraitPage();
/** @param {{ seed: number, colours: Record<string, number> }} person of the sheet */
async function seat({ seed, colours }) {
  await small.evaluate((number) => {
    const { model } = window.designer;
    const other = model.face();
    other.randomize({ seed: number, spread: 0.9 });
    location.hash = other.code;
    other.free();
  }, seed);
  await small.getByRole('tab', { name: 'Looks' }).click();
  for (const [name, value] of Object.entries(colours)) {
    const slider = small.locator(`#colour-${name}`);
    await slider.fill(String(value));
    await slider.dispatchEvent('change');
  }
}
for (const [i, person] of PEOPLE.entries()) {
  await seat(person);
  put(sheet, i, halved(await picture(small, `people-${i}`)));
}
writeFileSync(place('page-colours'), PNG.sync.write(sheet));

// Three of them with glasses.
const WEARERS = /** @type {const} */ ([[5, 'Half-rim', 'Three-quarter'], [2, 'Cat-eye', 'Front'], [1, 'Pilot', 'Three-quarter']]);
const spectacles = new PNG({ width: 3 * WIDTH, height: HEIGHT });
for (const [i, [who, kind, view]] of WEARERS.entries()) {
  await seat(PEOPLE[who]);
  await small.getByRole('group', { name: 'Glasses to start from' }).getByRole('button', { name: kind, exact: true }).click();
  await small.locator('.views').getByRole('button', { name: view, exact: true }).click();
  put(spectacles, i, halved(await picture(small, `glasses-${i}`)));
}
await small.locator('.views').getByRole('button', { name: 'Front', exact: true }).click();
await small.getByRole('group', { name: 'Glasses to start from' }).getByRole('button', { name: 'None', exact: true }).click();
writeFileSync(place('page-glasses'), PNG.sync.write(spectacles));

// One person, and what labels make of them.
const VARIANTS = [{ Age: 0.05 }, { Age: 0.6 }, { Age: 1 }, { Sex: 0.95 }, { 'African shape': 0.9 }, { 'Asian shape': 0.9 }];
const variants = new PNG({ width: 3 * WIDTH, height: 2 * HEIGHT });
await small.evaluate(() => {
  const other = window.designer.model.face();
  other.randomize({ seed: 6, spread: 0.8, attributes: { sex: 0.1, age: 30, african: 0, asian: 0, caucasian: 1 } });
  location.hash = other.code;
  other.free();
});
await small.getByRole('tab', { name: 'Looks' }).click();
for (const [name, value] of Object.entries({ skin: 0.2, hair: 0.55, iris: 0.45, lips: 0.5, length: 0.75, comb: 0.5, parting: 0.35, curl: 0.25 })) {
  const slider = small.locator(`#colour-${name}`);
  await slider.fill(String(value));
  await slider.dispatchEvent('change');
}
await small.getByRole('tab', { name: 'Features' }).click();
await small.getByRole('button', { name: 'Person', exact: true }).click();
// What the pointer is over glows.
await small.mouse.move(2, 2);
const they = await small.evaluate(() => location.hash);
for (const [i, asked] of VARIANTS.entries()) {
  await small.evaluate((hash) => (location.hash = hash), they);
  for (const [name, at] of Object.entries(asked)) await moveSlider(small, name, at);
  put(variants, i, halved(await picture(small, `person-${i}`)));
}
writeFileSync(place('page-person'), PNG.sync.write(variants));

// A photo, and the head that it becomes.
const shown = new PNG({ width: 3 * WIDTH, height: HEIGHT });
const photo = await portraitPage();
await photo.getByRole('tab', { name: 'Photo' }).click();
await photo.getByRole('button', { name: 'An example' }).click();
await photo.waitForFunction(() => window.designer.photo?.mode === 'ready', null, { timeout: 60_000 });
await photo.evaluate(() => {
  for (const over of document.querySelectorAll('.photo-sides, .hint, .toast')) over.style.visibility = 'hidden';
});
const cut = await photo.evaluate(
  async ([width, height]) => {
    const canvas = Object.assign(document.createElement('canvas'), { width, height });
    const whole = await createImageBitmap(await (await fetch('astronaut.jpg')).blob());
    const context = canvas.getContext('2d');
    context.imageSmoothingQuality = 'high';
    context.drawImage(whole, 120, 0, (300 * width) / height, 300, 0, 0, width, height);
    return canvas.toDataURL().split(',')[1];
  },
  [WIDTH, HEIGHT],
);
put(shown, 0, PNG.sync.read(Buffer.from(cut, 'base64')));
await photo.getByLabel('3D head', { exact: true }).evaluate((side) => side.click());
await photo.waitForFunction(() => window.designer.photo.worn);
for (const [i, name] of ['Front', 'Three-quarter'].entries()) {
  await photo.locator('.views button', { hasText: name }).evaluate((button) => {
    button.click();
    button.parentElement.style.visibility = 'hidden';
  });
  await settled(photo);
  put(shown, i + 1, halved(decodePng(await photo.locator('.view').screenshot())));
}
writeFileSync(place('page-photo'), PNG.sync.write(shown));
await browser.close();
await site.close();
