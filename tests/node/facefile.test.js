// The files of faces that the page opens, also those that other programs write.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';

import { load } from '../../pkg/index.js';
import { facesFile, readFaceFile } from '../../www/src/keep/facefile.js';

const model = await load(await readFile(new URL('../../www/public/model.phiz', import.meta.url)));
const file = (/** @type {unknown} */ content, name = 'faces.json') => new File([JSON.stringify(content)], name);
const codes = [1, 2].map((seed) => {
  const face = model.face();
  face.randomize({ seed });
  return face.code;
});

test('faces as `phiz-fit measure --designs` writes them are opened, all at once', async () => {
  // Names, and neither an expression nor colours: those that there are stay.
  const written = codes.map((code, i) => ({ format: 'phiz-face', version: 2, name: `scan ${i}`, model: model.about.title, code }));
  const read = await readFaceFile(model, file(written));
  assert.ok('faces' in read);
  assert.equal(read.unread, 0);
  assert.deepEqual(read.faces, codes.map((code, i) => ({ name: `scan ${i}`, code, expression: undefined, colouring: undefined })));
});

test('of a file with faces of another model those of this one are opened', async () => {
  const [code] = codes;
  const read = await readFaceFile(model, file([{ format: 'phiz-face', version: 2, name: 'one', code }, { format: 'phiz-face', version: 2, name: 'other', code: 'AAAA' }]));
  assert.ok('faces' in read);
  assert.deepEqual([read.faces.map(({ name }) => name), read.unread], [['one'], 1]);
});

test('what the page writes it reads', async () => {
  const faces = codes.map((code, i) => ({ name: `face ${i}`, code, expression: { jawOpen: 0.25 }, colouring: { skin: 0.5 } }));
  const written = facesFile(model, faces, []);
  const read = await readFaceFile(model, new File([written], 'faces.json'));
  assert.ok('faces' in read);
  assert.deepEqual(read.faces.map(({ name, code, expression }) => ({ name, code, expression })), faces.map(({ name, code, expression }) => ({ name, code, expression })));
});
