import { Failure } from './failure.js';
import { text } from '../text.js';

/**
 * Fetches a model and tells how far it is.
 * @param {string | URL} url
 * @param {(fraction: number) => void} progress
 * @param {(why: string) => string} [failed] what to say when it does not come
 */
export async function download(url, progress, failed = text.noModel) {
  let response;
  try {
    response = await fetch(url);
  } catch (error) {
    throw new Failure(failed(error instanceof Error ? error.message : String(error)));
  }
  if (!response.ok || !response.body) {
    throw new Failure(failed(`${response.status} ${response.statusText}`.trim()));
  }
  // The length counts compressed bytes when the server compresses: then it is only a hint.
  const total = Number(response.headers.get('content-length')) || 2_000_000;
  const chunks = [];
  let length = 0;
  const reader = response.body.getReader();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      chunks.push(value);
      length += value.length;
      progress(Math.min(1, length / total));
    }
  } catch (error) {
    throw new Failure(failed(error instanceof Error ? error.message : String(error)));
  }
  const bytes = new Uint8Array(length);
  let at = 0;
  for (const chunk of chunks) {
    bytes.set(chunk, at);
    at += chunk.length;
  }
  return bytes;
}
