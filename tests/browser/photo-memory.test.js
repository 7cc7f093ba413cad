// What the processes of the browser take while a photo of 50 megapixels is opened, edited and saved.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { headerOf } from '../../www/src/photo/exif.js';
import { launch, moveSlider, open, serve } from './site.js';

/** 50 megapixels, as cameras have them. */
const [WIDTH, HEIGHT] = [8660, 5774];
const MEGABYTE = 1 << 20;
/**
 * Of the page's process, bytes: the pixels twice, decoded and on a canvas, or once and in the encoder of JPEG, are
 * 400 MB, the page with a fitted face is 500. With all processes of the browser it is 1.1 GB at rest and up to
 * 1.6 GB while it is saved, of which 0.7 are the browser with a page that has no photo, a graphics card in
 * software among them.
 */
const MOST = 1000 * MEGABYTE;

/** The processes that come of this one. */
function descendants() {
  /** @type {Map<number, number[]>} */
  const children = new Map();
  for (const name of readdirSync('/proc').filter((entry) => /^\d+$/.test(entry))) {
    try {
      // The second field is a name in brackets, which may have brackets and spaces in it.
      const parent = Number(readFileSync(`/proc/${name}/stat`, 'latin1').split(') ').at(-1)?.split(' ')[1]);
      children.set(parent, [...(children.get(parent) ?? []), Number(name)]);
    } catch {
      // It has ended.
    }
  }
  const found = [...(children.get(process.pid) ?? [])];
  for (const pid of found) found.push(...(children.get(pid) ?? []));
  return found;
}

/** What a process has in memory, bytes: what several share counts once (proportional set size). @param {number} pid */
function taken(pid) {
  try {
    return 1024 * Number(/^Pss:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/smaps_rollup`, 'latin1'))?.[1] ?? 0);
  } catch {
    return 0;
  }
}

/** The same with all that it shares: more, and known at once, where a gigabyte takes a processor a while to count. @param {number} pid */
function resident(pid) {
  try {
    return 1024 * Number(/^VmRSS:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/status`, 'latin1'))?.[1] ?? 0);
  } catch {
    return 0;
  }
}

/** Who has not grown by more than this since it was counted is not counted again, bytes. */
const GROWN = 4 * MEGABYTE;

/** Watches until it is ended: the most of one process, and of all, with what each had then. */
function watch() {
  let most = 0;
  let largest = 0;
  /** @type {string[]} */
  let then = [];
  /** What each had when it was counted. @type {Map<number, { resident: number, taken: number }>} */
  let counted = new Map();
  const timer = setInterval(() => {
    const pids = descendants();
    let grew = false;
    for (const pid of pids) {
      const now = resident(pid);
      if (now <= (counted.get(pid)?.resident ?? 0) + GROWN) continue;
      counted.set(pid, { resident: now, taken: taken(pid) });
      grew = true;
    }
    if (!grew) return;
    const each = pids.map((pid) => counted.get(pid)?.taken ?? 0);
    const sum = each.reduce((a, b) => a + b, 0);
    largest = Math.max(largest, ...each);
    if (sum <= most) return;
    most = sum;
    then = each.flatMap((bytes, i) => {
      if (bytes < 20 * MEGABYTE) return [];
      const kind = /--type=([\w-]+)/.exec(readFileSync(`/proc/${pids[i]}/cmdline`, 'latin1'))?.[1] ?? 'browser';
      return [`${kind} ${Math.round(bytes / MEGABYTE)}`];
    });
  }, 60);
  return {
    /** Since the last time. */
    get most() {
      const now = { largest, text: `${Math.round(largest / MEGABYTE)} MB, of all at most ${Math.round(most / MEGABYTE)} MB (${then.join(', ')})` };
      most = largest = 0;
      counted = new Map();
      return now;
    },
    end: () => clearInterval(timer),
  };
}

/** A portrait in the middle of so many pixels, as a JPEG. */
async function largePhoto() {
  const browser = await launch();
  const page = await browser.newPage();
  const portrait = (await readFile(new URL('../../www/public/astronaut.jpg', import.meta.url))).toString('base64');
  const code = await page.evaluate(
    async ([bytes, width, height]) => {
      const image = await createImageBitmap(new Blob([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))]));
      const canvas = new OffscreenCanvas(width, height);
      const context = canvas.getContext('2d');
      context.drawImage(image, (width - height) / 2, 0, height, height);
      const blob = await canvas.convertToBlob({ type: 'image/jpeg', quality: 0.9 });
      return new Promise((done) => {
        const reader = new FileReader();
        reader.onload = () => done(reader.result.split(',')[1]);
        reader.readAsDataURL(blob);
      });
    },
    /** @type {const} */ ([portrait, WIDTH, HEIGHT]),
  );
  await browser.close();
  return Buffer.from(code, 'base64');
}

describe('a photo of 50 megapixels', () => {
  test('is saved at its full size, and its page stays within a gigabyte', { skip: process.platform !== 'linux' && 'only Linux tells the memory of processes' }, async () => {
    const photo = await largePhoto();
    const [site, browser] = await Promise.all([serve(), launch()]);
    const memory = watch();
    try {
      const { page } = await open(browser, site, { viewport: { width: 1280, height: 800 } });
      await page.getByRole('tab', { name: 'Photo' }).click();
      await page.getByText('nothing is uploaded').waitFor();
      console.log(`the page: ${memory.most.text}`);
      await page.locator('input[type=file][accept="image/*"]').setInputFiles({ name: 'large.jpg', mimeType: 'image/jpeg', buffer: photo });
      await page.waitForFunction(() => window.designer.photo?.mode === 'ready', null, { timeout: 120_000 });
      const size = await page.evaluate(() => [window.designer.photo.width, window.designer.photo.height]);
      assert.deepEqual(size, [WIDTH, HEIGHT]);
      const opened = memory.most;
      console.log(`opened, found and fitted: ${opened.text}`);
      await page.getByRole('tab', { name: 'Lengths' }).click();
      await moveSlider(page, 'nose width', 0.99);
      await page.waitForFunction(() => window.designer.photo.field !== null);
      await page.getByRole('tab', { name: 'Photo' }).click();
      assert.ok(opened.largest < MOST, opened.text);
      for (const kind of ['PNG', 'JPEG']) {
        const download = page.waitForEvent('download', { timeout: 120_000 });
        await page.getByRole('button', { name: `Save as ${kind}` }).click();
        const file = await readFile(await (await download).path());
        const saved = memory.most;
        console.log(`saved as ${kind}, ${Math.round(file.length / MEGABYTE)} MB: ${saved.text}`);
        const { buffer, byteOffset, byteLength } = file.subarray(0, 1 << 20);
        assert.deepEqual(headerOf(buffer.slice(byteOffset, byteOffset + byteLength)).size, [WIDTH, HEIGHT]);
        assert.ok(saved.largest < MOST, saved.text);
      }
    } finally {
      memory.end();
      await browser.close();
      await site.close();
    }
  });
});
