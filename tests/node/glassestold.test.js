// Which glasses somebody wears in a photo: pictures are painted of the glasses that the page puts on faces.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { chance } from '../../www/src/chance.js';
import { lensesOf, rimOf, styleOf } from '../../www/src/glasses/style.js';
import { frameColour, lensColour, tintOf } from '../../www/src/glasses/tint.js';
import { tellGlasses } from '../../www/src/photo/glassestold.js';
import { glassesOf } from '../../www/src/photo/looks.js';
import { standOnFace } from '../../www/src/photo/stand.js';
import { wearer } from './wearer.js';

const { model, landmark, glasses, on } = await wearer('model');
const [WIDTH, HEIGHT] = [420, 300];
/** It is painted in so many parts of a pixel a side: wires are thinner than one. */
const FINER = 2;
const toSrgb = (/** @type {number} */ value) => 255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);

/**
 * A photo of the upper half of a face: skin that gets darker to one side, eyes and brows, and glasses before them. What is behind is not told from what is before,
 * so arms are left out.
 * @param {{ seed: number, looks: import('../../www/src/head/colouring.js').Colouring, skin?: number[], yaw?: number }} of
 */
function photo({ seed, looks, skin = [0.45, 0.28, 0.2], yaw = 0 }) {
  const random = chance(seed);
  const face = model.face();
  face.randomize({ seed, spread: 0.9 });
  const positions = face.positions.slice();
  const { code } = face;
  face.free();
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  const nose = landmark(positions, 'ibug_27');
  // Seen from ahead, where down is down: y and z are turned over.
  const rotation = [cos, 0, -sin, 0, -1, 0, -sin, 0, -cos];
  const turned = (/** @type {ArrayLike<number>} */ p) => [0, 1, 2].map((r) => rotation[3 * r] * p[0] + rotation[3 * r + 1] * p[1] + rotation[3 * r + 2] * p[2]);
  const before = turned(nose);
  const translation = [-before[0], -before[1], 700 - before[2]];
  const camera = { focal: 1400, centre: [WIDTH / 2, HEIGHT / 2], rotation, translation, angles: [yaw, 0, 0] };
  const seen = (/** @type {ArrayLike<number>} */ p) => {
    const [x, y, z] = turned(p).map((value, k) => value + translation[k]);
    return [camera.centre[0] + (camera.focal * x) / z, camera.centre[1] + (camera.focal * y) / z];
  };
  const [wide, high] = [FINER * WIDTH, FINER * HEIGHT];
  const picture = new Float32Array(3 * wide * high);
  for (let i = 0; i < wide * high; i++) {
    const shade = 1.2 - (0.5 * (i % wide)) / wide;
    for (let k = 0; k < 3; k++) picture[3 * i + k] = skin[k] * shade;
  }
  /** @param {number[][]} ring px of the photo @param {readonly number[]} colour @param {number} cover */
  function fill(ring, colour, cover) {
    const corners = ring.map((at) => at.map((value) => FINER * value));
    const [left, top] = [0, 1].map((k) => Math.max(0, Math.floor(Math.min(...corners.map((at) => at[k])))));
    const [right, bottom] = [wide, high].map((side, k) => Math.min(side - 1, Math.max(...corners.map((at) => at[k]))));
    for (let y = top; y <= bottom; y++) {
      for (let x = left; x <= right; x++) {
        let inside = false;
        corners.forEach(([ax, ay], i) => {
          const [bx, by] = corners[(i + 1) % corners.length];
          if (ay > y + 0.5 !== by > y + 0.5 && x + 0.5 < ax + ((bx - ax) * (y + 0.5 - ay)) / (by - ay)) inside = !inside;
        });
        const o = 3 * (y * wide + x);
        if (inside) for (let k = 0; k < 3; k++) picture[o + k] += cover * (colour[k] - picture[o + k]);
      }
    }
  }
  const named = (/** @type {number} */ from, /** @type {number} */ to, up = 0) =>
    Array.from({ length: to - from + 1 }, (_, i) => {
      const [x, y, z] = landmark(positions, `ibug_${from + i}`);
      return seen([x, y + up, z]);
    });
  for (const first of [36, 42]) fill(named(first, first + 5), [0.12, 0.1, 0.09], 0.9);
  for (const first of [17, 22]) fill([...named(first, first + 4, -4), ...named(first, first + 4, -9).reverse()], [0.03, 0.02, 0.015], 0.8);
  if (looks.glasses) {
    const placed = on(looks, positions);
    const { main, metal, lenses } = placed;
    const { colour, taken } = lensColour(looks.tint ?? 0);
    const parts = Object.fromEntries(glasses.look.map((part) => [part.kind, part]));
    // A lens is a front, a back and an edge: each takes a part of the light.
    const draw = (/** @type {string} */ kind, /** @type {{ positions: Float32Array }} */ body, /** @type {readonly number[]} */ of, /** @type {number} */ cover) => {
      const { triangles } = parts[kind];
      for (let t = 0; t < triangles.length; t += 3) {
        const ring = [0, 1, 2].map((k) => body.positions.subarray(3 * triangles[t + k], 3 * triangles[t + k] + 3));
        // What goes back to the ears.
        if (kind !== 'lenses' && ring.some((p) => p[2] < placed.fitted.origin[2] - 14)) continue;
        fill(ring.map(seen), of, cover);
      }
    };
    draw('lenses', lenses, colour.toArray(), 1 - Math.sqrt(1 - taken));
    const frame = frameColour(looks.frameColour ?? 0.66).colour.toArray();
    for (const [kind, body] of /** @type {const} */ ([['metal', metal], ['main', main]])) if (parts[kind]) draw(kind, body, frame, 1);
  }
  const rgba = new Uint8ClampedArray(4 * WIDTH * HEIGHT).fill(255);
  for (let y = 0; y < HEIGHT; y++) {
    for (let x = 0; x < WIDTH; x++) {
      for (let k = 0; k < 3; k++) {
        let sum = 0;
        for (let i = 0; i < FINER ** 2; i++) sum += picture[3 * ((FINER * y + Math.floor(i / FINER)) * wide + FINER * x + (i % FINER)) + k];
        rgba[4 * (y * WIDTH + x) + k] = toSrgb(sum / FINER ** 2) + 6 * (random() - 0.5);
      }
    }
  }
  return { told: tellGlasses({ rgba, width: WIDTH, height: HEIGHT }, camera, standOnFace(model, code)), rgba };
}
/** Skin, as a photo tells it. @param {number[]} skin */
const looksOf = (skin) => ({ skin, irises: null, beard: 0, beardColour: null, hair: null });

describe('glasses in a photo', () => {
  test('are told by the form of their lenses, their rims and their colour, whoever wears them and however the head is turned', () => {
    const random = chance(3);
    /** @type {Record<string, number[]>} */
    const off = { width: [], height: [], form: [], sweep: [], rim: [], frameColour: [] };
    for (let i = 0; i < 9; i++) {
      const wire = i % 3 === 0;
      const looks = {
        glasses: 1, lensForm: random(), lensSize: 0.15 + 0.7 * random(), lensHeight: 0.15 + 0.7 * random(), lensSweep: 0.3 + 0.4 * random(),
        rim: wire ? 0.25 : 0.5 + 0.3 * random(), frameColour: wire ? 0.14 : [0.48, 0.66, 1][i % 3],
      };
      // Gold is brighter than deep skin, and darker than the fairest.
      const skin = [[0.5, 0.34, 0.26], [0.3, 0.17, 0.11], [0.06, 0.035, 0.025]][wire ? 2 : i % 2];
      const { told } = photo({ seed: 40 + i, looks, skin, yaw: ((i % 5) - 2) * 0.2 });
      assert.ok(told?.form && !told.half && told.rim !== null, `${i}: ${JSON.stringify(told)} of ${JSON.stringify(looks)}`);
      const { width, height, form, sweep, rim } = styleOf(looks);
      for (const [name, value] of Object.entries({ width: told.form.width - width, height: told.form.height - height, form: told.form.form - form, sweep: told.form.sweep - sweep, rim: told.rim - rim })) off[name].push(value);
      off.frameColour.push((glassesOf(told, looksOf(skin)).frameColour ?? 0.66) - looks.frameColour);
      assert.equal(glassesOf(told, looksOf(skin)).tint, 0);
    }
    // Who tells nothing is 4 mm off, and 0.3 and 0.23 of the forms' ways; 0.9 mm of the rims'.
    const rms = Object.fromEntries(Object.entries(off).map(([name, all]) => [name, Math.sqrt(all.reduce((sum, value) => sum + value ** 2, 0) / all.length)]));
    assert.ok(rms.width < 2 && rms.height < 2 && rms.form < 0.2 && rms.sweep < 0.15 && rms.rim < 0.6 && rms.frameColour < 0.12, JSON.stringify(rms));
  });

  test('with a rim above alone, with none, and dark ones are told from others', () => {
    const half = photo({ seed: 7, looks: { glasses: 1, lensForm: 0.5, lensSize: 0.6, lensHeight: 0.4, rim: 0.24, halfRim: 1 } }).told;
    assert.ok(half?.form && half.half, JSON.stringify(half));
    const none = photo({ seed: 8, looks: { glasses: 1, lensForm: 0.4, lensSize: 0.55, lensHeight: 0.36, rim: 0, frameColour: 0.66 } }).told;
    assert.ok(none && !none.form, JSON.stringify(none));
    assert.equal(glassesOf(none, looksOf([0.4, 0.3, 0.2])).rim, 0);
    for (const tint of [0.4, 0.85]) {
      const { told } = photo({ seed: 9, looks: { glasses: 1, lensSize: 0.75, lensHeight: 0.58, rim: 0.6, tint } });
      const own = glassesOf(told, looksOf([0.45, 0.28, 0.2]));
      assert.ok(Math.abs((own.tint ?? 0) - tint) < 0.2, `${JSON.stringify(own)} of ${tint}`);
    }
  });

  test('nothing is told of bare faces, nor of what is not in the photo', () => {
    for (let i = 0; i < 4; i++) {
      const { told } = photo({ seed: 60 + i, looks: {}, skin: i % 2 ? [0.06, 0.035, 0.025] : [0.5, 0.34, 0.26], yaw: ((i % 5) - 2) * 0.2 });
      assert.equal(told, null, `${i}`);
    }
    const stand = standOnFace(model, model.face().code);
    const camera = { focal: 1400, centre: [-2000, 0], rotation: [1, 0, 0, 0, -1, 0, 0, 0, -1], translation: [0, 0, 700], angles: [0, 0, 0] };
    assert.equal(tellGlasses({ rgba: new Uint8ClampedArray(4 * 100), width: 10, height: 10 }, camera, stand), null);
  });

  test('the numbers of a style go back to its sliders', () => {
    for (const value of [0, 0.06, 0.3, 0.5, 0.77, 1]) {
      const looks = { glasses: 1, lensForm: value, lensSize: 1 - value, lensHeight: value, lensSweep: value, rim: Math.max(0.06, value), tint: value };
      const style = styleOf(looks);
      const back = { ...lensesOf(style), rim: rimOf(style.rim), tint: value === 0 ? 0 : tintOf(lensColour(value).taken) };
      for (const [name, own] of Object.entries(back)) assert.ok(Math.abs(own - looks[name]) < 1e-9, `${name}: ${own} of ${looks[name]}`);
    }
  });
});
