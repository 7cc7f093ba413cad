// Glasses: what a frame is, how it sits on heads, and how a colouring keeps it.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { load, prepare } from '../../pkg/index.js';
import { mirroredColouring } from '../../www/src/editing/mirror.js';
import { frontOf } from '../../www/src/glasses/frame.js';
import { styleOf } from '../../www/src/glasses/style.js';
import { frameColour, lensColour } from '../../www/src/glasses/tint.js';
import { carriedOf, COLOURS, GLASSES, mixture, readColouring, REST, wearsGlasses, whole } from '../../www/src/head/colouring.js';
import { measureShifts } from '../../www/src/head/shifts.js';
import { coloursAlong, told } from '../../www/src/head/someone.js';
import { decodeColouring, encodeColouring } from '../../www/src/keep/addresscode.js';
import { wearer } from './wearer.js';

const { Color, Triangle, Vector3 } = await import('../../www/node_modules/three/build/three.module.js');

const root = new URL('../../', import.meta.url);
await prepare({ build: 'simd', wasm: await readFile(new URL('pkg/simd/phiz_bg.wasm', root)) });

/** Of each make one. @type {Record<string, import('../../www/src/head/colouring.js').Colouring>} */
const SOME = {
  round: { glasses: 1, lensForm: 0, lensSize: 0.25, lensHeight: 0.9, rim: 0.22, frameColour: 0.14 },
  rectangular: { glasses: 1, lensForm: 0.7, lensSize: 0.6, lensHeight: 0.38, rim: 0.6 },
  pilot: { glasses: 1, lensForm: 0.3, lensSize: 0.85, lensHeight: 0.66, lensSweep: 0.05, rim: 0.2, noseBar: 0.6, tint: 0.35 },
  upswept: { glasses: 1, lensForm: 0.3, lensSize: 0.55, lensHeight: 0.45, lensSweep: 0.92, rim: 0.62 },
  browline: { glasses: 1, lensForm: 0.3, lensSize: 0.45, lensHeight: 0.55, lensSweep: 0.55, rim: 0.7, halfRim: 0.9 },
  rimless: { glasses: 1, lensForm: 0.4, lensSize: 0.55, lensHeight: 0.36, rim: 0 },
  sunglasses: { glasses: 1, lensForm: 0.5, lensSize: 0.75, lensHeight: 0.58, lensSweep: 0.6, rim: 0.68, tint: 0.85 },
};
/** The ends of the sliders together. */
const ENDS = [0, 1].flatMap((lensForm) => [0, 1].flatMap((lensSize) => [0, 1].flatMap((lensSweep) => [0, 0.4, 1].map((rim) => ({ glasses: 1, lensForm, lensSize, lensSweep, rim, lensHeight: 1 - lensForm, halfRim: lensSize, noseBar: lensSweep })))));

const head = await wearer('model');
const { model, rest } = head;

/** @param {{ positions: ArrayLike<number> }} body @returns {[number, number, number][]} */
const cornersOf = ({ positions }) => Array.from({ length: positions.length / 3 }, (_, i) => [positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]]);

/** How far places are outside of a skin, mm, as far as that is told; Infinity farther away. @param {number[]} triangles @param {Float32Array} p @param {Float32Array} n */
function outsideOf(triangles, p, n) {
  const cell = 4;
  /** @type {Map<string, number[]>} */
  const cells = new Map();
  for (let t = 0; t < triangles.length; t += 3) {
    const [low, high] = [Math.min, Math.max].map((of) => [0, 1, 2].map((k) => Math.floor(of(...[0, 1, 2].map((c) => p[3 * triangles[t + c] + k])) / cell)));
    for (let x = low[0]; x <= high[0]; x++) {
      for (let y = low[1]; y <= high[1]; y++) {
        for (let z = low[2]; z <= high[2]; z++) {
          const key = `${x} ${y} ${z}`;
          if (!cells.has(key)) cells.set(key, []);
          cells.get(key)?.push(t);
        }
      }
    }
  }
  const [a, b, c, at, near, out, weights] = Array.from({ length: 7 }, () => new Vector3());
  const triangle = new Triangle(a, b, c);
  return (/** @type {[number, number, number]} */ place) => {
    at.fromArray(place);
    let [least, sign] = [cell, 0];
    const [x, y, z] = place.map((value) => Math.floor(value / cell));
    for (let i = 0; i < 27; i++) {
      for (const t of cells.get(`${x + (i % 3) - 1} ${y + (Math.floor(i / 3) % 3) - 1} ${z + Math.floor(i / 9) - 1}`) ?? []) {
        [a, b, c].forEach((corner, k) => corner.fromArray(p, 3 * triangles[t + k]));
        triangle.closestPointToPoint(at, near);
        const far = near.distanceTo(at);
        if (far >= least || !Triangle.getBarycoord(near, a, b, c, weights)) continue;
        least = far;
        out.set(0, 0, 0);
        for (let k = 0; k < 3; k++) for (const axis of /** @type {const} */ (['x', 'y', 'z'])) out[axis] += weights.getComponent(k) * n[3 * triangles[t + k] + ['x', 'y', 'z'].indexOf(axis)];
        sign = near.sub(at).dot(out) > 0 ? -1 : 1;
      }
    }
    return sign === 0 ? Infinity : sign * least;
  };
}

describe('a frame', () => {
  test('is closed and of numbers, whatever its sliders say', () => {
    for (const looks of [...Object.values(SOME), ...ENDS]) {
      const placed = head.on(looks, rest);
      for (const { kind, name, triangles, colours } of head.glasses.look) {
        const { positions, normals } = placed[kind];
        const what = `${name} of ${JSON.stringify(looks)}`;
        assert.ok(positions.every(Number.isFinite) && normals.every(Number.isFinite) && colours.every((value) => value >= 0 && value <= 1), what);
        for (let o = 0; o < normals.length; o += 3) assert.ok(Math.abs(Math.hypot(...normals.subarray(o, o + 3)) - 1) < 1e-4, `${what}: normal ${o / 3}`);
        // Each edge has two sides, by where its ends are: corners of two faces may lie in one place.
        const place = (/** @type {number} */ i) => [0, 1, 2].map((k) => positions[3 * i + k].toFixed(4)).join();
        /** @type {Map<string, number>} */
        const edges = new Map();
        for (let t = 0; t < triangles.length; t += 3) {
          for (let k = 0; k < 3; k++) {
            const [a, b] = [place(triangles[t + k]), place(triangles[t + ((k + 1) % 3)])];
            if (a === b) continue;
            const [key, way] = a < b ? [`${a} ${b}`, 1] : [`${b} ${a}`, -1];
            edges.set(key, (edges.get(key) ?? 0) + way);
          }
        }
        assert.ok(edges.size > 20 && [...edges.values()].every((sum) => sum === 0), `${what} is open`);
        // It is not inside out.
        let volume = 0;
        for (let t = 0; t < triangles.length; t += 3) {
          const [a, b, c] = [0, 1, 2].map((k) => new Vector3().fromArray(positions, 3 * triangles[t + k]));
          volume += a.dot(b.cross(c)) / 6;
        }
        assert.ok(volume > 1, `${what}: ${volume} mm3`);
      }
    }
  });

  test('has the sizes of those that are sold', () => {
    const span = (/** @type {{ positions: Float32Array }} */ body, /** @type {number} */ k) => {
      const values = cornersOf(body).map((corner) => corner[k]);
      return Math.max(...values) - Math.min(...values);
    };
    for (const [name, looks] of Object.entries(SOME)) {
      const { width, height, rim } = styleOf(looks);
      assert.ok(width >= 44 && width <= 58 && height >= 22 && height <= 58, `${name}: lenses of ${width} by ${height} mm`);
      assert.ok(rim >= 0 && rim <= 6, `${name}: a rim of ${rim} mm`);
      const placed = head.on(looks, rest);
      const inner = Math.min(...cornersOf(placed.lenses).filter(([x]) => x > 0).map(([x]) => x));
      assert.ok(2 * inner > 12 && 2 * inner < 26, `${name}: ${2 * inner} mm between the lenses`);
      const front = cornersOf(placed.main).filter(([, , z]) => z > 8);
      const wide = Math.max(...front.map(([x]) => x)) - Math.min(...front.map(([x]) => x));
      assert.ok(wide > 118 && wide < 158, `${name}: ${wide} mm across`);
      const long = placed.fitted.arms[0].reduce((sum, point, i, all) => (i ? sum + Math.hypot(...point.map((value, k) => value - all[i - 1][k])) : 0), 0);
      assert.ok(long > 125 && long < 160, `${name}: arms of ${long} mm`);
      assert.ok(span(placed.main, 1) < 80);
    }
  });

  test('is whole, or a half, or none', () => {
    const widest = (/** @type {import('../../www/src/head/colouring.js').Colouring} */ looks) => frontOf(styleOf(looks)).parts;
    assert.ok(widest(SOME.rimless).metal.triangles.length > 0);
    assert.equal(widest(SOME.rectangular).plastic.triangles.length, 0);
    // Below, a browline has but a wire, which is of metal.
    const below = (/** @type {import('../../www/src/glasses/sweep.js').Body} */ body) => cornersOf(body).filter(([, y]) => y < -9).length;
    assert.equal(below(widest(SOME.browline).main), 0);
    assert.ok(below(widest(SOME.browline).metal) > 50);
    assert.ok(below(widest(SOME.rectangular).main) > 50);
  });

  test('is the same each time', () => {
    const [one, other] = [0, 1].map(() => head.on(SOME.browline, rest));
    assert.deepEqual(one, other);
    const later = head.on(SOME.round, rest);
    assert.notDeepEqual(later.main.positions, one.main.positions);
    assert.deepEqual(head.on(SOME.browline, rest).main, one.main);
  });

  test('is of a colour from end to end of its slider', () => {
    for (let at = 0; at <= 1; at += 0.01) {
      const { colour, spots, metal } = frameColour(Math.min(1, at));
      for (const value of [...colour.toArray(), ...spots.toArray(), metal]) assert.ok(value >= 0 && value <= 1);
    }
    assert.equal(frameColour(0).metal, 1);
    assert.equal(frameColour(REST.frameColour).metal, 0);
    assert.ok(lensColour(0).taken < 0.05 && lensColour(1).taken > 0.85);
  });
});

describe('on a head', () => {
  test('glasses are as symmetric as the face', () => {
    // The median face is symmetric to a ten thousandth of a millimetre once it is made so.
    const { mirror } = model;
    const even = rest.slice();
    for (let v = 0; v < model.vertexCount; v++) for (let k = 0; k < 3; k++) even[3 * v + k] = (rest[3 * v + k] + (k === 0 ? -1 : 1) * rest[3 * mirror[v] + k]) / 2;
    for (const looks of Object.values(SOME)) {
      const placed = head.on(looks, even, 2);
      for (const kind of /** @type {const} */ (['main', 'metal', 'plastic', 'lenses'])) {
        const all = cornersOf(placed[kind]);
        const key = (/** @type {number[]} */ [, y, z]) => Math.round(y) * 1000 + Math.round(z);
        /** @type {Map<number, number[][]>} */
        const near = new Map();
        for (const corner of all) near.set(key(corner), [...(near.get(key(corner)) ?? []), corner]);
        for (const [x, y, z] of all) {
          const others = [-1, 0, 1].flatMap((dy) => [-1, 0, 1].flatMap((dz) => near.get(key([0, y + dy, z + dz])) ?? []));
          assert.ok(others.some(([u, v, w]) => Math.hypot(u + x, v - y, w - z) < 1e-3), `${kind}: ${[x, y, z]}`);
        }
      }
    }
  });

  const EXTREMES = [
    ...['nose 1', 'nose 2', 'nose 3', 'head 1', 'head 2', 'head 3', 'head 4', 'eyes 1', 'eyes 2', 'forehead 1'].flatMap((name) => [0, 1].map((end) => ({ name, end }))),
  ];

  test('they are outside of the skin, before the eyes and on the ears, on all kinds of faces', () => {
    const face = model.face();
    /** @type {[string, Float32Array, Float32Array][]} */
    const faces = [];
    for (let seed = 1; seed <= 60; seed++) {
      face.randomize({ seed, spread: 1 });
      faces.push([`seed ${seed}`, face.positions.slice(), face.normals.slice()]);
    }
    for (const { name, end } of EXTREMES) {
      face.reset();
      const control = model.controls.find((one) => one.name === name);
      assert.ok(control, name);
      face.set(name, control.limits[end]);
      faces.push([`${name} at ${end}`, face.positions.slice(), face.normals.slice()]);
    }
    face.free();
    const names = Object.keys(SOME);
    for (const [i, [who, p, n]] of faces.entries()) {
      const outside = outsideOf(head.skin, p, n);
      const eyes = head.eyesOf(p);
      const ears = ['left', 'right'].map((side) => head.landmark(p, `superaurale ${side}`));
      {
        const name = names[i % names.length];
        const placed = head.on(SOME[name], p);
        const { fitted } = placed;
        const isPad = (/** @type {number[]} */ corner) => fitted.pads.some(({ at }) => Math.hypot(...at.map((value, k) => value - corner[k])) < 8);
        for (const kind of /** @type {const} */ (['main', 'metal'])) {
          for (const corner of cornersOf(placed[kind])) {
            if (isPad(corner)) continue;
            // Ears are soft, and the tips of arms lie between them and the head.
            const soft = corner[2] < ears[0][2] + 12 ? 0.5 : 0.1;
            const far = outside(corner);
            assert.ok(far > -soft, `${name} on ${who}: ${kind} at ${corner.map((value) => value.toFixed(1))} is ${far.toFixed(2)} mm off the skin`);
          }
        }
        for (const corner of cornersOf(placed.lenses)) {
          const far = outside(corner);
          assert.ok(far > 0.4, `${name} on ${who}: a lens at ${corner.map((value) => value.toFixed(1))} is ${far.toFixed(2)} mm off the skin`);
        }
        for (const { centre, radius } of eyes) {
          // Opticians have 12 to 14 mm before the pupil; a lens leans.
          const before = cornersOf(placed.lenses).filter(([x, y]) => Math.hypot(x - centre.x, y - centre.y) < radius);
          const least = Math.min(...before.map(([, , z]) => z)) - centre.z - 1.09 * radius;
          assert.ok(before.length > 5 && least > 9.5, `${name} on ${who}: ${least} mm before the cornea`);
          assert.ok(least < 26, `${name} on ${who}: it floats ${least} mm before the cornea`);
        }
        const lenses = cornersOf(placed.lenses);
        const tips = cornersOf({ positions: head.lashes.bodiesAt(p, eyes.map(({ centre }) => centre)) });
        for (const [x, y, z] of tips.filter((_, n) => n % 10 === 9)) {
          const back = Math.min(...lenses.filter((corner) => Math.hypot(corner[0] - x, corner[1] - y) < 6).map((corner) => corner[2]));
          assert.ok(back > z + 1, `${name} on ${who}: a lash ends at ${[x, y, z]}, and the lens is at ${back}`);
        }
        fitted.arms.forEach((arm, side) => {
          const [tip] = arm.slice(-1);
          assert.ok(tip[2] < ears[side][2] - 8 && tip[1] < ears[side][1] - 20, `${name} on ${who}: the arm ends at ${tip}, and the ear is at ${ears[side]}`);
          // Where it passes above the ear it lies on it.
          const over = arm.find(([, , z]) => z < ears[side][2] + 5);
          assert.ok(over && over[1] > ears[side][1] - 6 && over[1] < ears[side][1] + 9, `${name} on ${who}: ${over} above the ear ${ears[side]}`);
        });
      }
    }
  });

  test('they do not jump while a slider is drawn', () => {
    const face = model.face();
    const most = (/** @type {Float32Array} */ one, /** @type {Float32Array} */ other) => one.reduce((far, value, i) => Math.max(far, Math.abs(value - other[i])), 0);
    for (const name of ['nose 1', 'nose 3', 'eyes 1', 'eyes 2', 'head 1', 'head 2', 'head 5']) {
      face.reset();
      /** @type {{ at: Float32Array, face: Float32Array } | null} */
      let last = null;
      for (let percent = 6; percent <= 94; percent += 1) {
        face.set(name, percent / 100);
        const positions = face.positions.slice();
        const now = { at: head.on(SOME.rectangular, positions, 2).main.positions, face: positions };
        // Steps of half a millimetre nobody sees; arms are levers of what the nose does.
        if (last) {
          const [far, own] = [most(now.at, last.at), most(now.face, last.face)];
          assert.ok(far < Math.max(0.1, 1.5 * own), `${name} at ${percent}: glasses go ${far.toFixed(2)} mm, and the face ${own.toFixed(2)}`);
        }
        last = now;
      }
    }
    face.free();
  });

  test('they stay while the face does something, and are not in its skin then', async () => {
    const moving = await load(await readFile(new URL('www/public/model.phiz', root)));
    await moving.loadExpressions(await readFile(new URL('www/public/expressions.phiz', root)));
    const { glasses } = head;
    const shiftsOf = measureShifts(moving, glasses.vertices);
    const face = moving.face();
    const mesh = glasses.group.children.find(({ name }) => name === 'glasses main');
    for (const seed of [0, 7, 58]) {
      if (seed) face.randomize({ seed, spread: 0.9 });
      face.expression = {};
      const rest = face.positions.slice();
      const { fitted } = head.on(SOME.rectangular, rest);
      glasses.update(rest, head.eyesOf(rest), null);
      const before = mesh.geometry.attributes.position.array.slice();
      for (const name of ['eyeBlinkLeft', 'browInnerUp', 'browDownLeft', 'cheekSquintLeft', 'noseSneerRight', 'jawOpen', 'mouthSmileLeft', 'mouthFunnel', 'cheekPuff']) {
        face.expression = { [name]: 1 };
        const positions = face.positions.slice();
        glasses.update(positions, head.eyesOf(positions), shiftsOf(face.expression));
        const { array } = mesh.geometry.attributes.position;
        const far = before.reduce((most, value, i) => Math.max(most, Math.abs(value - array[i])), 0);
        // Without what is taken off they go by 1.6. What is left is how a face does it otherwise than the median one.
        assert.ok(far < 0.5, `seed ${seed}, ${name}: ${far} mm`);
        const outside = outsideOf(head.skin, positions, face.normals.slice());
        const front = cornersOf({ positions: array }).filter(([, , z], i) => i % 3 === 0 && z > 5);
        for (const corner of front) {
          if (fitted.pads.some(({ at }) => Math.hypot(...at.map((value, k) => value - corner[k])) < 9)) continue;
          // A brow that is drawn down comes a little into the back of a rim, where nobody sees it.
          assert.ok(outside(corner) > -0.7, `seed ${seed}, ${name}: ${corner} is ${outside(corner)} mm off the skin`);
        }
      }
    }
    face.free();
  });

  test('they lie on hair that is cropped', () => {
    const [on, off] = [3, 0].map((lift) => head.on(SOME.rectangular, rest, lift).fitted.arms[0][11][0]);
    assert.ok(on > off + 1.5, `${on} mm aside, and ${off} without hair`);
  });

  test('they do not go with the mouth, and go with the nose', async () => {
    const face = model.face();
    const before = head.on(SOME.rectangular, face.positions.slice()).main.positions;
    const moved = () => Math.max(...head.on(SOME.rectangular, face.positions.slice()).main.positions.map((value, i) => Math.abs(value - before[i])));
    face.set('mouth 1', 1);
    assert.equal(moved(), 0);
    face.reset();
    face.set('nose 1', 0.99);
    assert.ok(moved() > 0.5, `${moved()} mm`);
    face.free();
  });

  test('a model that was made up has them as well', async () => {
    const other = await wearer('synthetic');
    const placed = other.on(SOME.rectangular, other.rest);
    const outside = outsideOf(other.skin, other.rest, other.normals);
    for (const corner of cornersOf(placed.lenses)) assert.ok(outside(corner) > 0.4);
    const [tip] = placed.fitted.arms[0].slice(-1);
    assert.ok(tip[2] < other.landmark(other.rest, 'superaurale left')[2] - 8);
  });
});

describe('a colouring', () => {
  test('without glasses is the link that it was', () => {
    // As it was written before there were any.
    assert.equal(encodeColouring({ skin: 0.8, beardLength: 0.2, moustache: 0.5, cheekBeard: 0 }), 'AFAQFBQyFgA');
    assert.deepEqual(decodeColouring('AFAQFBQyFgA'), { skin: 0.8, beardLength: 0.2, moustache: 0.5, cheekBeard: 0 });
    assert.equal(COLOURS.indexOf('cheekBeard'), 22);
    // Brows got their form before.
    assert.deepEqual(COLOURS.slice(28, 38), [...GLASSES]);
    // And beards and brows colours of their own afterwards.
    assert.deepEqual(COLOURS.slice(38), ['beardShade', 'beardRed', 'beardGrey', 'browShade', 'browGrey']);
    assert.equal(encodeColouring(readColouring({ glasses: 0, tint: 0 })), '');
  });

  test('has each of its numbers among the types of the element, and in what tells of it', async () => {
    const [types, words] = await Promise.all(['types.d.ts', 'README.md'].map((name) => readFile(new URL(`../../www/designer/${name}`, import.meta.url), 'utf8')));
    const typed = Array.from(/type Colour =([^;]*);/.exec(types)?.[1].matchAll(/'(\w+)'/g) ?? [], ([, name]) => name);
    assert.deepEqual(typed.sort(), [...COLOURS].sort());
    for (const name of COLOURS) assert.ok(words.includes(`\`${name}\``), name);
  });

  test('keeps them in a link', () => {
    for (const looks of Object.values(SOME)) assert.deepEqual(decodeColouring(encodeColouring(readColouring(looks))), readColouring(looks));
  });

  test('has them or has them not, and between two the pair of who wears one', () => {
    const { tint, ...clear } = SOME.pilot;
    const bare = { skin: 0.8 };
    for (const [amount, isWorn] of /** @type {const} */ ([[0.49, false], [0.5, true], [0.9, true]])) {
      const between = mixture([[bare, 1 - amount], [SOME.pilot, amount]]);
      assert.equal(wearsGlasses(between), isWorn, `${amount}`);
      // It is not half as large, nor of half a colour.
      for (const name of GLASSES) assert.equal(whole(between)[name], isWorn ? whole(SOME.pilot)[name] : REST[name], name);
    }
    const both = mixture([[clear, 0.5], [{ ...SOME.pilot, tint: 0.8 }, 0.5]]);
    assert.equal(both.tint, 0.4);
    assert.equal(tint, 0.35);
  });

  test('has them in the mirror, and in other years', () => {
    assert.deepEqual(carriedOf(mirroredColouring({ ...SOME.pilot, parting: 0.2 }, model)), readColouring(SOME.pilot));
    const face = model.face();
    assert.deepEqual(carriedOf(coloursAlong(SOME.pilot, told(face), told(face))), readColouring(SOME.pilot));
    face.free();
  });
});
