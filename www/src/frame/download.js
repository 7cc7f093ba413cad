import { Failure } from './failure.js';
import { text } from '../text.js';

/**
 * A file, of which it is told how much is there; what is wrong with it is a `Failure`.
 * @param {string | URL} url
 * @param {(fraction: number) => void} progress
 * @param {(why: string) => string} [failed] what to say when it does not come
 * @returns {Promise<ReadableStream<Uint8Array>>}
 */
export async function open(url, progress, failed = text.noModel) {
  const failure = (/** @type {unknown} */ error) => new Failure(failed(error instanceof Error ? error.message : String(error)));
  let response;
  try {
    response = await fetch(url);
  } catch (error) {
    throw failure(error);
  }
  if (!response.ok || !response.body) {
    throw new Failure(failed(`${response.status} ${response.statusText}`.trim()));
  }
  // The length counts compressed bytes when the server compresses: then it is only a hint.
  const total = Number(response.headers.get('content-length')) || 2_000_000;
  const reader = response.body.getReader();
  let length = 0;
  return new ReadableStream({
    async pull(out) {
      try {
        const { value } = await reader.read();
        if (!value) return out.close();
        length += value.length;
        progress(Math.min(1, length / total));
        out.enqueue(value);
      } catch (error) {
        out.error(failure(error));
      }
    },
    cancel: (why) => reader.cancel(why),
  });
}

/** How often a module did not come, by its address. @type {Map<string, number>} */
const missed = new Map();

/**
 * A part of the page that comes when it is wanted; what a browser says when it does not is no sentence. A browser that once
 * asked for a module in vain does not ask again for as long as the page is there (HTML, "fetch a single module script"), unless it
 * has another address.
 * @template T
 * @param {() => Promise<T>} come
 * @returns {Promise<T>}
 */
export async function part(come) {
  try {
    return await come();
  } catch (error) {
    // Chromium and Firefox say which.
    const url = /https?:\S+\.js/.exec(error instanceof Error ? error.message : '')?.[0] ?? '';
    // Where there is a connection, it is of a page that is there no longer: some servers answer with their first page.
    const answer = url && (await fetch(url).catch(() => null));
    if (answer && answer.status < 500 && !/javascript/.test(answer.headers.get('content-type') ?? '')) throw new Failure(text.renewed, { cause: error });
    const times = missed.get(url) ?? 0;
    if (url) missed.set(url, times + 1);
    if (times > 0) {
      try {
        return await import(/* @vite-ignore */ `${url}?again=${times}`);
      } catch {
        // Nor did it come now.
      }
    }
    throw new Failure(text.needsConnection, { cause: error });
  }
}

/**
 * All of a file.
 * @param {string | URL} url
 * @param {(why: string) => string} failed
 */
export async function download(url, failed) {
  const reader = (await open(url, () => {}, failed)).getReader();
  const chunks = [];
  for (;;) {
    const { value } = await reader.read();
    if (!value) return new Blob(chunks).arrayBuffer();
    chunks.push(/** @type {Uint8Array<ArrayBuffer>} */ (value));
  }
}
