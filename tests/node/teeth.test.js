// The teeth that the page draws, on random people: nothing of them or of the gums comes out through the skin.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { describe, test } from 'node:test';
import { Vector3 } from '../../www/node_modules/three/build/three.module.js';
import { load } from '../../pkg/index.js';
import { atRest } from '../../www/src/head/head.js';
import { createTeeth } from '../../www/src/head/teeth.js';

const file = (/** @type {string} */ name) => readFileSync(new URL(`../../www/public/${name}.phiz`, import.meta.url));
const model = await load(file('model'));
await model.loadExpressions(file('expressions'));
const { positions: rest, landmarks } = atRest(model, model.face());

/** @param {string} name of parts */
const corners = (name) =>
  model.parts.filter((part) => part.name === name).flatMap(({ first, count }) => Array.from(model.triangles.subarray(3 * first, 3 * (first + count)), (corner) => model.uvVertices[corner]));
const skin = corners('skin');
const vertexOf = (/** @type {string} */ name) => (model.landmarks.find((one) => one.name === name)?.stencil ?? []).reduce((best, entry) => (entry[1] > best[1] ? entry : best))[0];
const teeth = createTeeth(rest, landmarks, [...new Set(corners('mouth cavity'))], vertexOf);

/** How far in front the skin is about the mouth, by column and row of a millimetre. @param {Float32Array} positions */
function front(positions) {
  const lip = vertexOf('ibug_66');
  const [left, low, side] = [positions[3 * lip] - 60, positions[3 * lip + 1] - 80, 140];
  const depth = new Float32Array(side * side).fill(-Infinity);
  for (let t = 0; t < skin.length; t += 3) {
    const [a, b, c] = skin.slice(t, t + 3).map((v) => [positions[3 * v] - left, positions[3 * v + 1] - low, positions[3 * v + 2]]);
    const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    // What faces away is behind.
    if (area <= 0) continue;
    const within = (/** @type {number} */ k) => [Math.max(0, Math.ceil(Math.min(a[k], b[k], c[k]))), Math.min(side - 1, Math.floor(Math.max(a[k], b[k], c[k])))];
    const [[i0, i1], [j0, j1]] = [within(0), within(1)];
    for (let j = j0; j <= j1; j++) {
      for (let i = i0; i <= i1; i++) {
        const u = ((b[0] - i) * (c[1] - j) - (b[1] - j) * (c[0] - i)) / area;
        const v = ((c[0] - i) * (a[1] - j) - (c[1] - j) * (a[0] - i)) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        depth[j * side + i] = Math.max(depth[j * side + i], u * a[2] + v * b[2] + (1 - u - v) * c[2]);
      }
    }
  }
  return (/** @type {Vector3} */ { x, y }) => {
    const [i, j] = [Math.round(x - left), Math.round(y - low)];
    return i < 0 || j < 0 || i >= side || j >= side ? Infinity : depth[j * side + i];
  };
}

/** How far each row comes out through the skin at most, mm. @param {import('phiz').Face} face @param {Record<string, number>} expression */
function out(face, expression) {
  const neutral = face.positions.slice();
  face.expression = expression;
  const positions = face.positions.slice();
  const shifts = Float32Array.from(teeth.anchors.flatMap((v) => [0, 1, 2].map((k) => positions[3 * v + k] - neutral[3 * v + k])));
  const skinAt = front(positions);
  const point = new Vector3();
  return teeth.at(positions, shifts).map((place, row) => {
    const { array } = teeth.meshes[row].geometry.getAttribute('position');
    let most = -Infinity;
    for (let o = 0; o < array.length; o += 3) {
      point.fromArray(array, o).applyMatrix4(place);
      const there = skinAt(point);
      if (there > -Infinity) most = Math.max(most, point.z - there);
    }
    return most;
  });
}

describe('teeth and gums', () => {
  // What opens the mouth is left out: there they are seen, and before a lip that is drawn in.
  for (const expression of [{}, { mouthSmileLeft: 1, mouthSmileRight: 1 }, { mouthPucker: 1 }, { mouthFunnel: 1 }, { mouthShrugLower: 1 }]) {
    test(`stay under the skin of a hundred people, ${Object.keys(expression)[0] ?? 'at rest'}`, () => {
      for (let seed = 1; seed <= 100; seed++) {
        const face = model.face();
        face.randomize({ seed });
        const most = out(face, expression);
        face.free();
        for (const [row, mm] of most.entries()) assert.ok(mm < 0.5, `face ${seed}: the ${row ? 'lower' : 'upper'} row is ${mm.toFixed(1)} mm out of the skin`);
      }
    });
  }
});
