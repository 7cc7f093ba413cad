// The colours that the page paints heads with.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { REST } from '../../www/src/head/colouring.js';
import { pigments } from '../../www/src/head/pigments.js';
import { Color } from '../../www/node_modules/three/build/three.module.js';

const tone = new Color('#d9a88c');
/** What lips have of the skin around them, red, green and blue. @param {import('../../www/src/head/colouring.js').Colouring} colouring */
function lipsOf(colouring) {
  const { lips, skin } = pigments(tone, colouring);
  return [lips.r / skin.r, lips.g / skin.g, lips.b / skin.b];
}

test('lips are the redder beside the skin the fairer it is, whatever blood is in both', () => {
  const redness = (/** @type {number} */ skin) => {
    const [r, g] = lipsOf({ skin });
    return r / g;
  };
  const all = [REST.skin, 0.5, 0.7, 0.85, 1].map(redness);
  assert.ok(all.every((value, i) => i === 0 || value < all[i - 1]), `${all}`);
  assert.ok(all[4] < 0.85 * all[0], `${all}`);
  // Still lips.
  assert.ok(all[4] > 1.2, `${all}`);
  assert.equal(redness(0), redness(REST.skin));
  for (const skin of [REST.skin, 1]) {
    const [least, most] = [0.1, 0.9].map((blood) => lipsOf({ skin, blood }));
    least.forEach((part, k) => assert.ok(Math.abs(part / most[k] - 1) < 1e-9));
  }
});
