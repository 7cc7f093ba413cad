// What a slider that is dragged costs the page's main thread in a frame: the work of the event (the face,
// positions and normals into three.js's arrays, what the panels say) and of drawing it, without the
// calls to WebGL, which a graphics card answers and a processor that draws in its place does not.

import { launch, open, serve } from '../browser/site.js';

/** A drag of two seconds, before which it goes on for one: code that ran a few times is interpreted. */
const FRAMES = 120;
const BEFORE = 60;

/** Counts the time in calls to WebGL, in callbacks of frames and in what workers' answers bring about. */
function meter() {
  const spent = (window.spent = { gl: 0, frames: 0, answers: 0 });
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
 * @typedef {object} Dragged of a slider, a frame: medians
 * @property {number} ms the main thread's milliseconds beside WebGL
 * @property {number} events of them the event's and those of answers to it from workers
 * @property {number} most below which nine tenths of the frames' are
 * @property {number} draws drawings
 */

/** @returns {Promise<Record<string, Dragged>>} for each slider */
export async function budget() {
  const site = await serve();
  const browser = await launch({ measured: true });
  const { context, page } = await open(browser, site, { sharp: true });
  await page.evaluate(meter);
  /** @type {Record<string, Dragged>} */
  const found = {};
  const drag = (/** @type {string} */ name) =>
    page.getByRole('slider', { name, exact: true }).evaluate(
      async (input, [before, frames]) => {
        const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
        const [low, high] = [Number(input.min), Number(input.max)];
        const move = (/** @type {number} */ i) => {
          input.value = String(low + (high - low) * (0.5 + 0.4 * Math.sin(i / 3)));
          const start = performance.now();
          input.dispatchEvent(new Event('input', { bubbles: true }));
          return performance.now() - start;
        };
        for (let i = 0; i < before; i++) {
          move(i);
          await frame();
        }
        /** @type {number[]} */
        const events = [];
        /** @type {number[]} */
        const all = [];
        const drawn = window.designer.frames;
        for (let i = 0; i < frames; i++) {
          Object.assign(window.spent, { gl: 0, frames: 0, answers: 0 });
          const event = move(i) - window.spent.gl;
          window.spent.gl = 0;
          await frame();
          const { gl, frames: drawing, answers } = window.spent;
          events.push(event + answers);
          all.push(event + answers + drawing - gl);
        }
        const draws = (window.designer.frames - drawn) / frames;
        input.dispatchEvent(new Event('change', { bubbles: true }));
        const part = (/** @type {number[]} */ of, /** @type {number} */ share) => of.toSorted((a, b) => a - b)[Math.floor(share * of.length)];
        return { ms: part(all, 0.5), events: part(events, 0.5), most: part(events, 0.9), draws };
      },
      /** @type {const} */ ([BEFORE, FRAMES]),
    );
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
