// Faces from photos, with the package as `./build.sh build` leaves it in pkg.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, before, describe, test } from 'node:test';
import { gunzipSync } from 'node:zlib';

import { load } from '../../pkg/index.js';

const file = (name) => readFile(new URL(`../../www/public/${name}`, import.meta.url));
const bytes = await file('model.phiz');

const SIZE = { width: 640, height: 480 };
const CAMERA = { focal: 900, yaw: 0.3, translation: [10, -15, 700] };

/** The 68 points of a face, as a camera sees them that it looks past by an angle. */
function seen(face, { yaw } = CAMERA) {
  const { positions, model } = face;
  const points = [];
  for (let i = 0; i < 68; i++) {
    const name = `ibug_${String(i).padStart(2, '0')}`;
    const { stencil } = model.landmarks.find((l) => l.name === name);
    const at = [0, 1, 2].map((axis) => stencil.reduce((s, [v, w]) => s + w * positions[3 * v + axis], 0));
    points.push(...project(at, yaw).slice(0, 2));
  }
  return points;
}

/** Where a place of the head is in the image, px, and how far from the camera, mm. */
function project(at, yaw) {
  const [x, y, z] = turned(at, yaw).map((c, axis) => c + CAMERA.translation[axis]);
  return [SIZE.width / 2 + (CAMERA.focal * x) / z, SIZE.height / 2 + (CAMERA.focal * y) / z, z];
}
/** Yaw about y, then from y up and z towards the viewer to y down and z ahead. */
function turned([x, y, z], yaw) {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  return [cos * x + sin * z, -y, sin * x - cos * z];
}

/** A face of one colour under one lamp: a spot a vertex, the nearest last. */
function lit(face, { yaw, lamp }) {
  const { positions, normals, model } = face;
  const { width, height } = SIZE;
  const rgba = new Uint8Array(4 * width * height).fill(60);
  const spots = Array.from({ length: face.positions.length / 3 }, (_, v) => {
    const [at, normal] = [positions, normals].map((all) => Array.from(all.subarray(3 * v, 3 * v + 3)));
    const shade = 0.3 + 0.6 * Math.max(0, turned(normal, yaw).reduce((sum, n, axis) => sum + n * lamp[axis], 0));
    return [...project(at, yaw), Math.round(255 * Math.min(1, shade) ** (1 / 2.2))];
  }).sort((a, b) => b[2] - a[2]);
  for (const [x, y, , byte] of spots) {
    for (let row = Math.round(y) - 3; row <= Math.round(y) + 3; row++) {
      const from = 4 * (row * width + Math.round(x) - 3);
      rgba.fill(byte, from, from + 28);
    }
  }
  for (let i = 3; i < rgba.length; i += 4) rgba[i] = 255;
  return rgba;
}

describe('a photo', () => {
  let model;
  let points;
  before(async () => {
    model = await load(bytes);
    const face = model.face();
    face.randomize({ seed: 4 });
    points = seen(face);
    face.free();
  });
  after(() => model.free());

  test('gives a face, a camera and how well they fit', async () => {
    const fit = await model.fitPhoto({ ...SIZE, points });
    assert.equal(fit.quality.refusal, null);
    assert.ok(fit.quality.rmsMm < 1, `${fit.quality.rmsMm} mm`);
    assert.ok(Math.abs(fit.camera.angles[0] - CAMERA.yaw) < 0.1, `yaw ${fit.camera.angles[0]}`);
    assert.deepEqual(fit.camera.centre, [320, 240]);
    assert.equal(fit.camera.rotation.length, 9);
    assert.equal(fit.residuals.length, 68);
    assert.deepEqual(fit.expression, {}, 'without expressions there are none');
    // The code is of the model that other faces are of.
    const face = model.fromCode(fit.code);
    const [r, t] = [fit.camera.rotation, fit.camera.translation];
    const { stencil } = model.landmarks.find((l) => l.name === 'ibug_30');
    const nose = [0, 1, 2].map((axis) => stencil.reduce((s, [v, w]) => s + w * face.positions[3 * v + axis], 0));
    const at = [0, 1, 2].map((i) => t[i] + r[3 * i] * nose[0] + r[3 * i + 1] * nose[1] + r[3 * i + 2] * nose[2]);
    for (const axis of [0, 1]) {
      const projected = fit.camera.centre[axis] + (fit.camera.focal * at[axis]) / at[2];
      const fitted = points[60 + axis] + fit.residuals[30][axis];
      // Positions are f32 on a head of 200 mm.
      assert.ok(Math.abs(projected - fitted) < 0.01, `${projected} is not ${fitted}`);
    }
    face.free();
  });

  test('gives the same whatever was fitted before, in any array', async () => {
    const first = await model.fitPhoto({ ...SIZE, points });
    const shifted = points.map((x) => x + 20);
    assert.notEqual((await model.fitPhoto({ ...SIZE, points: shifted })).code, first.code);
    assert.deepEqual(await model.fitPhoto({ ...SIZE, points: new Float64Array(points) }), first);
    const known = await model.fitPhoto({ ...SIZE, points, focal: 900 });
    assert.ok(Math.abs(known.camera.focal / 900 - 1) < 0.1, `${known.camera.focal}`);
  });

  test('of the same person from another side tells more of the face', async () => {
    const face = model.face();
    face.randomize({ seed: 4 });
    const truth = face.positions.slice();
    const side = { ...SIZE, points: seen(face, { yaw: -0.5 }), focal: 900 };
    const off = async (photo) => {
      face.code = (await model.fitPhoto(photo)).code;
      return face.positions.reduce((sum, x, i) => sum + Math.abs(x - truth[i]), 0) / truth.length;
    };
    const [alone, both] = [await off({ ...SIZE, points }), await off({ ...SIZE, points, others: [side] })];
    assert.ok(both < alone, `${both} mm off, ${alone} with one`);
    // More is determined by two than by one of them, also where both are as far off as a detector's.
    for (const noise of [undefined, 2]) {
      const [one, two] = await Promise.all([[], [{ ...side, noise }]].map((others) => model.fitPhoto({ ...SIZE, points, noise, others })));
      assert.ok(two.quality.determined > one.quality.determined + 1, `${two.quality.determined}, ${one.quality.determined}`);
    }
    // Its pixels tell more than its points, where the photo has its own and they are of a face.
    const rgba = lit(face, { yaw: CAMERA.yaw, lamp: [-0.6, -0.5, -0.6] });
    const beside = lit(face, { yaw: -0.5, lamp: [0.5, -0.3, -0.8] });
    const together = (more) => model.fitPhoto({ ...SIZE, points, rgba, others: [{ ...side, ...more }] });
    const [few, all, flat] = [await together({}), await together({ rgba: beside }), await together({ rgba: beside.map(() => 90) })];
    assert.ok(few.appearance, 'the photo is one of a face');
    assert.ok(all.quality.determined > few.quality.determined + 3, `${all.quality.determined}, ${few.quality.determined}`);
    assert.deepEqual(flat, few);
    // How that was taken is told as of the photo itself: it can be changed, too, and so can the photo be where it is the other.
    const [shot] = all.others;
    assert.deepEqual([few.others[0].light, shot.residuals.length], [null, 68]);
    const inner = shot.residuals.slice(17).map(([x, y]) => x ** 2 + y ** 2);
    assert.ok(Math.abs(Math.sqrt(inner.reduce((sum, square) => sum + square, 0) / 51) / shot.rmsPx - 1) < 1e-9 && shot.rmsPx < 1.5, `${shot.rmsPx} px`);
    assert.ok(shot.rmsMm > 0.2 * shot.rmsPx && shot.rmsMm < 2 * shot.rmsPx, `${shot.rmsMm} mm`);
    const lamp = (light, [x, y, z]) => light.coefficients[1][0] + x * light.coefficients[1][1] + y * light.coefficients[1][2] + z * light.coefficients[1][3];
    const aside = (light) => lamp(light, [0.5, 0, 0]) / lamp(light, [-0.5, 0, 0]);
    assert.ok(aside(all.light) < 0.8 && aside(shot.light) > 1.25, `from its left ${aside(all.light)} and ${aside(shot.light)} times as bright as from its right`);
    const edit = await model.editPhoto({ ...SIZE, fit: { ...all, ...shot }, rgba: beside, others: [{ ...SIZE, shot: all, rgba }] });
    assert.equal(edit.field({ code: all.code, expression: shot.expression }), null);
    assert.ok(edit.field({ code: model.face().code, expression: shot.expression }).motion.some((by) => Math.abs(by) > 1));
    edit.free();
    assert.deepEqual(await model.fitPhoto({ ...SIZE, points, others: [{ ...side, rgba: beside }] }), await model.fitPhoto({ ...SIZE, points, others: [side] }));
    // They are copied at once.
    const given = beside.slice();
    const later = together({ rgba: given });
    given.fill(0);
    assert.deepEqual(await later, all);
    face.free();
    for (const [others, what] of [
      [side, /others must be an array of photos/],
      [[{ ...side, rgba: [1] }], /another photo's rgba must be a Uint8Array/],
      [[5], /a photo must be an object/],
      [[{ ...side, points: side.points.slice(2) }], /67 points were given of another photo, a face has 68/],
      [[{ ...side, focal: 0 }], /the focal length must be above 0 px, not 0/],
      [[{ ...side, noise: 0 }], /the points' noise must be above 0 px/],
      [[{ ...side, jawNoise: NaN }], /the jaw's noise must be above 0 px/],
      [[{ ...side, others: [] }], /fitPhoto knows no option "others"/],
    ]) {
      await assert.rejects(model.fitPhoto({ ...SIZE, points, others }), what);
    }
    await assert.rejects(together({ rgba: beside.subarray(4) }), /bytes are no photo of 640 x 480/);
  });

  test('of the same person from both sides gives the head their colours', async () => {
    const face = model.face();
    face.randomize({ seed: 4 });
    const sides = [-0.7, 0.7].map((yaw) => ({ ...SIZE, points: seen(face, { yaw }), focal: 900 }));
    face.free();
    // Skin everywhere: what is worn of a photo is what it sees of the head.
    const rgba = Uint8Array.from({ length: 4 * SIZE.width * SIZE.height }, (_, i) => [200, 150, 120, 255][i % 4]);
    const fit = await model.fitPhoto({ ...SIZE, points, rgba, others: sides });
    assert.equal(fit.others.length, 2);
    for (const [i, yaw] of [-0.7, 0.7].entries()) {
      const [turned] = fit.others[i].camera.angles;
      assert.ok(Math.abs(turned - yaw) < 0.1, `${turned}`);
    }
    const others = sides.map((side, i) => ({ ...SIZE, shot: fit.others[i], rgba }));
    const worn = async (more) => {
      const edit = await model.editPhoto({ ...SIZE, fit, ...more });
      const texture = edit.texture(rgba, 256);
      edit.free();
      return texture.filter((value, i) => i % 4 === 3 && value > 200).length;
    };
    const [alone, all] = [await worn({}), await worn({ others })];
    assert.ok(all > 1.1 * alone, `${all} texels, ${alone} of one photo`);
    for (const [wrong, what] of [
      [{}, /others must be an array of photos/],
      [[undefined], /another photo must be an object, not undefined/],
      [[others[0], { ...others[1], shot: undefined }], /the shot of another photo must be one of the `others`/],
      [[{ ...others[0], rgba: rgba.slice(4) }], /bytes are no photo of/],
      [[{ ...others[0], rgba: [] }], /another photo's rgba must be a Uint8Array/],
      [[{ ...others[0], points: 1 }], /editPhoto knows no option "points"/],
      [[{ ...others[0], width: 0 }], /width must be a whole number/],
    ]) {
      await assert.rejects(model.editPhoto({ ...SIZE, fit, others: wrong }), what);
    }
  });

  test('tells expressions once they are loaded', async () => {
    const smiling = await load(bytes);
    const before = await smiling.fitPhoto({ ...SIZE, points });
    await smiling.loadExpressions(await file('expressions.phiz'));
    // Where eyes look is told by their irises: 2 mm to the subject's left they are turned there.
    const middles = [36, 42].flatMap((first) => [0, 1].map((axis) => [0, 1, 2, 3, 4, 5].reduce((sum, k) => sum + points[2 * (first + k) + axis] / 6, 0)));
    const shifted = middles.map((value, i) => value + (i % 2 ? 0 : 2.6));
    const aside = (fit) => (fit.expression.eyeLookOutLeft ?? 0) - (fit.expression.eyeLookInLeft ?? 0);
    const [ahead, left] = [await smiling.fitPhoto({ ...SIZE, points, irises: middles }), await smiling.fitPhoto({ ...SIZE, points, irises: shifted })];
    assert.ok(aside(left) > aside(ahead) + 0.3, `${aside(left)}, ${aside(ahead)}`);
    const [shot] = (await smiling.fitPhoto({ ...SIZE, points, others: [{ ...SIZE, points, irises: shifted }] })).others;
    assert.ok(aside(shot) > aside(ahead) + 0.3, `${aside(shot)}, ${aside(ahead)}`);
    for (const [irises, what] of [
      [5, /irises must be an array of x, y, x, y, not 5/],
      [middles.slice(1), /irises must be an array of x, y, x, y/],
      [[...middles.slice(1), NaN], /an iris's coordinate must be a number/],
      [['1', ...middles.slice(1)], /an iris's coordinate must be a number/],
    ]) {
      await assert.rejects(smiling.fitPhoto({ ...SIZE, points, irises }), what);
    }
    const face = smiling.face();
    face.randomize({ seed: 4 });
    face.express('jawOpen', 0.7);
    const fit = await smiling.fitPhoto({ ...SIZE, points: seen(face) });
    assert.ok(Math.abs(fit.expression.jawOpen - 0.7) < 0.25, `${fit.expression.jawOpen}`);
    face.expression = fit.expression;
    assert.deepEqual(before.expression, {});
    // With what the photo shows nothing moves; without it the mouth would be shut.
    const edit = await smiling.editPhoto({ ...SIZE, fit });
    const own = smiling.fromCode(fit.code);
    assert.notEqual(edit.field(own), null);
    own.expression = fit.expression;
    assert.equal(edit.field(own), null);
    edit.free();
    smiling.free();
  });

  test('what is no fit is refused with what it must be', async () => {
    const fit = await model.fitPhoto({ ...SIZE, points });
    for (const bad of [undefined, null, {}, fit.code, { ...fit, camera: {} }, { ...fit, expression: undefined }, { ...fit, light: {} }, { ...fit, light: 0 }, { ...fit, code: 3 }]) {
      await assert.rejects(model.editPhoto({ ...SIZE, fit: bad }), /a fit must be what `fitPhoto` gave/);
    }
    for (const none of [undefined, null, 5]) {
      await assert.rejects(model.editPhoto(none), /a photo must be/);
      await assert.rejects(model.fitPhoto(none), /a photo must be/);
    }
  });

  test('tells the light on it when it has pixels', async () => {
    const { width, height } = SIZE;
    const grey = new Uint8ClampedArray(4 * width * height).fill(128);
    const photo = { ...SIZE, points, rgba: grey };
    /** @type {number[]} */
    const told = [];
    const { light, ...rest } = await model.fitPhoto({ ...photo, progress: (part) => void told.push(part) });
    assert.ok(told.length > 0 && told.every((part, i) => part > (told[i - 1] ?? 0) && part <= 1), `${told}`);
    const without = await model.fitPhoto({ ...SIZE, points });
    assert.equal(without.light, null);
    assert.deepEqual({ ...rest, light: null }, without, 'pixels change nothing else');
    assert.deepEqual(light.coefficients.map((c) => c.length), [9, 9, 9]);
    // Everything is as bright; skin is redder than grey, so the light on it would be bluish.
    const [red, , blue] = light.coefficients;
    assert.ok(blue[0] > red[0] && red[0] > 0, `${blue[0]} and ${red[0]}`);
    for (const channel of light.coefficients) {
      assert.ok(channel.slice(1).every((c) => Math.abs(c) < 0.2 * channel[0]), 'from everywhere');
    }
    await assert.rejects(model.fitPhoto({ ...photo, rgba: grey.subarray(4) }), /bytes are no photo of 640 x 480/);
    // Where the person is nowhere no light is told, and the face is that of the points.
    const nobody = grey.map((value, i) => (i % 4 === 3 ? 0 : value));
    assert.deepEqual(await model.fitPhoto({ ...photo, rgba: nobody }), without);
  });

  test('changes with the face, and not without', async () => {
    const { width, height } = SIZE;
    const noise = Uint8ClampedArray.from({ length: 4 * width * height }, (_, i) => (i * 7919) % 251);
    const fit = await model.fitPhoto({ ...SIZE, points });
    const edit = await model.editPhoto({ ...SIZE, fit });
    const face = model.fromCode(fit.code);
    assert.equal(edit.field(face), null);
    assert.deepEqual(edit.render(face, noise), noise);
    const before = face.measure('nose width');
    face.setMeasure('nose width', before + 6);
    const field = edit.field(face);
    assert.equal(field.motion.length, 2 * field.columns * field.rows);
    assert.equal(field.gain.length, 3 * field.columns * field.rows);
    // Some 3 mm to a side at 700 mm through a lens of 900 px, and less where the head looks past.
    const most = field.motion.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    assert.ok(most > 1.5 && most < 8, `${most} px`);
    const changed = edit.render(face, noise);
    const rows = new Set();
    changed.forEach((byte, i) => byte !== noise[i] && rows.add(Math.floor(i / 4 / width)));
    const nose = points[61];
    assert.ok(rows.has(Math.round(nose)), 'beside the nose');
    // A plain object is as good; the same shape gives the same pixels.
    assert.deepEqual(edit.render({ code: face.code, expression: {} }, noise), changed);
    face.code = fit.code;
    assert.deepEqual(edit.render(face, noise), noise, 'and back');
    assert.throws(() => edit.field({ code: face.code, expression: { jawOpen: 1 } }), /no expression "jawOpen"/);
    assert.throws(() => edit.field({ code: 'nothing', expression: {} }), Error);
    assert.throws(() => edit.render(face, noise.subarray(4)), /bytes are no photo of 640 x 480/);
    face.setMeasure('nose width', before + 6);
    assert.throws(() => edit.render(face, noise.subarray(4)), /bytes are no photo of 640 x 480/);
    edit.free();
    assert.throws(() => edit.field(face), /was freed/);

    // Where alpha says that nobody is, less moves: of another face, whose outline is another.
    const outline = noise.map((byte, i) => (i % 4 < 3 ? byte : Math.floor(i / 4) % width < points[0] ? 0 : 255));
    const other = model.face();
    other.randomize({ seed: 9 });
    const moving = async (/** @type {Uint8ClampedArray | undefined} */ rgba) => {
      const opened = await model.editPhoto({ ...SIZE, fit, rgba });
      const { motion } = opened.field(other);
      opened.free();
      return motion.reduce((count, x) => count + Number(x !== 0), 0);
    };
    const [anywhere, held] = [await moving(undefined), await moving(outline)];
    assert.ok(held < 0.95 * anywhere, `${held} of ${anywhere} move`);
    other.free();
    await assert.rejects(model.editPhoto({ ...SIZE, fit, rgba: outline.subarray(4) }), /bytes are no photo of 640 x 480/);
    face.free();
  });

  test('changes with an expression', async () => {
    const smiling = await load(bytes);
    await smiling.loadExpressions(await file('expressions.phiz'));
    const face = smiling.face();
    face.randomize({ seed: 4 });
    face.express('jawOpen', 0.4);
    const fit = await smiling.fitPhoto({ ...SIZE, points: seen(face) });
    const edit = await smiling.editPhoto({ ...SIZE, fit });
    const shown = smiling.fromCode(fit.code);
    shown.expression = fit.expression;
    assert.equal(edit.field(shown), null, 'the expression is in the photo');
    shown.express('jawOpen', 0);
    assert.ok(edit.field(shown), 'the mouth shuts');
    smiling.free();
    edit.free();
  });

  test('that is none is an error or refused, in a sentence', async () => {
    const fails = (photo, why) => assert.rejects(model.fitPhoto({ ...SIZE, points, ...photo }), why);
    await fails({ points: points.slice(2) }, /67 points were given, a face has 68/);
    await fails({ points: points.slice(1) }, /one has no y/);
    await fails({ points: [] }, /0 points were given/);
    await fails({ points: points.with(5, NaN) }, /a point's coordinate must be from -960 to 1440 px/);
    await fails({ points: new Array(136).fill(7) }, /on a line/);
    for (const width of [0, -5, 3.5, NaN, '640', undefined, 2 ** 32 + 640]) {
      await fails({ width }, /a photo's width must be a whole number of pixels above 0/);
    }
    await fails({ focal: -3 }, /the focal length must be above 0 px/);
    // As files' own words have it.
    for (const name of ['focal', 'noise', 'jawNoise']) for (const value of ['50 mm', null, [1], {}]) await fails({ [name]: value }, new RegExp(`${name} must be a number`));
    await fails({ focalLength: 900 }, /fitPhoto knows no option "focalLength"/);
    for (const rgba of [new Float32Array(4 * SIZE.width * SIZE.height), [1, 2, 3], 'pixels']) {
      await fails({ rgba }, /rgba must be a Uint8Array or Uint8ClampedArray/);
    }
    await fails({ width: 40_000, height: 40_000 }, /a photo of 40000 x 40000 pixels is too large/);
    const backwards = [];
    for (let i = 0; i < 136; i += 2) backwards.unshift(points[i], points[i + 1]);
    const { quality } = await model.fitPhoto({ ...SIZE, points: backwards });
    assert.match(quality.refusal, /These points are/);
  });

  test('is not edited as no camera or light would show it', async () => {
    const fit = await model.fitPhoto({ ...SIZE, points });
    const { camera } = fit;
    const opens = (wrong) => model.editPhoto({ ...SIZE, fit: { ...fit, camera: { ...camera, ...wrong } } });
    const { rotation } = camera;
    for (const wrong of [{ focal: -900 }, { focal: NaN }, { rotation: rotation.map((x) => -x) }, { rotation: rotation.map(() => 0) }, { translation: [0, NaN, 700] }, { centre: [Infinity, 0] }]) {
      await assert.rejects(opens(wrong), /a camera has a focal length above 0/, JSON.stringify(wrong));
    }
    const light = { coefficients: [0, 1, 2].map(() => [1, 0, 0, NaN, 0, 0, 0, 0, 0]), rms: 0 };
    await assert.rejects(model.editPhoto({ ...SIZE, fit: { ...fit, light } }), /a light has only finite numbers/);
    // Nothing broke on the way.
    const edit = await opens({});
    assert.equal(edit.field({ code: fit.code, expression: {} }), null);
    edit.free();
  });

  test('is the one that was given, whatever becomes of its pixels', async () => {
    const { width, height } = SIZE;
    const pixels = () => Uint8ClampedArray.from({ length: 4 * width * height }, (_, i) => (i % 4 === 3 ? 255 : 80 + ((i * 7919) % 91)));
    const wanted = await model.fitPhoto({ ...SIZE, points, rgba: pixels() });
    assert.ok(wanted.light);
    const rgba = pixels();
    const fit = model.fitPhoto({ ...SIZE, points, rgba });
    rgba.fill(0);
    assert.deepEqual(await fit, wanted);
    // Of background that is wiped out on the way as much is held as before.
    const other = model.face();
    other.randomize({ seed: 9 });
    const outline = pixels().map((byte, i) => (i % 4 < 3 ? byte : Math.floor(i / 4) % width < points[0] ? 1 : 255));
    const opened = async (/** @type {boolean} */ wiped) => {
      const given = outline.slice();
      const edit = model.editPhoto({ ...SIZE, fit: wanted, rgba: given });
      if (wiped) given.fill(255);
      const { motion } = (await edit).field(other);
      (await edit).free();
      return motion;
    };
    assert.deepEqual(await opened(true), await opened(false));
    other.free();
  });

  test('of many pixels is drawn in the memory of one', async () => {
    // Once more, for its memory.
    const glue = await import('../../pkg/photo/photo.js?again');
    const { memory } = await glue.default({ module_or_path: await readFile(new URL('../../pkg/photo/photo_bg.wasm', import.meta.url)) });
    const fit = await model.fitPhoto({ ...SIZE, points });
    const fitter = glue.Fitter.parse(gunzipSync(bytes), undefined);
    // The face is as large as before, in the middle of 12 megapixels.
    const [width, height] = [4000, 3000];
    const { camera } = fit;
    const centre = [camera.centre[0] + 1600, camera.centre[1] + 1300];
    const numbers = Float64Array.of(camera.focal, ...centre, ...camera.rotation, ...camera.translation);
    const edit = glue.PhotoEdit.open(fitter, Uint32Array.of(width, height), numbers, new Float64Array(0), fit.code, new Float64Array(0));
    const rgba = new Uint8Array(4 * width * height);
    for (let i = 0; i < rgba.length; i += 1) rgba[i] = (i * 7919) % 251;
    const other = model.fromCode(fit.code);
    other.setMeasure('nose width', other.measure('nose width') + 6);
    const { byteLength } = memory.buffer;
    const changed = edit.render(rgba, other.code, new Float64Array(0));
    assert.ok(changed.some((byte, i) => byte !== rgba[i]));
    const more = (memory.buffer.byteLength - byteLength) / (width * height);
    // Four bytes a pixel, and what memory grows by at a time.
    assert.ok(more < 6, `${more} bytes a pixel`);
    for (const one of [edit, fitter, other]) one.free();
  });

  test('is not fitted by a model that was freed', async () => {
    const gone = await load(bytes);
    const late = gone.fitPhoto({ ...SIZE, points });
    gone.free();
    await assert.rejects(late, /was freed/);
    await assert.rejects(gone.fitPhoto({ ...SIZE, points }), /was freed/);
    const edited = await load(bytes);
    const fit = await edited.fitPhoto({ ...SIZE, points });
    const opened = edited.editPhoto({ ...SIZE, fit });
    edited.free();
    await assert.rejects(opened, /was freed/);
  });

  test('may be opened while expressions come, and says when they came after it', async () => {
    const mine = await load(bytes);
    const fit = await mine.fitPhoto({ ...SIZE, points });
    const early = await mine.editPhoto({ ...SIZE, fit });
    const another = await load(bytes);
    const [edit] = await Promise.all([another.editPhoto({ ...SIZE, fit }), file('expressions.phiz').then((all) => another.loadExpressions(all))]);
    assert.throws(() => edit.field({ code: fit.code, expression: { nothing: 1 } }), /has no expression "nothing"/);
    edit.free();
    await mine.loadExpressions(await file('expressions.phiz'));
    assert.throws(() => early.field({ code: fit.code, expression: { jawOpen: 1 } }), /was opened before its model had expressions/);
    early.free();
    const late = await mine.editPhoto({ ...SIZE, fit });
    assert.ok(late.field({ code: fit.code, expression: { jawOpen: 1 } }), 'opened again it knows them');
    for (const one of [late, another, mine]) one.free();
  });

  test('is not edited by what is no pixels and no shape', async () => {
    const fit = await model.fitPhoto({ ...SIZE, points });
    await assert.rejects(model.editPhoto({ ...SIZE, fit, mask: 1 }), /editPhoto knows no option "mask"/);
    const edit = await model.editPhoto({ ...SIZE, fit });
    const pixels = new Uint8Array(4 * SIZE.width * SIZE.height);
    assert.throws(() => edit.field(), /a shape is a code and an expression/);
    assert.throws(() => edit.render(null, pixels), /a shape is a code and an expression/);
    for (const call of ['looks', 'texture']) assert.throws(() => edit[call](), /rgba must be a Uint8Array/);
    assert.throws(() => edit.render(fit), /rgba must be a Uint8Array/);
    const detail = { width: 1, height: 1, rgba: new Uint8Array(4), left: 0, top: 0 };
    assert.throws(() => edit.texture(pixels, 512, detail), /scale must be a number/);
    const [corners, shares] = [Uint32Array.of(0, 1, 2), Float32Array.of(1, 0, 0)];
    assert.throws(() => edit.albedos(null, corners, shares), /rgba must be a Uint8Array/);
    assert.throws(() => edit.albedos(pixels, [0, 1, 2], shares), /corners must be a Uint32Array/);
    assert.throws(() => edit.albedos(pixels, corners, [1, 0, 0]), /shares must be a Float32Array/);
    assert.throws(() => edit.albedos(pixels, corners, new Float32Array(6)), /a place has three corners and three shares/);
    assert.throws(() => edit.albedos(pixels, Uint32Array.of(0, 1, 1e9), shares), /there is no vertex 1000000000/);
    assert.throws(() => edit.albedos(pixels, corners, shares), /without the light/);
    assert.throws(() => edit.looks(pixels, [1, 2]), /irises must be an array of x, y, x, y/);
    assert.throws(() => edit.looks(pixels, [1, 2, 3, NaN]), /irises are the middles of two/);
    assert.throws(() => edit.texture(pixels, 512, { ...detail, scale: 1, rgba: [0, 0, 0, 0] }), /a detail's rgba must be a Uint8Array/);
    edit.free();
  });

  test('has a first fit that takes no longer than others once it is prepared', async () => {
    const { width, height } = SIZE;
    const fresh = await load(bytes);
    await fresh.preparePhotos();
    const rgba = Uint8ClampedArray.from({ length: 4 * width * height }, (_, i) => 80 + ((i * 7919) % 91));
    const times = [];
    for (let i = 0; i < 12; i++) {
      const started = performance.now();
      await fresh.fitPhoto({ ...SIZE, points, rgba });
      times.push(performance.now() - started);
    }
    fresh.free();
    const [first, ...others] = times;
    // Preparing takes some 160 ms; the slowest of others is what else the machine does.
    assert.ok(first < Math.max(...others) + 80, `${times.map(Math.round)}`);
  });

  test('is fitted in at most 15 ms', async () => {
    // The first calls run before the engine has compiled all of it.
    for (let i = 0; i < 20; i++) await model.fitPhoto({ ...SIZE, points });
    const times = [];
    for (let i = 0; i < 80; i++) {
      const started = performance.now();
      await model.fitPhoto({ ...SIZE, points });
      times.push(performance.now() - started);
    }
    // The fastest twentieth: what else the machine does is not the fit's.
    times.sort((a, b) => a - b);
    console.log(`a fit: ${times[4].toFixed(1)} ms, ${times[40].toFixed(1)} ms in the median`);
    assert.ok(times[4] < 15, `${times[4]} ms`);
  });

  test('is fitted by a module of its own', async () => {
    const holds = async (path, text) =>
      (await readFile(new URL(`../../pkg/${path}`, import.meta.url))).includes(text);
    // What fits photos is not in what every page loads.
    const text = ' points were given, a face has ';
    assert.ok(await holds('photo/photo_bg.wasm', text));
    for (const build of ['simd', 'scalar']) assert.ok(!(await holds(`${build}/phiz_bg.wasm`, text)));
  });
});
