// One slider event, from a coefficient to positions and normals, beside the usual way of doing it
// in JavaScript. Every contender does the same work on the committed model in this one run; they
// take turns, so that a slow moment of the machine falls on all of them.
//
//     node tests/bench/slider.js        (after ./build.sh build; ./build.sh bench does both)
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { cpus } from 'node:os';

import * as three from '../../www/node_modules/three/build/three.module.js';
import { load } from '../../pkg/index.js';

const ROUNDS = 15;
const EVENTS = 20;

const bytes = await readFile(new URL('../../www/public/model.phiz', import.meta.url));

/** A wasm contender: the package. */
async function packaged(build) {
  const model = await load(bytes, { build });
  const face = model.face();
  return {
    model,
    event: (control, value) => face.set(control, value),
    result: () => ({ positions: face.positions.slice(), normals: face.normals.slice() }),
  };
}

/**
 * The modes as a page without phiz would have them: one dense f32 displacement a coefficient,
 * measured from the model itself, since positions are linear in the coefficients.
 */
function denseModes(model) {
  const face = model.face();
  const zero = new Float32Array(face.coefficients.length);
  face.coefficients = zero;
  const mean = face.positions.slice();
  const modes = Array.from(zero, (_, i) => {
    const unit = zero.slice();
    unit[i] = 1;
    face.coefficients = unit;
    return face.positions.map((x, at) => x - mean[at]);
  });
  face.free();
  return { mean, modes };
}

/** positions += weight * mode: the inner loop of every JavaScript contender. */
function addMode(positions, mode, weight) {
  for (let i = 0; i < positions.length; i++) positions[i] += weight * mode[i];
}

/**
 * Plain JavaScript on typed arrays, and three.js's normals: what a page does today. `resum` sums
 * all modes again on each event, as phiz does for what it touches; without, only the modes whose
 * coefficient changed are added, which is faster and drifts.
 */
function plain(model, { mean, modes }, resum, normalsToo) {
  const coefficients = new Float32Array(modes.length);
  const geometry = new three.BufferGeometry();
  const positions = new Float32Array(mean.length);
  geometry.setAttribute('position', new three.BufferAttribute(positions, 3));
  const { triangles, uvVertices } = model;
  geometry.setIndex(new three.BufferAttribute(triangles.map((corner) => uvVertices[corner]), 1));
  geometry.computeVertexNormals();
  positions.set(mean);
  return {
    // Where the slider puts its coefficients was asked of the model, outside of the clock.
    event(control, wanted) {
      if (resum) positions.set(mean);
      for (let k = 0; k < modes.length; k++) {
        const change = resum ? wanted[k] : wanted[k] - coefficients[k];
        if (change !== 0) addMode(positions, modes[k], change);
      }
      coefficients.set(wanted);
      if (normalsToo) {
        geometry.attributes.position.needsUpdate = true;
        geometry.computeVertexNormals();
      }
    },
    result: () => ({
      positions: positions.slice(),
      normals: geometry.attributes.normal.array.slice(),
    }),
  };
}

const simd = await packaged('simd');
const scalar = await packaged('scalar');
const dense = denseModes(simd.model);
const contenders = {
  'phiz, wasm simd': simd,
  'phiz, wasm scalar': scalar,
  'plain JS + three.js normals': plain(simd.model, dense, true, true),
  'plain JS, positions only': plain(simd.model, dense, true, false),
  'JS, changed modes + three.js': plain(simd.model, dense, false, true),
};

// Sliders of each feature in turn; a page moves one to many places.
const { controls } = simd.model;
const groups = [...new Set(controls.map((c) => c.group))];
const picked = groups.map((group) => controls.find((c) => c.group === group));
const events = picked.map((control) => {
  const face = simd.model.face();
  return Array.from({ length: EVENTS }, (_, i) => {
    const value = 0.05 + (0.9 * ((i * 7) % EVENTS)) / EVENTS;
    face.set(control.name, value);
    return { control: control.name, value, coefficients: face.coefficients };
  });
});

/** Microseconds an event. */
function time(name, list) {
  const { event } = contenders[name];
  const wasm = name.startsWith('phiz');
  const start = process.hrtime.bigint();
  for (const { control, value, coefficients } of list) {
    event(control, wasm ? value : coefficients);
  }
  return Number(process.hrtime.bigint() - start) / 1000 / list.length;
}

const median = (numbers) => {
  const sorted = numbers.toSorted((a, b) => a - b);
  const half = sorted.length / 2;
  return (sorted[Math.floor(half)] + sorted[Math.ceil(half) - 1]) / 2;
};

const names = Object.keys(contenders);
const report = { node: process.version, cpu: cpus()[0].model, rounds: ROUNDS, groups: {} };
let [disagreement, turned] = [0, 0];
for (const [g, group] of groups.entries()) {
  const times = Object.fromEntries(names.map((name) => [name, []]));
  names.forEach((name) => time(name, events[g])); // Warm.
  for (let round = 0; round < ROUNDS; round++) {
    // Another one starts each round.
    for (let i = 0; i < names.length; i++) {
      const name = names[(i + round) % names.length];
      times[name].push(time(name, events[g]));
    }
  }
  const base = median(times[names[0]]);
  report.groups[group] = Object.fromEntries(
    names.map((name) => {
      const us = median(times[name]);
      const spread = [Math.min(...times[name]), Math.max(...times[name])];
      return [name, { us, spread, ratio: us / base }];
    }),
  );
  // Contenders that disagree do not do the same work. phiz's faces keep the sliders of the groups
  // before, so they are compared by a fresh face with this group's last event.
  const reference = simd.model.face();
  reference.set(picked[g].name, events[g].at(-1).value);
  const normals = reference.normals.slice();
  for (const name of names.filter((n) => n.includes('JS'))) {
    const peer = contenders[name].result();
    peer.positions.forEach((x, i) => {
      disagreement = Math.max(disagreement, Math.abs(x - reference.positions[i]));
    });
    if (!name.includes('three')) continue;
    peer.normals.forEach((x, i) => {
      turned = Math.max(turned, Math.abs(x - normals[i]));
    });
  }
  reference.free();
}
// f32 sums of differences of f32: below a hundredth of a millimetre.
if (!(disagreement < 0.01)) throw new Error(`the contenders differ by ${disagreement} mm`);
// Normals differ most amid slivers, where a micrometre turns them by a thousandth.
if (!(turned < 0.01)) throw new Error(`the contenders' normals differ by ${turned}`);
Object.assign(report, { largestDifferenceMm: disagreement, largestNormalDifference: turned });

const cell = (text, width) => String(text).padStart(width);
console.log(`${report.cpu}, Node ${report.node}; ${simd.model.vertexCount} vertices, ` +
  `${dense.modes.length} coefficients`);
console.log('one slider event to positions and normals, median of ' +
  `${ROUNDS} rounds of ${EVENTS}, microseconds (smallest to largest); times phiz simd\n`);
for (const group of groups) {
  console.log(group);
  for (const name of names) {
    const { us, spread, ratio } = report.groups[group][name];
    console.log(`  ${name.padEnd(28)}${cell(us.toFixed(1), 9)}  ` +
      `(${spread.map((x) => x.toFixed(1)).join(' to ')})`.padEnd(24) + `${cell(ratio.toFixed(1), 6)} x`);
  }
}
const target = new URL('../../target/', import.meta.url);
await mkdir(target, { recursive: true });
await writeFile(new URL('bench.json', target), `${JSON.stringify(report, null, 2)}\n`);
