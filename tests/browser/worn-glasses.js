// How well glasses are told from photos: random heads that the page draws, some of them with random glasses on, are opened as photos in the page.
//
//     node tests/browser/worn-glasses.js COUNT SEED
//
// Heads are in random colours and hair, turned by up to 30 degrees, and nod by up to 12. Half of them wear none.

import { chance } from '../../www/src/chance.js';
import { styleOf } from '../../www/src/glasses/style.js';
import { readColouring, valueIn } from '../../www/src/head/colouring.js';
import { encodeColouring } from '../../www/src/keep/addresscode.js';
import { launch, open, serve, turnHead } from './site.js';

const [count, seed] = process.argv.slice(2).map(Number);
if (!(count > 0) || !Number.isInteger(seed)) {
  console.error('usage: node tests/browser/worn-glasses.js COUNT SEED');
  process.exit(2);
}

/** @param {() => number} random @returns {import('../../www/src/head/colouring.js').Colouring} */
function glasses(random) {
  const lenses = { lensForm: random(), lensSize: 0.1 + 0.8 * random(), lensHeight: 0.15 + 0.7 * random(), lensSweep: random() < 0.3 ? random() : 0.4 + 0.2 * random() };
  const of = random();
  const wire = { rim: 0.12 + 0.2 * random(), frameColour: random() < 0.3 ? 0.66 : 0.28 * random() };
  const made = of < 0.15 ? { rim: 0, frameColour: 0.14 } : of < 0.5 ? wire : { rim: 0.42 + 0.4 * random(), frameColour: 0.36 + 0.64 * random() };
  return { glasses: 1, ...lenses, ...made, halfRim: of > 0.15 && random() < 0.15 ? 1 : 0, tint: random() < 0.2 ? 0.3 + 0.6 * random() : 0 };
}
/** Whether a whole rim is around the lenses, one above, or none. @param {import('../../www/src/head/colouring.js').Colouring} looks */
const rimOf = (looks) => (!looks.glasses ? 'none' : styleOf(looks).isRimless ? 'rimless' : valueIn(looks, 'halfRim') > 0.5 ? 'half' : 'whole');

const site = await serve();
const browser = await launch();
const { page } = await open(browser, site, { sharp: true, drawn: true, viewport: { width: 1000, height: 655 }, colorScheme: 'light' });
await page.locator('.invitation').getByRole('button', { name: 'Close' }).click();
await page.evaluate(() => {
  for (const over of document.querySelectorAll('.hint, .toast, .views, .explain-open')) over.style.visibility = 'hidden';
});

const heads = [];
let pose = [0, 0];
for (let i = 0; i < count; i++) {
  const random = chance(1000 * seed + i);
  const between = (/** @type {number} */ low, /** @type {number} */ high) => low + (high - low) * random();
  const looks = readColouring({
    skin: between(0.03, 0.95), hair: between(0.1, 1), iris: random(), lips: between(0.2, 0.7), blood: between(0.3, 0.7), brows: between(0.3, 0.8),
    crop: random() < 0.3 ? random() : 0, length: random() < 0.75 ? between(0.12, 0.9) : 0, comb: random(), parting: random(), curl: random() ** 2,
    beard: random() < 0.25 ? random() : 0, lines: random() < 0.4 ? random() : 0, browBreadth: between(0.2, 0.9), browRaise: between(0.2, 0.8),
    ...(i % 2 && glasses(random)),
  });
  await page.evaluate(
    async ([seed, colours]) => {
      const one = window.designer.model.face();
      one.randomize({ seed, spread: 1 });
      const { code } = one;
      one.free();
      location.hash = `${code}~~${colours}`;
      const started = performance.now();
      while (window.designer.face.code !== code) {
        if (performance.now() - started > 20_000) throw new Error('the face did not come');
        await new Promise((done) => setTimeout(done, 20));
      }
    },
    [100_000 * seed + i, encodeColouring(looks)],
  );
  const turn = [between(-30, 30), between(-12, 12)];
  await turnHead(page, pose, turn);
  pose = turn;
  heads.push({ looks, turn, picture: await page.locator('canvas').first().screenshot() });
  process.stderr.write(`\r${i + 1} of ${count} are drawn `);
}
await page.context().close();

const { page: other } = await open(browser, site);
await other.getByRole('tab', { name: 'Photo' }).click();
/** @type {Record<string, Record<string, number>>} */
const table = {};
/** @type {Record<string, number[]>} */
const off = { width: [], height: [], form: [], sweep: [], rim: [], frameColour: [], tint: [] };
let seen = 0;
for (const [i, { looks, turn, picture }] of heads.entries()) {
  const before = await other.evaluate(() => window.designer.photo?.fit?.code ?? null);
  await other.locator('input[type=file][accept="image/*"]').setInputFiles({ name: `${i}.png`, mimeType: 'image/png', buffer: picture });
  await other.waitForFunction(
    (before) => {
      const { photo } = window.designer;
      return photo?.mode === 'ready' ? photo.fit.code !== before : photo && photo.mode !== 'busy' && photo.mode !== 'empty';
    },
    before,
    { timeout: 120_000 },
  );
  process.stderr.write(`\r${i + 1} of ${count} are looked at `);
  if ((await other.evaluate(() => window.designer.photo.mode)) !== 'ready') continue;
  seen++;
  const told = await other.evaluate(() => window.designer.colouring);
  const [own, found] = [rimOf(looks), rimOf(told)];
  table[own] ??= { none: 0, rimless: 0, half: 0, whole: 0 };
  table[own][found]++;
  if (own !== 'none' && (own !== found || process.env.VERBOSE)) console.log(`\n${i}, turned by ${turn.map(Math.round)}: ${own} is told as ${found}`, JSON.stringify(looks), JSON.stringify(told));
  if (own === 'none' && found !== 'none') console.log(`\n${i}, turned by ${turn.map(Math.round)}: none is told as ${found}`, JSON.stringify(looks), JSON.stringify(told));
  if (own !== 'whole' || found !== 'whole') continue;
  const [a, b] = [styleOf(told), styleOf(looks)];
  for (const name of /** @type {const} */ (['width', 'height', 'form', 'sweep', 'rim'])) off[name].push(a[name] - b[name]);
  for (const name of ['frameColour', 'tint']) off[name].push(valueIn(told, name) - valueIn(looks, name));
}
process.stderr.write('\n');
console.log(`of ${count} heads the page found ${seen} faces. As what rims were told, in columns:`);
console.table(table);
const rms = (/** @type {number[]} */ values) => Math.sqrt(values.reduce((sum, value) => sum + value ** 2, 0) / values.length);
console.log('whole rims are off, root mean square, mm and parts of sliders:', Object.entries(off).map(([name, all]) => `${name} ${rms(all).toFixed(2)}`).join(', '));
await browser.close();
await site.close();
