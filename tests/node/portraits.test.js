// Who sits for a portrait next: the page waits while hair is grown.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { batchOf } from '../../www/src/stage/batch.js';

test('of four who sit for their portraits one has hair or a beard that is to be grown', () => {
  const waiting = new Set(
    [{}, { length: 0.5 }, { crop: 1 }, { beardLength: 0.2, beard: 0.5 }, { length: 0.5, beardLength: 0.3 }, {}, {}].map((colouring, i) => JSON.stringify({ code: `${i}`, ...(i > 0 && { colouring }) })),
  );
  /** @type {string[]} */
  const batches = [];
  while (waiting.size > 0) {
    const batch = batchOf(waiting);
    for (const [code] of batch) waiting.delete(code);
    batches.push(batch.map(([, sitter]) => sitter.code).join(''));
  }
  assert.deepEqual(batches, ['0125', '36', '4']);
});
