// Where the page takes skin for the inside of a nostril, on the heads of the committed models.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { load } from '../../pkg/index.js';
import { nostrils } from '../../www/src/head/nostrils.js';

for (const name of ['model', 'synthetic', 'head']) {
  test(`nostrils of ${name}.phiz are on both sides, between wings and septum, and nothing else is one`, async () => {
    const model = await load(await readFile(new URL(`../../www/public/${name}.phiz`, import.meta.url)));
    const rest = model.face().positions.slice();
    const of = (/** @type {ArrayLike<number>} */ values, /** @type {string} */ landmark, size = 1, k = 0) =>
      model.landmarks.find((one) => one.name === landmark).stencil.reduce((sum, [v, w]) => sum + w * values[size * v + k], 0);
    const at = (/** @type {string} */ landmark) => /** @type {[number, number, number]} */ ([0, 1, 2].map((k) => of(rest, landmark, 3, k)));
    const greens = model.colours.filter((_, i) => i % 3 === 1).sort();
    const skin = model.parts.find((part) => part.name === 'skin');
    const outside = model.triangles.subarray(3 * skin.first, 3 * (skin.first + skin.count)).map((corner) => model.uvVertices[corner]);
    const deep = nostrils(model, outside, rest, at('ibug_33'), greens[greens.length >> 1] / 255);

    const [wings, tip, base] = [['alare right', 'alare left'].map((landmark) => at(landmark)[0]), at('ibug_30'), at('ibug_33')];
    let [left, right] = [0, 0];
    for (const [v, depth] of deep.entries()) {
      assert.equal(deep[model.mirror[v]], depth);
      if (depth === 0) continue;
      const [x, y, z] = rest.subarray(3 * v, 3 * v + 3);
      const where = `${name}: ${[x, y, z].map((mm) => mm.toFixed(1))}`;
      assert.ok(x > wings[0] && x < wings[1] && y < tip[1] + 2 && z < tip[2] - 3 && z > base[2] - 20, where);
      if (depth > 0.8) {
        // Nostrils are some 6 mm wide, beside a septum as wide.
        assert.ok(Math.abs(x) > 1.5, where);
        if (x < 0) right++;
        else left++;
      }
    }
    // An area of a square centimetre has so many vertices there.
    assert.ok(left >= 12 && right === left, `${name}: ${left} and ${right} vertices deep inside`);
    for (const landmark of ['ibug_30', 'ibug_31', 'ibug_33', 'ibug_35', 'ibug_51', 'cheek left']) assert.ok(of(deep, landmark) < 0.1, `${name}: ${landmark} ${of(deep, landmark)}`);
  });
}

test('without a base of the nose, or without colours, nothing is a nostril', () => {
  const model = { colours: new Uint8Array(6), mirror: Uint32Array.of(1, 0) };
  assert.deepEqual([...nostrils(model, Uint32Array.of(0, 1), new Float32Array(6), undefined, 0.5)], [0, 0]);
  assert.deepEqual([...nostrils(model, Uint32Array.of(0, 1), new Float32Array(6), [0, 0, 0], 0)], [0, 0]);
});
