// What is said, and what can still be done, when the module's memory is full.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';

import { fastestBuild, load, prepare } from '../../pkg/index.js';
import { limited } from './limited.js';

const file = (/** @type {string} */ path) => readFile(new URL(`../../${path}`, import.meta.url));
/** Pages of 64 KiB: the model and some ten faces fit in. */
const MOST = 500;
/** The same of the module for photos: what prepares it fits in, and no picture of 4096 pixels a side. */
const MOST_PHOTOS = 1200;

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

test('a photo that was at work when memory ran out is freed without a second word', async () => {
  // Of the build whose memory is not full.
  const model = await load(await file('www/public/model.phiz'), { build: 'scalar' });
  await model.preparePhotos({ wasm: limited(await file('pkg/photo/photo_bg.wasm'), MOST_PHOTOS) });
  const [width, height] = [64, 64];
  // A head that looks ahead, 700 mm away, in light from everywhere.
  const camera = { focal: 90, centre: /** @type {const} */ ([32, 32]), rotation: [1, 0, 0, 0, -1, 0, 0, 0, -1], translation: /** @type {const} */ ([0, 0, 700]) };
  const light = { coefficients: [0, 1, 2].map(() => [1, 0, 0, 0, 0, 0, 0, 0, 0]), rms: 0.1 };
  const face = model.face();
  const fit = /** @type {any} */ ({ code: face.code, camera, light, expression: {} });
  const edit = await model.editPhoto({ width, height, fit });
  const rgba = new Uint8ClampedArray(4 * width * height).fill(128);
  assert.throws(() => edit.texture(rgba, 4096), /no memory left/);
  edit.free();
  assert.throws(() => edit.render(face, rgba), /freed/);
  model.free();
});
