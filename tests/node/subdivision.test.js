// The finer mesh that a head is drawn from: on a ball, whose curves are known, and on the head of the committed model.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { load } from '../../pkg/index.js';
import { IcosahedronGeometry } from '../../www/node_modules/three/build/three.module.js';
import { subdivide } from '../../www/src/head/subdivision.js';

/** How often each edge of some triangles is used. @param {ArrayLike<number>} index @param {(corner: number) => unknown} of a corner */
function edges(index, of = (corner) => corner) {
  const uses = new Map();
  for (let t = 0; t < index.length; t++) {
    const key = [of(index[t]), of(index[t % 3 === 2 ? t - 2 : t + 1])].sort().join(' to ');
    uses.set(key, (uses.get(key) ?? 0) + 1);
  }
  return uses;
}

/** A ball without seams, of a radius in mm. @param {number} radius @param {number} detail */
function ball(radius, detail) {
  const { array } = new IcosahedronGeometry(1, detail).getAttribute('position');
  const known = new Map();
  const normals = [];
  const index = [];
  for (let i = 0; i < array.length; i += 3) {
    const key = Array.from(array.subarray(i, i + 3), (x) => Math.round(1e4 * x)).join();
    if (!known.has(key)) {
      known.set(key, known.size);
      normals.push(...array.subarray(i, i + 3));
    }
    index.push(known.get(key));
  }
  return { index: Uint32Array.from(index), normals: Float32Array.from(normals), positions: Float32Array.from(normals, (x) => radius * x), vertices: Uint32Array.from({ length: known.size }, (_, v) => v) };
}

/** Positions and normals of all corners. @param {ReturnType<typeof subdivide>} finer @param {Uint32Array} vertices @param {Float32Array} rest @param {Float32Array} restNormals */
function curved(finer, vertices, rest, restNormals) {
  const [positions, normals] = [rest, restNormals].map((values) => {
    const array = new Float32Array(3 * finer.corners);
    vertices.forEach((v, corner) => array.set(values.subarray(3 * v, 3 * v + 3), 3 * corner));
    return array;
  });
  finer.curve(positions, normals, 0, Math.max(...vertices) + 1);
  return { positions, normals };
}

test('a ball of the size of a head comes out round, and closed', () => {
  const radius = 95;
  const { index, normals, positions, vertices } = ball(radius, 8);
  const finer = subdivide(index, vertices, positions, normals, new Uint8Array(vertices.length));
  const shown = curved(finer, vertices, positions, normals);
  assert.ok(finer.corners > vertices.length && finer.index.length > index.length);
  for (const [edge, uses] of edges(finer.index)) assert.equal(uses, 2, `edge ${edge}`);
  // Euler's: as many handles as before, none.
  assert.equal(finer.corners - edges(finer.index).size + finer.index.length / 3, 2);
  assert.deepEqual(shown.positions.slice(0, positions.length), positions);
  /** How far the middles of edges lie under the ball, at most, mm. @param {ArrayLike<number>} index @param {Float32Array} p */
  const under = (index, p) => {
    let most = 0;
    for (let t = 0; t < index.length; t++) {
      const [a, b] = [index[t], index[t % 3 === 2 ? t - 2 : t + 1]];
      most = Math.max(most, radius - Math.hypot(...[0, 1, 2].map((k) => (p[3 * a + k] + p[3 * b + k]) / 2)));
    }
    return most;
  };
  for (let corner = 0; corner < finer.corners; corner++) {
    const off = Math.hypot(...shown.positions.subarray(3 * corner, 3 * corner + 3)) - radius;
    // The cubic is not the circle, by an eighth of the edge's angle to the fourth power, in radii.
    assert.ok(Math.abs(off) < 2e-3, `corner ${corner} is ${off} mm off the ball`);
  }
  const [before, after] = [under(index, positions), under(finer.index, shown.positions)];
  assert.ok(before > 0.15 && after < 0.11, `edges lie ${before} mm under it, and ${after} mm`);
});

test('on the head, edges of lips and lids stay, seams stay shut, and what moves is curved anew as all is', async () => {
  const model = await load(await readFile(new URL('../../www/public/model.phiz', import.meta.url)));
  const { uvVertices: vertices } = model;
  const face = model.face();
  const [rest, restNormals] = [face.positions.slice(), face.normals.slice()];
  const keep = new Uint8Array(model.vertexCount);
  const index = [];
  for (const { name, first, count } of model.parts) {
    if (/eyeball/.test(name)) continue;
    const corners = model.triangles.subarray(3 * first, 3 * (first + count));
    index.push(...corners);
    if (/cavit/.test(name)) for (const corner of corners) keep[vertices[corner]] = 1;
  }
  const finer = subdivide(Uint32Array.from(index), vertices, rest, restNormals, keep);
  assert.ok(finer.corners > 1.05 * vertices.length && finer.corners < 1.3 * vertices.length, `${finer.corners} corners, of ${vertices.length}`);

  // Where corners are two because the texture ends, the same is in both places.
  const { positions, normals } = curved(finer, vertices, rest, restNormals);
  const place = (/** @type {number} */ corner) => positions.subarray(3 * corner, 3 * corner + 3).join();
  const before = edges(index, place);
  const gaps = [...edges(finer.index, place)].filter(([edge, uses]) => uses !== 2 && before.get(edge) !== uses);
  // What was open is, in two parts where it was split: the neck's end alone is not shut.
  const cut = [...before].filter(([, uses]) => uses === 1).length;
  assert.ok(gaps.length < 2 * cut, `${gaps.length} of ${cut}`);
  for (const [edge, uses] of gaps) assert.ok(uses === 1 && edge.split(' to ').every((end) => Number(end.split(',')[1]) < -100), `${edge}: ${uses}`);
  for (let corner = vertices.length; corner < finer.corners; corner++) assert.ok(finer.rootsOf(corner).every((v) => !keep[v]));

  // Another face, of which only a part was taken over: as if all had been.
  for (const [i, value] of [0.98, 0.05, 0.9].entries()) face.set(`nose ${i + 1}`, value);
  face.set('mouth 1', 0.02);
  const moved = [];
  for (let v = 0; v < model.vertexCount; v++) {
    if ([0, 1, 2].some((k) => face.positions[3 * v + k] !== rest[3 * v + k] || face.normals[3 * v + k] !== restNormals[3 * v + k])) moved.push(v);
  }
  const whole = curved(finer, vertices, face.positions, face.normals);
  vertices.forEach((v, corner) => {
    positions.set(face.positions.subarray(3 * v, 3 * v + 3), 3 * corner);
    normals.set(face.normals.subarray(3 * v, 3 * v + 3), 3 * corner);
  });
  finer.curve(positions, normals, moved[0], moved[moved.length - 1] + 1);
  assert.ok(moved.length > 1000 && moved.length < model.vertexCount / 2, `${moved.length} vertices moved`);
  assert.deepEqual(positions, whole.positions);
  assert.deepEqual(normals, whole.normals);
});
