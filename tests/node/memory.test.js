// What is said, and what can still be done, when the module's memory is full.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';

import { fastestBuild, load, prepare } from '../../pkg/index.js';

const file = (/** @type {string} */ path) => readFile(new URL(`../../${path}`, import.meta.url));
/** Pages of 64 KiB: the model and some ten faces fit in. */
const MOST = 500;

/** A number as wasm writes it, in as many bytes as it takes. @param {number} value */
function leb(value) {
  const bytes = [];
  do bytes.push((value & 0x7f) | (value > 0x7f ? 0x80 : 0));
  while ((value >>>= 7));
  return bytes;
}

/** The module with a limit to its memory. @param {Uint8Array} module @param {number} pages */
function limited(module, pages) {
  let at = 8;
  const number = () => {
    for (let value = 0, shift = 0; ; shift += 7) {
      const byte = module[at++];
      value |= (byte & 0x7f) << shift;
      if (byte < 0x80) return value;
    }
  };
  while (at < module.length) {
    const start = at;
    const section = module[at++];
    const size = number();
    const end = at + size;
    if (section === 5) {
      assert.equal(number(), 1, 'one memory');
      number();
      const content = [1, 1, ...leb(number()), ...leb(pages)];
      return Buffer.concat([module.subarray(0, start), Uint8Array.from([5, ...leb(content.length), ...content]), module.subarray(end)]);
    }
    at = end;
  }
  throw new Error('no memory in the module');
}

test('a full memory is told, and what there is of it can be given back', async () => {
  const build = fastestBuild();
  await prepare({ build, wasm: limited(await file(`pkg/${build}/phiz_bg.wasm`), MOST) });
  const model = await load(await file('www/public/model.phiz'));
  /** @type {import('phiz').Face[]} */
  const faces = [];
  assert.throws(() => {
    while (faces.length < 10_000) faces.push(model.face());
  }, /no memory left/);
  assert.ok(faces.length > 3, String(faces.length));
  // A control takes more of it than a face that was never changed.
  assert.throws(() => faces[0].set('nose 1', 0.9), /no memory left/);
  // That one is lost with what it was at; it does not keep others from being given back.
  for (const face of faces) face.free();
  const again = model.face();
  again.set('nose 1', 0.9);
  assert.ok(Math.abs(again.get('nose 1') - 0.9) < 1e-3);
  model.free();
  assert.throws(() => model.face(), /freed/);
});
