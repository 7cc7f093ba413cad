// Makes www/docs/photo.png: the example's portrait with the edits of the paper's Figs. 7 to 10.
//
//     node tests/browser/photo-pictures.js        (after ./build.sh build)

import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';

import { load } from '../../pkg/index.js';
import { launch, serve } from './site.js';

const require = createRequire(new URL('../../www/package.json', import.meta.url));
/** @type {typeof import('pngjs')} */
const { PNG } = require('pngjs');
const file = (/** @type {string} */ path) => readFile(new URL(`../../www/${path}`, import.meta.url));

/** Around the face, as parts of its height: left, right, above, below. */
const AROUND = [0.06, 0.06, 0.36, 0.1];
/** How much larger than the photo's pixels they are shown. */
const LARGER = 1.5;
const PAIRS = ['mouth width', 'mouth protrusion', 'nose length', 'nose width', 'eyes size', 'eyes length', 'forehead convexity', 'forehead size'];
/** Each row: a caption a picture, and by how many standard deviations which controls are moved. @type {[string, Record<string, number>][][]} */
const ROWS = [
  [['as it was', {}], ...PAIRS.map((name) => /** @type {[string, {}]} */ ([`${name} +2σ`, { [name]: 2 }]))],
  [['as it was', {}], ...PAIRS.map((name) => /** @type {[string, {}]} */ ([`${name} −2σ`, { [name]: -2 }]))],
  [
    ...[0, 2, 4, 6].map((n) => /** @type {[string, {}]} */ ([`nose length +${n}σ`, { 'nose length': n }])),
    ['nose height +2σ', { 'nose height': 2 }],
    ['right eye up 2σ', { 'right eye vertical position': 2 }],
    ['eyes apart, higher nose, narrower mouth, 2σ each', { 'inner eye distance': 2, 'nose height': 2, 'mouth width': -2 }],
    ['the same, 3σ each', { 'inner eye distance': 3, 'nose height': 3, 'mouth width': -3 }],
    ['another person, half way', {}],
  ],
];

const site = await serve();
const browser = await launch();
try {
  const page = await browser.newPage();
  await page.goto(site.url);
  await page.waitForSelector('html[data-ready]', { timeout: 120_000 });
  await page.getByRole('tab', { name: 'Photo' }).click();
  await page.getByRole('button', { name: 'An example' }).click();
  await page.waitForFunction(() => window.designer.photo?.mode === 'ready', null, { timeout: 120_000 });
  const { fit, points, width, height, rgba, outline } = await page.evaluate(async () => {
    const { fit, points, width, height, person } = window.designer.photo;
    const picture = await createImageBitmap(await (await fetch('astronaut.jpg')).blob());
    const context = new OffscreenCanvas(width, height).getContext('2d');
    const drawn = () => context.getImageData(0, 0, width, height).data;
    context.drawImage(picture, 0, 0);
    const rgba = [...drawn()];
    // How much of each pixel is the person's, as the page tells it.
    context.fillStyle = 'white';
    context.fillRect(0, 0, width, height);
    context.drawImage(person.mask, person.x, person.y, person.side, person.side);
    const outline = [...drawn()].filter((_, i) => i % 4 === 0);
    return { fit, points: [...points], width, height, rgba, outline };
  });

  const model = await load(await file('public/model.phiz'));
  await model.loadExpressions(await file('public/expressions.phiz'));
  const photo = Uint8ClampedArray.from(rgba);
  const withPerson = photo.map((value, i) => (i % 4 === 3 ? outline[i >> 2] : value));
  const edit = await model.editPhoto({ width, height, fit, rgba: withPerson });
  const xs = points.filter((_, i) => i % 2 === 0);
  const ys = points.filter((_, i) => i % 2 === 1);
  const tall = Math.max(...ys) - Math.min(...ys);
  const left = Math.round(Math.min(...xs) - AROUND[0] * tall);
  const top = Math.max(0, Math.round(Math.min(...ys) - AROUND[2] * tall));
  const across = Math.round(Math.max(...xs) + AROUND[1] * tall) - left;
  const down = Math.round(Math.max(...ys) + AROUND[3] * tall) - top;

  /** @param {Record<string, number>} moves @param {string} caption */
  function picture(moves, caption) {
    const face = model.fromCode(fit.code);
    face.expression = fit.expression;
    const { coefficients } = face;
    for (const [name, sigmas] of Object.entries(moves)) {
      coefficients[model.controls.findIndex((control) => control.name === name)] += sigmas;
    }
    face.coefficients = coefficients;
    if (caption.startsWith('another')) {
      const other = model.face();
      other.randomize({ seed: 12 });
      face.blend(other, 0.5);
      other.free();
    }
    const whole = edit.render(face, photo);
    face.free();
    const png = new PNG({ width: across, height: down });
    for (let y = 0; y < down; y++) {
      const row = 4 * ((top + y) * width + left);
      png.data.set(whole.subarray(row, row + 4 * across), 4 * y * across);
    }
    return `data:image/png;base64,${PNG.sync.write(png).toString('base64')}`;
  }
  const cells = ROWS.map((row) => row.map(([caption, moves]) => `<figure><img src="${picture(moves, caption)}"><figcaption>${caption}</figcaption></figure>`).join(''));
  const sheet = await browser.newPage({ viewport: { width: Math.round(9 * (LARGER * across + 8) + 8), height: 800 } });
  await sheet.setContent(`<style>
    body { margin: 0; padding: 8px; font: 12px system-ui, sans-serif; display: inline-block }
    div { display: flex; gap: 8px; margin-bottom: 8px }
    figure { margin: 0; width: ${LARGER * across}px } img { display: block; width: 100% } figcaption { padding-top: 3px; min-height: 2.4em }
  </style>${cells.map((row) => `<div>${row}</div>`).join('')}`);
  const path = fileURLToPath(new URL('../../www/docs/photo.png', import.meta.url));
  await sheet.locator('body').screenshot({ path });
  console.log(path);
} finally {
  await browser.close();
  await site.close();
}
