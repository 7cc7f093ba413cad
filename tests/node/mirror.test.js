// Faces in a mirror, as the page has them: by their coefficients.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { load, prepare } from '../../pkg/index.js';
import { mirroredColouring, mirroredExpression, mirrorOf } from '../../www/src/editing/mirror.js';

const root = new URL('../../', import.meta.url);
await prepare({ build: 'simd', wasm: await readFile(new URL('pkg/simd/phiz_bg.wasm', root)) });

/** Each spot's distance from the mirror image of its counterpart, mm. */
function apart(face, positions = face.positions) {
  const { mirror } = face.model;
  return Array.from(mirror, (other, v) =>
    Math.hypot(...[0, 1, 2].map((axis) => positions[3 * v + axis] - (axis === 0 ? -1 : 1) * face.positions[3 * other + axis])),
  );
}

for (const name of ['model', 'synthetic']) {
  describe(`the mirror of ${name}.phiz`, async () => {
    const model = await load(await readFile(new URL(`www/public/${name}.phiz`, root)));
    const mirror = await mirrorOf(model, async () => {});
    const face = model.face();
    const other = model.face();
    const random = (seed) => {
      face.reset();
      face.randomize({ seed });
      // With edits of one side, which a random face has none of.
      face.set('left eye length', 0.8);
      face.set('mouth lateral position', 0.3);
    };

    test('has the image of each spot where the other side is', () => {
      for (const seed of [1, 2, 3]) {
        random(seed);
        other.coefficients = mirror.image(face.coefficients);
        // Modes are mirrored to the step; what follows a feature, and the edits of one eye, in steps of 0.02 mm at most.
        assert.ok(Math.max(...apart(other, face.positions)) < 0.08, `${Math.max(...apart(other, face.positions))} mm`);
        assert.deepEqual(mirror.image(mirror.image(face.coefficients)), face.coefficients);
      }
    });

    test('makes sides alike, and more unlike by as much as is asked for', () => {
      const features = Array.from(model.regionOf, (region) => model.regionGroups[region] !== null);
      for (const seed of [4, 5, 6]) {
        random(seed);
        const { coefficients } = face;
        const differ = mirror.differ(coefficients);
        const squares = apart(face).filter((_, v) => features[v]).map((mm) => mm * mm);
        const rms = Math.sqrt(squares.reduce((sum, x) => sum + x, 0) / squares.length);
        // A fourth of the vertices stands for all.
        assert.ok(Math.abs(differ / rms - 1) < 0.05, `${differ} mm, and of all vertices ${rms}`);
        assert.ok(differ > 0.3);
        other.coefficients = mirror.withSides(coefficients, 0);
        assert.ok(Math.max(...apart(other)) < 0.05, `${Math.max(...apart(other))} mm`);
        assert.ok(mirror.differ(mirror.withSides(coefficients, 0)) < 1e-6);
        for (const times of [0.5, 2]) assert.ok(Math.abs(mirror.differ(mirror.withSides(coefficients, times)) / differ - times) < 1e-4);
        // What both sides have in common stays.
        const mean = (of) => of.map((x, k) => (x + mirror.image(of)[k]) / 2);
        const [now, then] = [mean(mirror.withSides(coefficients, 2)), mean(coefficients)];
        assert.ok(now.every((x, k) => Math.abs(x - then[k]) < 1e-5));
      }
    });
  });
}

test('an expression changes its sides, and so do looks', () => {
  const shown = { mouthSmileLeft: 0.4, jawRight: 0.2, eyeLookInLeft: 0.3, jawOpen: 0.5 };
  assert.deepEqual(mirroredExpression(shown), { mouthSmileRight: 0.4, jawLeft: 0.2, eyeLookInRight: 0.3, jawOpen: 0.5 });
  assert.deepEqual(mirroredExpression(mirroredExpression(shown)), shown);
  const looks = { parting: 0.2, length: 0.8 };
  assert.deepEqual(mirroredColouring(looks), { parting: 0.8, length: 0.8 });
  assert.deepEqual(mirroredColouring(mirroredColouring({ length: 0.8 })), { length: 0.8 });
});
