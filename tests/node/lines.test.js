// Lines and freckles on the default model's mean: where they are, and which an expression folds.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { describe, test } from 'node:test';
import { load } from '../../pkg/index.js';
import { Color, Texture } from '../../www/node_modules/three/build/three.module.js';
import { foldingOf, foldsOf } from '../../www/src/head/folds.js';
import { paintLines } from '../../www/src/head/lines.js';
import { pigments } from '../../www/src/head/pigments.js';
import { createSkin } from '../../www/src/head/skin.js';

// A graphics card, of which nothing is asked.
globalThis.document = /** @type {any} */ ({ createElement: () => ({ getContext: () => null }) });

const model = await load(readFileSync(new URL('../../www/public/model.phiz', import.meta.url)));
const face = model.face();
const rest = face.positions.slice();
/** @type {Map<string, [number, number, number]>} */
const landmarks = new Map(model.landmarks.map(({ name, stencil }) => [name, [0, 1, 2].map((k) => stencil.reduce((sum, [v, w]) => sum + w * rest[3 * v + k], 0))]));
const at = (/** @type {string} */ name) => landmarks.get(name) ?? [NaN, NaN, NaN];

describe('lines', () => {
  const { map, frame } = paintLines(landmarks);
  /** The map's bytes at a place, mm. */
  const read = (x, y) => {
    const [i, j] = [x, y].map((value, k) => Math.floor(((value - frame[k]) / frame[2 + k]) * map.size));
    return map.rgba.subarray(4 * (j * map.size + i), 4 * (j * map.size + i) + 4);
  };
  /** The deepest line on the way between two places. */
  const deepest = ([ax, ay], [bx, by]) => Math.max(...Array.from({ length: 200 }, (_, i) => read(ax + ((bx - ax) * i) / 199, ay + ((by - ay) * i) / 199)[2]));

  test('are where faces fold, and not on lips, eyes, cheeks and the nose', () => {
    const forehead = [at('ibug_27'), at('trichion')];
    assert.ok(deepest([12, forehead[0][1] + 8], [12, forehead[1][1] - 6]) > 120, 'no line across the forehead');
    for (const [wing, corner] of [['ibug_31', 'ibug_48'], ['ibug_35', 'ibug_54']]) {
      const [nose, mouth] = [at(wing), at(corner)];
      const y = (nose[1] + mouth[1]) / 2;
      assert.ok(deepest([nose[0], y], [mouth[0] + Math.sign(mouth[0]) * 12, y]) > 150, `no fold from ${wing} to ${corner}`);
    }
    for (const corner of ['ibug_36', 'ibug_45']) {
      const [x, y] = at(corner);
      assert.ok(deepest([x + Math.sign(x) * 8, y - 12], [x + Math.sign(x) * 8, y + 12]) > 60, `no line beside ${corner}`);
    }
    const [tip] = [at('ibug_30')];
    assert.equal(deepest([tip[0] - 8, tip[1]], [tip[0] + 8, tip[1]]), 0, 'a line on the nose');
    for (const [inner, outer] of [['ibug_39', 'ibug_36'], ['ibug_42', 'ibug_45']]) assert.ok(deepest(at(inner), at(outer)) < 40, 'a line across an eye');
    for (const side of [-1, 1]) assert.ok(deepest([side * 48, tip[1] - 4], [side * 60, tip[1] - 4]) < 10, 'a line on a cheek');
    // What goes down comes up again: the relief lies on the skin.
    let [right, up] = [0, 0];
    for (let o = 0; o < map.rgba.length; o += 4) {
      right += map.rgba[o] - 127.5;
      up += map.rgba[o + 1] - 127.5;
    }
    const texels = map.rgba.length / 4;
    assert.ok(Math.abs(right / texels) < 0.6 && Math.abs(up / texels) < 0.6, `it leans by ${right / texels}, ${up / texels}`);
  });

  test('bags, jowls and hollow cheeks are on both sides', () => {
    /** How the relief rises to the right and up, over some mm around a place. */
    const slope = (/** @type {number} */ x, /** @type {number} */ y) => {
      const all = [-1.5, 0, 1.5].flatMap((i) => [-1.5, 0, 1.5].map((j) => read(x + i, y + j)));
      return [0, 1].map((k) => all.reduce((sum, texel) => sum + texel[k] - 127.5, 0) / all.length);
    };
    const [chin] = [at('ibug_08')];
    for (const [side, outer, inner, corner] of /** @type {const} */ ([[-1, 'ibug_41', 'ibug_40', 'ibug_48'], [1, 'ibug_46', 'ibug_47', 'ibug_54']])) {
      const [lid, mouth] = [[0, 1].map((k) => (at(outer)[k] + at(inner)[k]) / 2), at(corner)];
      assert.ok(slope(lid[0], lid[1] - 9.5)[1] > 12, `a bag's lower edge falls: ${slope(lid[0], lid[1] - 9.5)}`);
      const jowl = [mouth[0] + side * 13, 0.3 * mouth[1] + 0.7 * chin[1]];
      assert.ok(side * slope(jowl[0] + side * 6, jowl[1])[0] < -12 && side * slope(jowl[0] - side * 6, jowl[1])[0] > 12, 'a jowl stands out');
    }
  });

  test('a neck has rings and bands, which go no further than it is seen', () => {
    const [chin] = [at('ibug_08')];
    assert.ok(deepest([4, chin[1] - 12], [4, chin[1] - 50]) > 70, 'no ring around the neck');
    for (const side of [-1, 1]) {
      const slopes = [-5, 5].map((x) => read(side * 13 + x, chin[1] - 34)[0] - 127.5);
      assert.ok(slopes[0] > 8 && slopes[1] < -8, `a band stands out: ${slopes}`);
    }
    assert.ok(frame[1] < chin[1] - 55, 'the map ends above the neck');
    const edge = map.rgba.filter((_, o) => o % 4 === 2 && o < 4 * map.size);
    assert.ok(Math.max(...edge) < 3, 'a line is cut off');
  });

  test('freckles are thickest on nose and cheeks', () => {
    const dots = (/** @type {number} */ x, /** @type {number} */ y) => {
      let sum = 0;
      for (let i = -12; i <= 12; i += 0.35) for (let j = -8; j <= 8; j += 0.35) sum += read(x + i, y + j)[3];
      return sum;
    };
    const [tip, chin, eye] = [at('ibug_30'), at('ibug_08'), at('ibug_45')];
    assert.ok(dots(eye[0] * 0.8, 0.45 * eye[1] + 0.55 * tip[1]) > 2 * dots(0, chin[1] + 9));
    assert.ok(dots(0, tip[1] + 9) > 2 * dots(0, chin[1] + 9));
  });

  test('an expression folds its own, on its own side', () => {
    assert.deepEqual(foldsOf({}, 'Left'), { folds: [0, 0, 0, 0], smooths: 0 });
    assert.deepEqual(foldsOf({ mouthSmileLeft: 1, browDownLeft: 1 }, 'Right'), foldsOf({}, 'Right'));
    const smile = foldsOf({ mouthSmileLeft: 0.5 }, 'Left');
    assert.ok(smile.folds[0] === 0 && smile.folds[1] === 0 && smile.folds[2] > 0 && smile.folds[3] > 0 && smile.smooths === 0.5);
    assert.ok(foldsOf({ browInnerUp: 1 }, 'Left').folds[0] === foldsOf({ browInnerUp: 1 }, 'Right').folds[0]);
    assert.ok(foldsOf({ browDownRight: 1 }, 'Right').folds[1] === 1);
  });

  test('are on the skin when their map has come, and until then it is smooth', () => {
    const picture = { map: new Texture(), frame: [0, 0, 1, 1] };
    for (const [told, how] of /** @type {[string, (skin: ReturnType<typeof createSkin>) => void][]} */ ([
      ['lines', (skin) => skin.paint(pigments(new Color(0.6, 0.4, 0.3), { lines: 0.8 }))],
      ['an expression', (skin) => skin.fold({ mouthSmileLeft: 1 })],
    ])) {
      const skin = createSkin({ pores: picture.map, face: picture, brows: picture, depth: 0, landmarks });
      /** @type {((work: object) => void) | undefined} */
      let done;
      /** @type {string[]} */
      const asked = [];
      skin.refine((_, then) => ((done = then), { soon: (what) => void asked.push(what), now() {}, dispose() {} }), () => {});
      how(skin);
      const { creased, lineMap, strandMap } = skin.uniforms;
      assert.deepEqual([asked, skin.isUnfinished, creased.value], [['lines'], true, 0], told);
      done?.({ lines: { map, frame } });
      assert.ok(creased.value > 0 && lineMap.value.image.data === map.rgba && !skin.isUnfinished, told);
      // Nor does hair lean that has not come.
      assert.deepEqual([...strandMap.value.image.data.subarray(1, 3)], [128, 128]);
    }
  });

  test('every place of the face has its share of them', () => {
    const folding = foldingOf(rest, landmarks);
    assert.ok(folding.every((value) => value >= -1 && value <= 1));
    const near = (/** @type {[number, number, number]} */ [x, y, z]) => {
      let [nearest, least] = [0, Infinity];
      for (let v = 0; v < rest.length / 3; v++) {
        const away = Math.hypot(rest[3 * v] - x, rest[3 * v + 1] - y, rest[3 * v + 2] - z);
        if (away < least) [nearest, least] = [v, away];
      }
      return folding.subarray(4 * nearest, 4 * nearest + 4);
    };
    assert.ok(near(at('metopion'))[0] > 0.9 && near(at('metopion'))[3] === 0);
    const [x, y, z] = [0, 1, 2].map((k) => (at('ibug_21')[k] + at('ibug_22')[k]) / 2);
    assert.ok(near([x, y + 3, z])[1] > 0.9, 'between the brows');
    assert.ok(near(at('ibug_36'))[2] > 0.9 && near(at('ibug_45'))[2] > 0.9);
    assert.ok(near(at('ibug_33'))[3] > 0.3 && near(at('ibug_08'))[3] === -1);
    // A model without these points has no lines to fold.
    assert.ok(foldingOf(rest, new Map()).every((value) => value === 0));
  });
});
