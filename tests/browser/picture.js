// Takes the README's picture of the built page: node tests/browser/picture.js

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
await page.screenshot({ path: fileURLToPath(new URL('../../www/docs/page.png', import.meta.url)) });
await browser.close();
await site.close();
