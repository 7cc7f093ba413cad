// From what a photo tells of a person's looks to the page's sliders, and back.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { REST, whole } from '../../www/src/head/colouring.js';
import { scatters } from '../../www/src/hair/scattered.js';
import { colouringOf, HAIR_SHOWN } from '../../www/src/photo/looks.js';
import { coloured } from '../../www/src/photo/grey.js';
import { hairColour, irisColours, pigments, skinColour } from '../../www/src/head/pigments.js';
import { Color, SRGBColorSpace } from '../../www/node_modules/three/build/three.module.js';

const tone = new Color('#d9a88c');
const rgb = (/** @type {Color} */ { r, g, b }) => /** @type {[number, number, number]} */ ([r, g, b]);
/** What a photo would have of skin: as the page's shader shows it. */
const seen = (/** @type {Color} */ { r, g, b }) => /** @type {[number, number, number]} */ ([(r * 0.97) / 0.8, (g * 0.875) / 0.8, (b * 0.81) / 0.8]);
const bald = { skin: seen(tone), irises: null, beard: 0, beardColour: null, hair: null };
/** What a photo would have of hair. @param {Color} hair */
const seenHair = (hair) => {
  const [r, g, b] = rgb(hair).map((value) => HAIR_SHOWN * value);
  return /** @type {[number, number, number]} */ ([r, g, b].map((value) => value * scatters([r, g, b])));
};
const short = { colour: seenHair(hairColour(REST.hair, 0, 0)), cover: 1, off: 12, hangs: 0, forehead: 0, aside: 0, lean: 0 };
/** How far apart two colours are: the logarithm of the greatest ratio of a channel. Below a hundredth all is black. */
const apart = (/** @type {number[]} */ a, /** @type {number[]} */ b) => Math.max(...a.map((value, k) => Math.abs(Math.log((value + 0.01) / (b[k] + 0.01)))));

describe('looks', () => {
  test('of the head at rest are at rest', () => {
    assert.deepEqual(colouringOf(bald, tone), {});
    const { crop, length, ...rest } = colouringOf({ ...bald, hair: short }, tone);
    assert.ok(crop > 0.5 && length > 0.1, `${crop}, ${length}`);
    assert.ok(Object.keys(rest).every((name) => name === 'comb'), JSON.stringify(rest));
  });

  test('of other skins look like them', () => {
    for (const skin of [0, 0.15, 0.5, 0.75, 1]) {
      for (const blood of [0.1, 0.3, 0.7]) {
        const wanted = skinColour(tone, skin, blood);
        const found = whole(colouringOf({ ...bald, skin: seen(wanted) }, tone));
        const off = apart(rgb(skinColour(tone, found.skin, found.blood)), rgb(wanted));
        // A shade that two sliders share is not told twice: what is drawn counts.
        assert.ok(off < 0.1, `skin ${skin} with blood ${blood} is off by ${off}: ${JSON.stringify(found)}`);
      }
    }
  });

  test('of a dark iris that mirrors the sky are brown, of a blue one blue', () => {
    // As the brown eyes of a portrait were measured, with a window in them, and the blue ones of a scan in the dark.
    const iris = (/** @type {[number, number, number]} */ irises) => whole(colouringOf({ ...bald, irises }, tone)).iris;
    assert.equal(iris([0.061, 0.064, 0.075]), REST.iris);
    assert.equal(iris([0.053, 0.042, 0.063]), REST.iris);
    assert.equal(iris([0.0586, 0.0718, 0.0793]), REST.iris);
    assert.ok(iris([0.098, 0.136, 0.131]) < 0.3);
    assert.ok(iris([0.04, 0.082, 0.085]) < 0.3);
    // Brown ones in the shade of brows.
    assert.equal(iris([0.0401, 0.0348, 0.0222]), REST.iris);
    // As brown eyes that laugh were measured: half of what is taken for them are lids.
    const laughing = whole(colouringOf({ ...bald, skin: [0.503, 0.244, 0.153], irises: [0.355, 0.185, 0.147] }, tone)).iris;
    assert.ok(laughing > 0.55, `${laughing}`);
    // The same portrait, fitted a little otherwise: under pale skin it would be blue. A green one stays green.
    const under = (/** @type {number} */ skin, /** @type {[number, number, number]} */ irises) =>
      whole(colouringOf({ ...bald, skin: seen(skinColour(tone, skin, REST.blood)), irises }, tone)).iris;
    assert.equal(under(0.56, [0.0714, 0.0961, 0.1236]), REST.iris);
    assert.ok(under(0.1, [0.0901, 0.1243, 0.1563]) < 0.3);
    const { inner, outer } = irisColours(0.4);
    assert.ok(Math.abs(under(0.6, /** @type {[number, number, number]} */ (rgb(inner.lerp(outer, 0.5)))) - 0.4) < 0.13);
  });

  test('of hair and eyes look like them', () => {
    for (const [hair, red, grey] of [[0.05, 0, 0], [0.4, 0, 0], [1, 0, 0], [0.4, 0.8, 0], [0.5, 0, 0.8], [0.9, 0, 0.3]]) {
      const wanted = rgb(hairColour(hair, red, grey));
      const found = whole(colouringOf({ ...bald, hair: { ...short, colour: seenHair(hairColour(hair, red, grey)) } }, tone));
      const off = apart(rgb(hairColour(found.hair, found.red, found.grey)), wanted);
      // What is nearly black is taken for a little less of it: a camera's noise.
      assert.ok(off < (hair < 1 ? 0.15 : 0.35), `hair ${hair}, ${red}, ${grey} is off by ${off}: ${JSON.stringify(found)}`);
    }
    for (const iris of [0.05, 0.4, 0.6, 0.95]) {
      const { inner, outer } = irisColours(iris);
      const colour = rgb(inner.lerp(outer, 0.5));
      // In the shade of the lids, too.
      for (const light of [1, 0.8]) {
        const found = whole(colouringOf({ ...bald, irises: [colour[0] * light, colour[1] * light, colour[2] * light] }, tone)).iris;
        assert.ok(Math.abs(found - iris) < 0.13, `an iris of ${iris} is ${found}`);
      }
    }
    // Dark and grey is what a camera makes of brown eyes in the shade.
    assert.equal(whole(colouringOf({ ...bald, irises: [0.035, 0.03, 0.033] }, tone)).iris, REST.iris);
  });

  test('of the same hair are alike, wherever a photo of it ends', () => {
    // As a portrait was measured, a larger one of the same, and one that ends above the hairline.
    const hairs = [{ colour: [0.266, 0.189, 0.074], off: 16 }, { colour: [0.277, 0.196, 0.074], off: 16 }, { colour: [0.204, 0.138, 0.0437], off: 12 }];
    const [first, ...others] = hairs.map((hair) => whole(colouringOf({ ...bald, hair: { ...short, forehead: 0.87, ...hair } }, tone)));
    for (const other of others) {
      const [a, b] = [first, other].map(({ hair, red, grey }) => rgb(hairColour(hair, red, grey)));
      // Of the last only the shaded front of the hair is seen.
      assert.ok(apart(a, b) < 0.5, `${JSON.stringify(first)} and ${JSON.stringify(other)}`);
      assert.ok(Math.abs(other.length - first.length) < 0.05, `${other.length} and ${first.length}`);
    }
    // What is told is believed, whatever else is: a dark fringe is dark.
    const dark = (/** @type {number} */ forehead) => whole(colouringOf({ ...bald, hair: { ...short, colour: [0.113, 0.062, 0.0148], off: 4, forehead } }, tone)).hair;
    assert.equal(dark(0), dark(0.87));
  });

  test('of hair of any length have it', () => {
    const lengthOf = (/** @type {object} */ more) => whole(colouringOf({ ...bald, hair: { ...short, ...more } }, tone)).length;
    assert.equal(lengthOf({ off: 3 }), 0);
    const lengths = [{ off: 8 }, { off: 16 }, { off: 28 }, { hangs: 40 }, { hangs: 80 }, { hangs: 140 }].map(lengthOf);
    for (const [i, length] of lengths.entries()) assert.ok(i === 0 || length > lengths[i - 1], lengths.join(', '));
    const fringe = whole(colouringOf({ ...bald, hair: { ...short, off: 3, forehead: 0.6 } }, tone));
    assert.ok(fringe.comb > 0.7 && fringe.length > 0.2, JSON.stringify(fringe));
    const partings = [-0.5, -0.1, 0, 0.1, 0.5].map((aside) => whole(colouringOf({ ...bald, hair: { ...short, forehead: 0.6, aside } }, tone)).parting);
    assert.deepEqual([partings[0], partings[2], partings[4]], [0, 0.5, 1]);
    assert.ok(partings[1] < 0.5 && partings[3] > 0.5, partings.join(', '));
    // A fringe that is whole tells by its strands.
    const leans = [-0.4, -0.1, 0, 0.1, 0.4].map((lean) => whole(colouringOf({ ...bald, hair: { ...short, forehead: 0.9, lean } }, tone)).parting);
    assert.deepEqual([leans[0], leans[2], leans[4]], [0, 0.5, 1]);
    assert.ok(leans[1] < 0.5 && leans[3] > 0.5, leans.join(', '));
    assert.ok(whole(colouringOf({ ...bald, hair: { ...short, cover: 0.4 } }, tone)).crop < 0.6);
  });

  test('without colours tell how bright they are, and no hue', () => {
    const brightness = (/** @type {number[]} */ [r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
    for (const skin of [0.15, 0.5, 0.8]) {
      const light = brightness(seen(skinColour(tone, skin, REST.blood)));
      const hair = brightness(seenHair(hairColour(0.7, 0, 0)));
      const grey = (/** @type {number} */ value) => /** @type {[number, number, number]} */ ([value, value, value]);
      const found = whole(colouringOf({ ...bald, skin: grey(light), irises: grey(0.08), hair: { ...short, colour: grey(hair) } }, tone));
      assert.ok(Math.abs(found.skin - skin) < 0.1, `skin ${skin} is ${found.skin}`);
      assert.ok(Math.abs(found.hair - 0.7) < 0.1 && found.red === REST.red && found.grey === REST.grey, JSON.stringify(found));
      assert.equal(found.iris, REST.iris);
      assert.ok(found.blood <= REST.blood, `${found.blood}`);
    }
    // The head wears skin's colours, as light and dark as the photo; a photo that has colours keeps its own.
    const texture = (/** @type {(i: number) => number[]} */ of) => ({ size: 64, rgba: Uint8ClampedArray.from({ length: 4 * 64 * 64 }, (_, i) => [...of(i >> 2), 255][i % 4]) });
    const value = (/** @type {number} */ i) => 120 + (i % 90);
    const linear = (/** @type {number} */ byte) => new Color().setRGB(byte / 255, 0, 0, SRGBColorSpace).r;
    const { rgba } = coloured(texture((i) => [value(i), value(i), value(i)]), tone);
    for (const i of [0, 30, 60]) {
      const [r, g, b] = rgba.subarray(4 * i, 4 * i + 3);
      assert.ok(r > g && g > b, `${r} ${g} ${b}`);
      const light = brightness([r, g, b].map(linear)) / linear(value(i));
      assert.ok(Math.abs(light - 1) < 0.03, `${light} of the light`);
    }
    const own = texture((i) => [value(i), value(i) - 20, value(i) - 40]);
    assert.deepEqual(coloured(own, tone).rgba, own.rgba);
  });

  test('of lips are as red as those beside the skin, and at rest where they are not seen or nothing has a colour', () => {
    // As the page draws them: some of the skin shows through lips that are not painted.
    const through = [0.97, 0.875, 0.81];
    const drawn = (/** @type {number} */ skin, /** @type {number} */ lips) => {
      const colours = pigments(tone, { skin, lips });
      return rgb(colours.lips).map((value, k) => (colours.lipCover * value + (1 - colours.lipCover) * rgb(colours.skin)[k] * through[k]) / 0.8);
    };
    for (const skin of [0.1, REST.skin, 0.6, 0.85]) {
      const own = rgb(skinColour(tone, skin, REST.blood)).map((value, k) => (value * through[k]) / 0.8);
      const told = (/** @type {number[]} */ lips, /** @type {number} */ sight) => whole(colouringOf({ ...bald, skin: own }, tone, {}, Float32Array.from({ length: 72 }, (_, i) => (i % 4 < 3 ? lips[i % 4] : sight)))).lips;
      const all = [0, 0.2, 0.4, 0.6, 0.8, 1].map((lips) => told(drawn(skin, lips), 1));
      assert.ok(all.every((value, i) => i === 0 || value > all[i - 1]), `skin ${skin}: ${all}`);
      assert.ok(Math.abs(all[2] - REST.lips) < 0.05 && all[0] < 0.3 && all[5] > 0.7, `skin ${skin}: ${all}`);
      // How bright they are tells little: they shine, or are in shadow.
      assert.ok(Math.abs(told(drawn(skin, 0.6).map((value) => 1.15 * value), 1) - all[3]) < 0.1);
      assert.equal(told(drawn(skin, 0.9), 0), REST.lips);
    }
    const grey = [0.3, 0.3, 0.3];
    assert.equal(whole(colouringOf({ ...bald, skin: /** @type {[number, number, number]} */ (grey) }, tone, {}, Float32Array.from({ length: 72 }, () => 0.1))).lips, REST.lips);
  });

  test('of a beard have one', () => {
    const beardOf = (/** @type {number} */ beard) => whole(colouringOf({ ...bald, beard }, tone));
    assert.equal(beardOf(0.05).beard, 0);
    assert.ok(beardOf(0.25).beard > 0 && beardOf(0.25).beardLength === 0);
    assert.ok(beardOf(0.9).beard > 0.5 && beardOf(0.9).beardLength > 0);
  });

  test('of a beard and no hair have its colour; whose hair is seen have that', () => {
    for (const [hair, red, grey] of [[0.15, 0, 0], [0.4, 0, 0], [0.7, 0, 0], [0.4, 0.8, 0], [0.6, 0, 0.8]]) {
      // As the page draws one: skin is seen through it.
      const beardColour = seenHair(hairColour(hair, red, grey)).map((value, k) => 0.93 * value + 0.07 * bald.skin[k]);
      const found = whole(colouringOf({ ...bald, beard: 0.9, beardColour }, tone));
      const off = apart(rgb(hairColour(found.hair, found.red, found.grey)), rgb(hairColour(hair, red, grey)));
      assert.ok(off < 0.2, `hair ${hair}, ${red}, ${grey} is off by ${off}: ${JSON.stringify(found)}`);
      assert.equal(found.length, 0);
      const other = whole(colouringOf({ ...bald, beard: 0.9, beardColour, hair: short }, tone));
      assert.ok(Math.abs(other.hair - REST.hair) < 0.06, JSON.stringify(other));
    }
  });

  test('with a white beard below dark hair have both; what is nearly of one colour is of one', () => {
    const told = (/** @type {[number, number, number]} */ ofHair, /** @type {[number, number, number]} */ ofBeard) => {
      const beardColour = seenHair(hairColour(...ofBeard)).map((value, k) => 0.93 * value + 0.07 * bald.skin[k]);
      return colouringOf({ ...bald, beard: 0.9, beardColour, hair: { ...short, colour: seenHair(hairColour(...ofHair)) } }, tone);
    };
    const both = pigments(tone, told([0.8, 0, 0], [0.8, 0, 1])).grown;
    assert.ok(apart(rgb(both.hair.all), rgb(hairColour(0.8, 0, 0))) < 0.2, JSON.stringify(both.hair));
    assert.ok(apart(rgb(both.beard.all), rgb(hairColour(0.8, 0, 1))) < 0.25, JSON.stringify(both.beard));
    for (const ofBeard of /** @type {[number, number, number][]} */ ([[0.8, 0, 0], [0.6, 0, 0], [0.8, 0, 0.1]])) {
      const { beardShade, beardRed, beardGrey } = whole(told([0.8, 0, 0], ofBeard));
      assert.deepEqual([beardShade, beardRed, beardGrey], [0.5, 0.5, 0.5], `${ofBeard}`);
    }
  });
});
