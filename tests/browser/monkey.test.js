// Somebody who presses everything: thousands of random actions, the same for the same seed.
//
//     PHIZ_MONKEY_MINUTES=10 PHIZ_MONKEY_SEED=7 node --test tests/browser/monkey.test.js
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { setTimeout as later } from 'node:timers/promises';
import { open, settled, siteAndBrowser } from './site.js';

const MINUTES = Number(process.env.PHIZ_MONKEY_MINUTES ?? 1);
/** Longer than any file takes to be made on a busy machine, in ms. */
const HUNG = 120_000;
const SEED = Number(process.env.PHIZ_MONKEY_SEED ?? 1);

const { browser, site } = await siteAndBrowser();

/** mulberry32 */
function chance(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** What a browser says when a context is lost on purpose, or is read back. */
const EXPECTED = /Context (Lost|Restored)|CONTEXT_LOST_WEBGL|GPU stall due to ReadPixels/i;

const BROKEN = [
  '',
  '{',
  'null',
  '[]',
  '{"phiz":"face","version":99}',
  '{"phiz":"face","version":1,"model":"another","name":"x","code":"AAAA"}',
  '\u0000\u0001\u0002',
  'x'.repeat(200_000),
];

/** All that the page is, as numbers that a leak would make grow. */
async function weight(session, page) {
  await session.send('HeapProfiler.collectGarbage');
  await session.send('HeapProfiler.collectGarbage');
  const { metrics } = await session.send('Performance.getMetrics');
  const of = (/** @type {string} */ name) => metrics.find((metric) => metric.name === name)?.value ?? 0;
  const wasm = await page.evaluate(() => window.designer.face.positions.buffer.byteLength);
  return { heap: of('JSHeapUsedSize') / 1e6, nodes: of('Nodes'), listeners: of('JSEventListeners'), wasm: wasm / 1e6 };
}

test(`a monkey for ${MINUTES} min, seed ${SEED}`, { timeout: MINUTES * 60_000 + 300_000 }, async () => {
  const random = chance(SEED);
  const below = (/** @type {number} */ n) => Math.floor(random() * n);
  /** @template T @param {readonly T[]} list @returns {T} */
  const one = (list) => list[below(list.length)];
  const { context, page, complaints } = await open(browser, site, {
    viewport: { width: 900, height: 620 },
    // The fewer pixels, the more actions.
    deviceScaleFactor: 0.25,
    drawn: true,
  });
  page.on('dialog', (dialog) => dialog.dismiss());
  const session = await context.newCDPSession(page);
  await session.send('Performance.enable');
  await page.evaluate(() => {
    const canvas = document.querySelector('canvas.view');
    const gl = canvas.getContext('webgl2');
    window.lose = gl.getExtension('WEBGL_lose_context');
    window.isLost = () => gl.isContextLost();
    // A card comes back to a page that was told that it is gone, and once: on a busy machine that takes its time.
    let told = false;
    canvas.addEventListener('webglcontextlost', () => setTimeout(() => (told = true)));
    window.regain = () => {
      if (told && gl.isContextLost()) window.lose.restoreContext();
      told = false;
    };
  });

  /** What was done, for whoever has to do it again. @type {string[]} */
  const done = [];

  /** Something that can be pressed, where it is, and what it is. */
  const target = () =>
    page.evaluate((pick) => {
      const scope = document.querySelector('dialog[open]') ?? document;
      const all = [...scope.querySelectorAll('button, input, select, summary, [role=slider]')].filter((node) => {
        if (node.disabled || node.closest('[hidden]') || !node.checkVisibility({ visibilityProperty: true })) return false;
        // Not away from here: another version of the page.
        return !node.closest('.update, .failure');
      });
      const node = all[Math.floor(pick * all.length)];
      if (!node) return null;
      node.scrollIntoView({ block: 'nearest', inline: 'nearest' });
      const box = node.getBoundingClientRect();
      return {
        name: (node.getAttribute('aria-label') || node.id || node.textContent || node.className).trim().slice(0, 40),
        kind: node.matches('select') ? 'select' : node.matches('input') ? node.type : node.getAttribute('role') === 'slider' ? 'slider' : 'button',
        options: node.matches('select') ? [...node.options].map((option) => option.value) : [],
        x: box.x,
        y: box.y,
        width: box.width,
        height: box.height,
      };
    }, random());

  async function press() {
    const node = await target();
    if (!node) return void (await page.keyboard.press('Escape'));
    done.push(`${node.kind} ${node.name}`);
    const [x, y] = [node.x + node.width * (0.2 + 0.6 * random()), node.y + node.height / 2];
    switch (node.kind) {
      case 'range':
      case 'slider':
        if (random() < 0.6) {
          await page.mouse.move(x, y);
          await page.mouse.down();
          await page.mouse.move(node.x + node.width * random(), y + 30 * (random() - 0.5), { steps: 1 + below(2) });
          await page.mouse.up();
        } else {
          await page.mouse.click(x, y);
          for (let i = below(4); i >= 0; i--) await page.keyboard.press(one(['ArrowLeft', 'ArrowRight', 'PageUp', 'PageDown', 'Home', 'End', 'Delete', 'Enter', '7']));
          await page.keyboard.press('Enter');
        }
        break;
      case 'number':
      case 'text':
        await page.mouse.click(x, y);
        await page.keyboard.type(one(['0', '-3', '52.5', '1e9', '99999999999', 'Ada', '  ', '<b>x</b>', '🙂']));
        await page.keyboard.press(one(['Enter', 'Escape', 'Tab']));
        break;
      case 'select':
        await page.mouse.click(x, y);
        await page.keyboard.press(one(['ArrowDown', 'ArrowUp', 'End']));
        await page.keyboard.press('Enter');
        break;
      default:
        await page.mouse.click(x, y);
    }
  }

  /** @type {Record<string, [number, () => Promise<unknown>]>} how often, and what */
  const actions = {
    press: [60, press],
    tab: [10, () => page.getByRole('tab').nth(below(7)).click({ timeout: 1000 }).catch(() => page.keyboard.press('Escape'))],
    undo: [10, () => page.keyboard.press('Control+z')],
    redo: [6, () => page.keyboard.press('Control+y')],
    stage: [
      10,
      async () => {
        const from = { x: 100 + below(400), y: 100 + below(420) };
        if (random() < 0.2) await page.keyboard.down('Alt');
        await page.mouse.move(from.x, from.y);
        await page.mouse.down();
        if (random() < 0.7) await page.mouse.move(from.x + below(80) - 40, from.y + below(80) - 40, { steps: 1 + below(2) });
        await page.mouse.up();
        await page.keyboard.up('Alt');
      },
    ],
    wheel: [2, () => page.mouse.move(300, 300).then(() => page.mouse.wheel(0, below(600) - 300))],
    escape: [4, () => page.keyboard.press('Escape')],
    address: [
      2,
      () => page.evaluate((hash) => { location.hash = hash; }, one(['', '#nonsense', '#~AAAA', '#~AGQB', '#AAAA~zz', '#%%%'])),
    ],
    files: [
      3,
      async () => {
        const name = one(['a.json', 'face.phiz.json', 'picture.png']);
        await page.locator('input[type=file][accept*=json]').setInputFiles({ name, mimeType: 'application/json', buffer: Buffer.from(one(BROKEN)) });
      },
    ],
    hidden: [
      2,
      async () => {
        await session.send('Page.setWebLifecycleState', { state: 'frozen' });
        await new Promise((later) => setTimeout(later, 50));
        await session.send('Page.setWebLifecycleState', { state: 'active' });
      },
    ],
    lose: [1, () => page.evaluate(() => window.isLost() || window.lose.loseContext())],
    restore: [3, () => page.evaluate(() => window.regain())],
    resize: [1, () => page.setViewportSize(one([{ width: 900, height: 620 }, { width: 360, height: 640 }, { width: 700, height: 400 }]))],
  };
  const bag = Object.entries(actions).flatMap(([name, [often]]) => Array(often).fill(name));

  const unexpected = () => complaints.filter((line) => !EXPECTED.test(line));
  const last = () => `seed ${SEED}, after ${done.length} actions, the last of which: ${done.slice(-25).join(' · ')}`;
  /** A page that hangs is told with what was done last: most of what a browser is asked waits for ever. @template T @param {Promise<T>} action @returns {Promise<T>} */
  async function inTime(action) {
    const answered = new AbortController();
    const hung = later(HUNG, null, { signal: answered.signal }).then(
      () => assert.fail(`nothing for ${HUNG / 1000} s: ${last()}`),
      () => action,
    );
    try {
      return await Promise.race([action, hung]);
    } finally {
      answered.abort();
    }
  }
  const end = performance.now() + MINUTES * 60_000;
  /** @type {Awaited<ReturnType<typeof weight>> | null} */
  let early = null;
  while (performance.now() < end) {
    const name = one(bag);
    if (name !== 'press') done.push(name);
    await inTime(actions[name][1]());
    if (done.length % 25 === 0) {
      assert.deepEqual(unexpected(), [], last());
      const sound = await inTime(page.evaluate(() => {
        const { face } = window.designer;
        return face.positions.every(Number.isFinite) && face.code.length > 0 && !document.querySelector('.failure');
      }));
      assert.ok(sound, last());
    }
    // Once everything has been opened and looked at, which takes a busy machine longer.
    const left = (end - performance.now()) / (MINUTES * 60_000);
    if (!early && left < (done.length < 40 ? 0.25 : 0.6)) early = await inTime(weight(session, page));
  }

  // Whatever is open is closed, and the card comes back.
  await page.keyboard.press('Escape');
  await page.keyboard.press('Escape');
  await page.waitForFunction(() => (window.regain(), !window.isLost()));
  await page.setViewportSize({ width: 900, height: 620 });
  await page.evaluate(() => /** @type {HTMLElement | null} */ (document.activeElement)?.blur());
  // The way between two faces plays until it is left.
  await page.getByRole('tab').first().click();
  await page.waitForTimeout(1000);
  await inTime(settled(page));
  const late = await weight(session, page);
  const steps = done.length;
  console.log(`${steps} actions, seed ${SEED}; ${JSON.stringify(early)} to ${JSON.stringify(late)}`);
  assert.deepEqual(unexpected(), [], last());
  assert.ok(early);
  // A step of undo is some kilobytes, and there is no limit to them; a saved face is a picture.
  assert.ok(late.heap - early.heap < 4 + 0.01 * steps, `the heap grew from ${early.heap} to ${late.heap} MB: ${last()}`);
  assert.ok(late.wasm <= early.wasm + 8, `the module's memory grew from ${early.wasm} to ${late.wasm} MB`);

  // The face is what its address says, to the last bit.
  const state = (/** @type {import('playwright-core').Page} */ where) =>
    where.evaluate(() => {
      const { face } = window.designer;
      return { code: face.code, expression: face.expression, positions: Array.from(face.positions) };
    });
  const here = await state(page);
  const { hash } = new URL(page.url());
  const other = await open(browser, site, { hash });
  const there = await state(other.page);
  assert.deepEqual([there.code, there.expression], [here.code, here.expression], last());
  assert.deepEqual(there.positions, here.positions);
  await other.context.close();
  await context.close();
});
