// Takes the README's pictures of the built page: node tests/browser/picture.js

import { fileURLToPath } from 'node:url';
import { launch, moveSlider, open, serve, settled } from './site.js';

const site = await serve();
const browser = await launch();
const { page } = await open(browser, site, {
  viewport: { width: 1280, height: 800 },
  colorScheme: 'light',
});
await page.locator('.invitation').getByRole('button', { name: 'Close' }).click();
await page.getByRole('button', { name: 'Three-quarter' }).click();
await moveSlider(page, 'nose 1', 0.86);
await moveSlider(page, 'nose 3', 0.3);
await settled(page);
const shoot = (/** @type {string} */ name) => page.screenshot({ path: fileURLToPath(new URL(`../../www/docs/${name}.png`, import.meta.url)) });
await shoot('page');

// Someone who laughs.
await page.evaluate(() => {
  const { model } = window.designer;
  const other = model.face();
  other.randomize({ seed: 12, spread: 0.8 });
  location.hash = other.code;
  other.free();
});
await page.reload();
await page.waitForFunction(() => document.documentElement.dataset.ready === 'true');
await page.getByRole('tab', { name: 'Expressions' }).click();
await page.getByRole('slider', { name: 'mouthSmile' }).first().waitFor({ timeout: 60_000 });
for (const [name, weight] of /** @type {const} */ ([
  ['Smile mouthSmile', 0.9],
  ['Open jawOpen', 0.22],
  ['Upper lip up mouthUpperUp', 0.45],
  ['Squint eyeSquint', 0.5],
  ['Cheek raised cheekSquint', 0.6],
])) {
  await moveSlider(page, name, weight);
}
await settled(page);
await shoot('page-expressions');
await browser.close();
await site.close();
