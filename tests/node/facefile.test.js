// The files of faces that the page opens, also those that other programs write.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';

import { load } from '../../pkg/index.js';
import { COLOURS } from '../../www/src/head/colouring.js';
import { faceFile, facesFile, readFaceFile } from '../../www/src/keep/facefile.js';

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

test('of a newer version, of none, and of more faces than a browser keeps', async () => {
  const [code] = codes;
  const one = { format: 'phiz-face', version: 2, name: 'one', code };
  const read = await readFaceFile(model, file([one, { ...one, version: 3 }, { ...one, code: 'AAAA' }, { ...one, format: 'other', version: 9 }]));
  assert.ok('faces' in read);
  assert.deepEqual([read.faces.length, read.newer, read.unread], [1, 1, 2]);
  await assert.rejects(readFaceFile(model, file({ ...one, version: 3 })), /faces\.json was written by a newer version of this page \(3\)/);
  for (const version of [undefined, '2', 0, null]) await assert.rejects(readFaceFile(model, file({ ...one, version })), /faces\.json is damaged: it does not say of which version it is/);
  // As many as five million letters are kept of, with what a file has between them.
  const colouring = Object.fromEntries(COLOURS.map((name) => [name, 0.55]));
  const own = { name: 'somebody', code: 'A'.repeat(code.length), expression: { jawOpen: 0.25 }, colouring };
  const many = Array.from({ length: Math.floor(5_000_000 / JSON.stringify({ id: 'own-m1k2j3h4-abcde', ...own }).length) }, () => own);
  const all = facesFile(model, many, []);
  assert.ok(all.size > 5_000_000);
  const back = await readFaceFile(model, new File([all], 'faces.json'));
  assert.ok('faces' in back);
  assert.equal(back.unread, many.length);
});

test('who has no name has that of the file', async () => {
  const read = await readFaceFile(model, file({ format: 'phiz-face', version: 2, code: codes[0] }, 'anna.phiz.json'));
  assert.equal('name' in read && read.name, 'anna');
});

test('an expression that rounds to nothing is a face at rest', async () => {
  const [code] = codes;
  const read = await readFaceFile(model, new File([faceFile(model, { name: 'photo', code, expression: { jawOpen: 0.004, mouthClose: 0.006 } })], 'face.json'));
  assert.deepEqual('name' in read && read.expression, { mouthClose: 0.01 });
});

test('what the page writes it reads', async () => {
  const colouring = { skin: 0.5, marks: 'AAgABQoKKDwoZA' };
  const faces = codes.map((code, i) => ({ name: `face ${i}`, code, expression: { jawOpen: 0.25 }, colouring }));
  const written = facesFile(model, faces, []);
  const read = await readFaceFile(model, new File([written], 'faces.json'));
  assert.ok('faces' in read);
  assert.deepEqual(read.faces, faces);
});
