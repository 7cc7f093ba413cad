// Takes the README's picture of the built page: node tests/browser/picture.js

import { fileURLToPath } from 'node:url';
import { launch, open, serve, settled } from './site.js';

const site = await serve();
const browser = await launch();
const { page } = await open(browser, site, {
  viewport: { width: 1280, height: 800 },
  colorScheme: 'light',
});
await page.getByRole('button', { name: 'Three-quarter' }).click();
await settled(page);
await page.screenshot({ path: fileURLToPath(new URL('../../www/docs/page.png', import.meta.url)) });
await browser.close();
await site.close();
