import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { load } from '../../pkg/index.js';
import { createAngles } from '../../www/src/faces/angles.js';
import { contours } from '../../www/src/stage/outline.js';

/** A sphere of so many rings, with a normal each vertex. @param {number} radius mm @param {number} rings */
function sphere(radius, rings) {
  const around = 2 * rings;
  const normals = [];
  const triangles = [];
  for (let i = 0; i <= rings; i++) {
    const [up, out] = [Math.cos((Math.PI * i) / rings), Math.sin((Math.PI * i) / rings)];
    for (let k = 0; k < around; k++) normals.push(out * Math.sin((2 * Math.PI * k) / around), up, out * Math.cos((2 * Math.PI * k) / around));
  }
  for (let i = 0; i < rings; i++) {
    for (let k = 0; k < around; k++) {
      const [a, b, c, d] = [i * around + k, i * around + ((k + 1) % around), (i + 1) * around + k, (i + 1) * around + ((k + 1) % around)];
      triangles.push(a, c, b, b, c, d);
    }
  }
  return { positions: normals.map((n) => radius * n), normals, triangles };
}

describe('the contours of a surface', () => {
  test('of a sphere are the circle that the eye sees, whatever the triangles', () => {
    const [radius, away] = [50, 400];
    const segments = contours(sphere(radius, 24), { x: 0, y: 0, z: away });
    // Lines from the eye touch a sphere on a circle in front of its middle.
    const ahead = radius ** 2 / away;
    const seen = Math.sqrt(radius ** 2 - ahead ** 2);
    let length = 0;
    for (let i = 0; i < segments.length; i += 6) {
      for (const at of [i, i + 3]) {
        const [x, y, z] = segments.slice(at, at + 3);
        // The middle of a diagonal of 9.3 mm is 0.22 mm within.
        assert.ok(Math.abs(Math.hypot(x, y, z) - radius) < 0.22 && Math.abs(z - ahead) < 0.2, `${[x, y, z]}`);
      }
      length += Math.hypot(...[0, 1, 2].map((axis) => segments[i + axis] - segments[i + 3 + axis]));
    }
    assert.ok(Math.abs(length / (2 * Math.PI * seen) - 1) < 0.01, `${length} mm of ${2 * Math.PI * seen}`);
  });

  test('end where they are shorter than what anybody sees', () => {
    const [large, small] = [sphere(50, 24), sphere(1, 24)];
    const first = large.positions.length / 3;
    const both = {
      positions: [...large.positions, ...small.positions.map((value, i) => value + (i % 3 === 0 ? 100 : 0))],
      normals: [...large.normals, ...small.normals],
      triangles: [...large.triangles, ...small.triangles.map((v) => v + first)],
    };
    const eye = { x: 0, y: 0, z: 400 };
    assert.deepEqual(contours(both, eye), contours(large, eye));
    assert.ok(contours(both, eye, 1).length > contours(large, eye).length);
  });
});

describe('angles of the profile', () => {
  /** A profile of points in front of an axis: a landmark is a vertex. @param {Record<string, [z: number, y: number]>} points @param {[z: number, y: number][]} [more] */
  function profile(points, more = []) {
    const all = [...Object.values(points), ...more];
    return {
      landmarks: Object.keys(points).map((name, v) => ({ name, stencil: /** @type {[number, number][]} */ ([[v, 1]]) })),
      positions: Float32Array.from(all.flatMap(([z, y]) => [0, y, z])),
    };
  }
  const POINTS = /** @type {Record<string, [number, number]>} */ ({
    glabella: [20, 20],
    ibug_27: [20, 0],
    ibug_30: [50, -30],
    ibug_33: [20, -30],
    ibug_51: [20, -50],
    ibug_57: [20, -60],
    supramentale: [10, -70],
    pogonion: [20, -80],
  });

  test('are what is drawn', () => {
    // The columella rises from subnasale by 45 degrees, and then goes on to the tip.
    const { landmarks, positions } = profile({ ...POINTS, ibug_33: [20, -50], ibug_51: [20, -70] }, [[25, -45], [30, -40], [36, -34]]);
    const angles = createAngles(landmarks, positions);
    assert.deepEqual(Object.fromEntries(angles.names.map((name, i) => [name, Math.round(1000 * angles.of(positions)[i]) / 1000])), {
      'nasofrontal angle': 135,
      'nasofacial angle': 45,
      'nasomental angle': Math.round((1000 * (Math.atan2(30, 30) + Math.atan2(50, 30)) * 180) / Math.PI) / 1000,
      'nasolabial angle': 135,
      'mentolabial angle': 90,
      'facial convexity': 180,
    });
  });

  test('are those that a model has the landmarks for, and a middle', () => {
    const { landmarks, positions } = profile(POINTS);
    assert.ok(!createAngles(landmarks, positions).names.includes('nasolabial angle'), 'no vertices are between the tip and subnasale');
    assert.deepEqual(createAngles(landmarks.filter(({ name }) => name !== 'pogonion'), positions).names, ['nasofrontal angle']);
    assert.deepEqual(createAngles([], positions).names, []);
  });

  test('of people are what anthropometry finds', async () => {
    const model = await load(await readFile(new URL('../../www/public/model.phiz', import.meta.url)));
    const face = model.face();
    const angles = createAngles(model.landmarks, face.positions.slice());
    const sums = angles.names.map(() => 0);
    const count = 100;
    for (let seed = 0; seed < count; seed++) {
      face.randomize({ seed });
      for (const [i, angle] of angles.of(face.positions).entries()) sums[i] += angle / count;
    }
    // Means of adults of both sexes and several origins lie there (Farkas 1994; Legan and Burstone 1980; Powell and Humphreys 1984).
    const usual = {
      'nasofrontal angle': [125, 150],
      'nasofacial angle': [28, 40],
      'nasomental angle': [120, 135],
      'nasolabial angle': [90, 115],
      'mentolabial angle': [110, 145],
      'facial convexity': [160, 175],
    };
    assert.deepEqual(angles.names, Object.keys(usual));
    for (const [i, name] of angles.names.entries()) assert.ok(sums[i] > usual[name][0] && sums[i] < usual[name][1], `${name}: ${sums[i]}`);
    // Turned in the plane of the profile they stay; a mouth that opens does not ask for others.
    const turned = face.positions.map((value, i, all) => [value, 0.8 * all[i] + 0.6 * all[i + 1], 0.8 * all[i] - 0.6 * all[i - 1]][i % 3]);
    const [here, there] = [angles.of(face.positions), angles.of(turned)];
    for (const [i, angle] of here.entries()) assert.ok(Math.abs(angle - there[i]) < 1e-3, `${angles.names[i]}: ${angle}, turned ${there[i]}`);
    face.free();
    model.free();
  });
});
