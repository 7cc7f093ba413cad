// What a slider that is dragged costs the page's main thread in a frame: the work of the event (the face,
// positions and normals into three.js's arrays, what the panels say) and of drawing it, without the
// calls to WebGL, which a graphics card answers and a processor that draws in its place does not.

import { launch, open, serve } from '../browser/site.js';

const FRAMES = 24;

/** Counts the time in calls to WebGL, in callbacks of frames and in what workers' answers bring about. */
function meter() {
  const spent = (window.spent = { gl: 0, frames: 0, uploads: 0, answers: 0 });
  const { addEventListener } = Worker.prototype;
  Worker.prototype.addEventListener = function (type, listener) {
    const timed = (event) => {
      const start = performance.now();
      listener(event);
      spent.answers += performance.now() - start;
    };
    return addEventListener.call(this, type, type === 'message' ? timed : listener);
  };
  const { prototype } = WebGL2RenderingContext;
  let inside = false;
  for (const [name, { value }] of Object.entries(Object.getOwnPropertyDescriptors(prototype))) {
    if (typeof value !== 'function') continue;
    prototype[name] = function (...given) {
      if (name === 'bufferSubData') spent.uploads += 1;
      if (inside) return value.apply(this, given);
      inside = true;
      const start = performance.now();
      try {
        return value.apply(this, given);
      } finally {
        spent.gl += performance.now() - start;
        inside = false;
      }
    };
  }
  const request = window.requestAnimationFrame;
  window.requestAnimationFrame = (callback) =>
    request.call(window, (now) => {
      const start = performance.now();
      callback(now);
      spent.frames += performance.now() - start;
    });
}

/**
 * @returns {Promise<Record<string, { ms: number, events: number, draws: number, upload: number }>>} for each
 *   slider the main thread's milliseconds beside WebGL (of them the event's and those of answers to it from workers), the
 *   drawings and the ranges that go to the graphics card, a frame
 */
export async function budget() {
  const site = await serve();
  const browser = await launch({ measured: true });
  const { context, page } = await open(browser, site, { sharp: true });
  await page.evaluate(meter);
  /** @type {Record<string, { ms: number, events: number, draws: number, upload: number }>} */
  const found = {};
  const drag = (/** @type {string} */ name) =>
    page.getByRole('slider', { name, exact: true }).evaluate(async (input, frames) => {
      const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
      const [low, high] = [Number(input.min), Number(input.max)];
      const move = (/** @type {number} */ i) => {
        input.value = String(low + (high - low) * (0.5 + 0.4 * Math.sin(i / 3)));
        const start = performance.now();
        input.dispatchEvent(new Event('input', { bubbles: true }));
        return performance.now() - start;
      };
      for (let i = 0; i < 5; i++) {
        move(i);
        await frame();
      }
      Object.assign(window.spent, { gl: 0, frames: 0, uploads: 0, answers: 0 });
      const before = window.designer.frames;
      let events = 0;
      for (let i = 0; i < frames; i++) {
        const gl = window.spent.gl;
        events += move(i) - (window.spent.gl - gl);
        window.spent.gl = gl;
        await frame();
      }
      input.dispatchEvent(new Event('change', { bubbles: true }));
      const { gl, frames: drawing, uploads, answers } = window.spent;
      events += answers;
      return { ms: (events + drawing - gl) / frames, events: events / frames, draws: (window.designer.frames - before) / frames, upload: uploads / frames };
    }, FRAMES);
  for (const [group, name] of [['chin', 'chin 1'], ['nose', 'nose 1'], ['head', 'head 1']]) {
    await page.locator(`.tab[data-group="${group}"]`).click();
    found[name] = await drag(name);
  }
  await page.locator('.tab.whole').click();
  for (const name of ['Age', 'Sex', 'African shape']) found[name] = await drag(name);
  await page.getByRole('tab', { name: 'Looks' }).click();
  for (const name of ['Skin, fair to deep', 'Length, cropped to below the chin', 'Beard, short to long']) found[name] = await drag(name);
  await page.getByRole('button', { name: 'The model’s own' }).click();
  await page.getByRole('tab', { name: 'Expressions' }).click();
  const smile = page.getByRole('slider', { name: 'mouthSmile' }).first();
  await smile.waitFor({ timeout: 30_000 });
  found['Smile mouthSmile'] = await drag('Smile mouthSmile');
  await page.getByRole('tab', { name: 'Features' }).click();
  await page.locator('.tab[data-group="nose"]').click();
  found['nose 1, smiling'] = await drag('nose 1');
  await page.locator('.tab.whole').click();
  found['Age, smiling'] = await drag('Age');
  await context.close();
  await browser.close();
  await site.close();
  return found;
}
