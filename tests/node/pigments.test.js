// The colours that the page paints heads with.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { REST } from '../../www/src/head/colouring.js';
import { asideOf, besideOf, pigments } from '../../www/src/head/pigments.js';
import { Color } from '../../www/node_modules/three/build/three.module.js';

const tone = new Color('#d9a88c');
/** What lips have of the skin around them, red, green and blue. @param {import('../../www/src/head/colouring.js').Colouring} colouring */
function lipsOf(colouring) {
  const { lips, skin } = pigments(tone, colouring);
  return [lips.r / skin.r, lips.g / skin.g, lips.b / skin.b];
}

test('lips are no yellower than the skin, and darker', () => {
  for (let skin = 0; skin <= 1; skin += 0.1) {
    for (const lips of [0.25, REST.lips, 0.6]) {
      const [r, g, b] = lipsOf({ skin, lips });
      // Yellow is what has less of blue than of green.
      assert.ok(b >= g && r < 0.9, `skin ${skin}, lips ${lips}: ${r} ${g} ${b}`);
    }
  }
});

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

test('beards and brows are as the hair is, and may be lighter or darker, redder or greyer', () => {
  const brightness = (/** @type {Color} */ { r, g, b }) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
  for (const colouring of [{ hair: 0.2 }, { hair: 0.5, red: 0.4 }, { hair: 0.9, grey: 0.5 }]) {
    const { hair, beard, brows } = pigments(tone, colouring).grown;
    assert.deepEqual(beard, hair);
    assert.deepEqual(brows.young, hair.young);
    // Brows keep dark hairs.
    assert.ok(hair.turned > 0 ? brows.turned < hair.turned : brows.turned === 0);
    const grown = (/** @type {import('../../www/src/head/colouring.js').Colouring} */ other) => pigments(tone, { ...colouring, ...other }).grown;
    for (const [part, shade, turned] of /** @type {const} */ ([['beard', 'beardShade', 'beardGrey'], ['brows', 'browShade', 'browGrey']])) {
      const shades = [0, 0.3, 0.5, 0.7, 1].map((at) => brightness(grown({ [shade]: at })[part].young));
      assert.ok(shades.every((value, i) => i === 0 || value < shades[i - 1]), `${part}: ${shades}`);
      assert.deepEqual([0, 1].map((at) => grown({ [turned]: at })[part].turned), [0, 1]);
      assert.deepEqual(grown({ [shade]: 0.9, [turned]: 0.9 }).hair, hair);
    }
    const reds = [0, 0.5, 1].map((at) => grown({ beardRed: at }).beard.young).map(({ r, g }) => r / g);
    assert.ok(reds[2] > reds[1] && reds[1] >= reds[0], `${reds}`);
  }
});

test('a slider that is beside another one tells what both give together', () => {
  for (const own of [0, 0.2, 0.7, 1]) {
    assert.equal(besideOf(own, 0.5), own);
    for (const theirs of [0, 0.1, 0.2, 0.65, 1]) assert.ok(Math.abs(besideOf(own, asideOf(own, theirs)) - theirs) < 1e-12, `${theirs} beside ${own}`);
  }
});
