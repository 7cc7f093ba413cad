// Where the page lets hair and beard grow, on the heads of the committed models.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { load } from '../../pkg/index.js';
import { growth } from '../../www/src/hair/growth.js';

for (const name of ['model', 'synthetic']) {
  describe(`hair of ${name}.phiz`, async () => {
    const model = await load(await readFile(new URL(`../../www/public/${name}.phiz`, import.meta.url)));
    const face = model.face();
    const rest = face.positions.slice();
    const corners = model.uvVertices;
    const of = (/** @type {Float32Array} */ values, /** @type {string} */ landmark) => {
      const { stencil } = model.landmarks.find((one) => one.name === landmark);
      return stencil.reduce((sum, [vertex, weight]) => sum + weight * values[vertex], 0);
    };
    const landmarks = new Map(
      model.landmarks.map((landmark) => [landmark.name, [0, 1, 2].map((k) => landmark.stencil.reduce((sum, [v, w]) => sum + w * rest[3 * v + k], 0))]),
    );
    const hollow = model.parts
      .filter((part) => /cavit/.test(part.name))
      .flatMap(({ first, count }) => [...model.triangles.subarray(3 * first, 3 * (first + count))].map((corner) => corners[corner]));
    const triangles = model.triangles.map((corner) => corners[corner]);
    const { scalp, beard } = growth(rest, landmarks, hollow, triangles);

    test('grows on the crown and the chin, and not on the face between, the ears or the nape', () => {
      // A quarter of the margin is 5 mm.
      for (const [values, there, bare] of [
        [scalp, ['vertex'], ['metopion', 'glabella', 'ibug_17', 'ibug_26', 'pogonion', 'ibug_30', 'tragion left', 'tragion right']],
        [beard, ['pogonion', 'supramentale', 'gonion left', 'gonion right'], ['vertex', 'metopion', 'ibug_30', 'ibug_36', 'ibug_45', 'cheek left', 'cheek right']],
      ]) {
        for (const landmark of there) assert.ok(of(values, landmark) > 0.25, `${landmark}: ${of(values, landmark)}`);
        for (const landmark of bare) assert.ok(of(values, landmark) < -0.25, `${landmark}: ${of(values, landmark)}`);
      }
      for (const part of ['lower helix', 'intertragic notch', 'subaurale', 'postaurale']) {
        for (const side of ['left', 'right']) {
          for (const values of [scalp, beard]) assert.ok(of(values, `${part} ${side}`) < 0, `${part} ${side}: ${of(values, `${part} ${side}`)}`);
        }
      }
      // There are no bald spots above and behind the ears.
      const [, top] = landmarks.get('superaurale left');
      const [, , before] = landmarks.get('tragion left');
      for (let v = 0; v < model.vertexCount; v++) {
        if (rest[3 * v + 1] > top + 5 && rest[3 * v + 2] < before) assert.ok(scalp[v] > 0.5, `${rest.slice(3 * v, 3 * v + 3)}: ${scalp[v]}`);
      }
      // The hairline's midpoint is on it.
      assert.ok(Math.abs(of(scalp, 'trichion')) < 0.15, `trichion: ${of(scalp, 'trichion')}`);
    });

    test('is as wide on one side as on the other', () => {
      let most = 0;
      model.mirror.forEach((other, v) => {
        most = Math.max(most, Math.abs(scalp[v] - scalp[other]), Math.abs(beard[v] - beard[other]));
      });
      // Heads are symmetric but for some tenths of a millimetre, of 20; around ears that counts five times.
      assert.ok(most < 0.08, `${most}`);
    });

    test('a head without the landmarks has neither', () => {
      landmarks.delete('trichion');
      const none = growth(rest, landmarks, hollow, triangles);
      assert.ok([...none.scalp, ...none.beard].every((value) => value === -1));
    });
  });
}
