import { load } from 'phiz';
import { download, open } from './download.js';
import { element } from './element.js';
import { Failure } from './failure.js';
import { text } from '../text.js';

/** @returns {(fraction: number) => void} */
export function showLoading() {
  const bar = element('progress', { max: 1, value: 0, 'aria-label': text.loading });
  document.body.replaceChildren(
    element('main', { class: 'loading' }, element('p', { class: 'brand' }, text.name), bar, element('p', {}, text.loading)),
  );
  return (fraction) => {
    bar.value = fraction;
  };
}

/** @throws Failure when the browser lacks what the page cannot do without */
export function checkBrowser() {
  if (typeof WebAssembly !== 'object') throw new Failure(text.noWasm);
}

/**
 * The median face alone; null when there is none, for which the model makes up.
 * @param {URL} url
 */
export async function loadHead(url) {
  try {
    const response = await fetch(url);
    return response.ok ? await load(response) : null;
  } catch {
    return null;
  }
}

/** @param {URL} url @param {(fraction: number) => void} progress */
export async function loadModel(url, progress) {
  const file = await open(url, progress);
  try {
    // It is read while it comes in.
    return await load(file);
  } catch (error) {
    if (error instanceof Failure) throw error;
    throw new Failure(text.badModel(error instanceof Error ? error.message : String(error)));
  }
}

/**
 * A model's expressions, which come when they are asked for, once.
 * @param {import('phiz').FaceModel} model
 * @param {URL | null} url null when it has none
 * @param {() => void} loaded
 */
export function createExpressionFile(model, url, loaded) {
  /** @type {Promise<void> | null} */
  let coming = null;
  async function fetchAll() {
    if (!url) throw new Error(text.noExpressionsHere);
    const bytes = await download(url, (why) => `${why}.`);
    // What is said about it is on the screen before the work begins.
    await new Promise((painted) => setTimeout(painted));
    await model.loadExpressions(bytes);
    loaded();
  }
  return {
    any: url !== null,
    load() {
      coming ??= fetchAll().catch((error) => {
        // It may be tried again.
        coming = null;
        throw error;
      });
      return coming;
    },
  };
}
