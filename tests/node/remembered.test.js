// What the page remembers of pictures that it took.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createRemembered } from '../../www/src/stage/remembered.js';

test('what was wanted longest ago is forgotten', () => {
  /** @type {ReturnType<typeof createRemembered<string>>} */
  const remembered = createRemembered(2);
  remembered.set('a', 'A');
  remembered.set('b', 'B');
  assert.equal(remembered.get('a'), 'A');
  remembered.set('c', 'C');
  assert.deepEqual(['a', 'b', 'c'].map(remembered.get), ['A', undefined, 'C']);
  // The same once more is no other.
  remembered.set('c', 'D');
  assert.deepEqual(['a', 'c'].map(remembered.get), ['A', 'D']);
  remembered.clear();
  assert.equal(remembered.get('a'), undefined);
});
