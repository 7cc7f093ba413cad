// Which model the page's address asks for.

import assert from 'node:assert/strict';
import { test } from 'node:test';

import { addressOf, chosenModel, modelNames } from '../../www/src/frame/models.js';

const BASE = 'https://site.example/faces/';
/** @param {string} search */
function asked(search) {
  Object.assign(globalThis, { location: new URL(search, BASE), document: { baseURI: BASE } });
  const { url, expressions, head, ...rest } = chosenModel();
  return { ...rest, url: url.href, expressions: expressions?.href ?? null, head: head?.href ?? null };
}

test('the page’s own models go by their names, and what is none is the usual one', () => {
  const [usual] = modelNames;
  const own = asked('');
  assert.deepEqual(own, { name: usual, known: true, url: `${BASE}model.phiz`, expressions: `${BASE}expressions.phiz`, head: `${BASE}head.phiz` });
  assert.equal(asked('?model=synthetic').url, `${BASE}synthetic.phiz`);
  for (const none of ['constructor', 'ours', 'ours.zip', '']) assert.deepEqual(asked(`?model=${none}`), { ...own, known: false });
});

test('a model of one’s own is a file of the same site, and so are its expressions', () => {
  const own = { name: 'ours/v2.phiz', known: true, url: `${BASE}ours/v2.phiz`, expressions: null, head: null };
  assert.deepEqual(asked('?model=ours/v2.phiz'), own);
  assert.deepEqual(asked('?model=ours/v2.phiz&expressions=ours/e.phiz'), { ...own, expressions: `${BASE}ours/e.phiz` });
  assert.equal(asked('?model=/ours.phiz').url, 'https://site.example/ours.phiz');
  for (const foreign of ['https://other.example/x.phiz', '//other.example/x.phiz', 'data:,x.phiz', 'javascript:x.phiz', 'http://[.phiz']) {
    assert.equal(asked(`?model=${encodeURIComponent(foreign)}`).known, false, foreign);
    assert.equal(asked(`?model=ours/v2.phiz&expressions=${encodeURIComponent(foreign)}`).expressions, null, foreign);
  }
});

test('the way to another model leaves nothing of this one in the address', () => {
  asked('?model=ours.phiz&expressions=e.phiz&other=1#code');
  assert.equal(addressOf('synthetic'), `${BASE}?other=1&model=synthetic`);
  assert.equal(addressOf(modelNames[0]), `${BASE}?other=1`);
});
