// A model's head that glasses are put on.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { load, prepare } from '../../pkg/index.js';
import { createGlasses } from '../../www/src/glasses/glasses.js';
import { growth } from '../../www/src/hair/growth.js';
import { eyeballsOn, eyeVerticesOf } from '../../www/src/head/eyeballs.js';
import { createLashes } from '../../www/src/head/lashes.js';

const { Color } = await import('../../www/node_modules/three/build/three.module.js');

const root = new URL('../../', import.meta.url);
await prepare({ build: 'simd', wasm: await readFile(new URL('pkg/simd/phiz_bg.wasm', root)) });

/** @param {string} name of a model */
export async function wearer(name) {
  const model = await load(await readFile(new URL(`www/public/${name}.phiz`, root)));
  const face = model.face();
  const [rest, normals] = [face.positions.slice(), face.normals.slice()];
  face.free();
  const corners = model.uvVertices;
  const trianglesOf = (/** @type {RegExp} */ which) => model.parts.filter((part) => which.test(part.name)).flatMap(({ first, count }) => Array.from(model.triangles.subarray(3 * first, 3 * (first + count)), (corner) => corners[corner]));
  const verticesOf = (/** @type {RegExp} */ which) => [...new Set(trianglesOf(which))];
  const balls = eyeVerticesOf(model, rest);
  const eyesOf = (/** @type {Float32Array} */ positions) => eyeballsOn(balls, positions);
  const landmark = (/** @type {Float32Array} */ positions, /** @type {string} */ called) => {
    const { stencil } = model.landmarks.find((one) => one.name === called);
    return [0, 1, 2].map((k) => stencil.reduce((sum, [v, w]) => sum + w * positions[3 * v + k], 0));
  };
  const at = new Map(model.landmarks.map(({ name: called }) => [called, landmark(rest, called)]));
  const scalp = growth(rest, at, verticesOf(/cavit/), model.triangles.map((corner) => corners[corner])).scalp;
  const vertexOf = (/** @type {string} */ called) => model.landmarks.find((one) => one.name === called).stencil.reduce((best, one) => (one[1] > best[1] ? one : best))[0];
  const lashes = createLashes(Uint32Array.from(trianglesOf(/^skin$|cavities/)), rest, vertexOf);
  const glasses = createGlasses(
    {
      rest,
      normals,
      skin: verticesOf(/^skin$/),
      mirror: model.mirror,
      scalp,
      at,
      vertexOf,
      eyes: eyesOf(rest),
    },
    { heatStrength: { value: 0 } },
  );
  /** @param {import('../../www/src/head/colouring.js').Colouring} looks @param {Float32Array} positions */
  const on = (looks, positions, lift = 0) => {
    glasses.paint(looks, { skin: new Color(0.5, 0.4, 0.3), lift });
    const placed = glasses.on(positions, eyesOf(positions));
    assert.ok(placed);
    return placed;
  };
  return { model, rest, normals, skin: trianglesOf(/^skin$/), eyesOf, landmark, lashes, glasses, on };
}
