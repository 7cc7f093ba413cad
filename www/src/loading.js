import { load } from 'phiz';
import { download } from './download.js';
import { element } from './element.js';
import { Failure } from './failure.js';
import { text } from './text.js';

/** @returns {(fraction: number) => void} */
function showLoading() {
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
  const probe = document.createElement('canvas').getContext('webgl2');
  if (!probe) throw new Failure(text.noWebGL);
  // Browsers allow few contexts at a time; give this one back.
  probe.getExtension('WEBGL_lose_context')?.loseContext();
}

/** @param {URL} url */
export async function loadModel(url) {
  const bytes = await download(url, showLoading());
  try {
    return await load(bytes);
  } catch (error) {
    throw new Failure(text.badModel(error instanceof Error ? error.message : String(error)));
  }
}
