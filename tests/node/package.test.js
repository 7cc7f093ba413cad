// The npm package as `./build.sh build` leaves it in pkg, on the committed model.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdir, mkdtemp, readFile, rm, symlink, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { setImmediate } from 'node:timers/promises';
import { setFlagsFromString } from 'node:v8';
import { fileURLToPath } from 'node:url';
import { runInNewContext } from 'node:vm';
import { gunzipSync, gzipSync } from 'node:zlib';

import { fastestBuild, load } from '../../pkg/index.js';

const bytes = await readFile(new URL('../../www/public/model.phiz', import.meta.url));
const expressionBytes = await readFile(new URL('../../www/public/expressions.phiz', import.meta.url));

const here = (path) => fileURLToPath(new URL(`../../${path}`, import.meta.url));

/** The largest difference between two arrays of numbers. */
function farthest(a, b) {
  assert.equal(a.length, b.length);
  let most = 0;
  for (let i = 0; i < a.length; i++) most = Math.max(most, Math.abs(a[i] - b[i]));
  return most;
}

test('Node takes the SIMD build by itself', () => {
  assert.equal(fastestBuild(), 'simd');
});

test('the module that pages load is at most 90 kB in gzip', async () => {
  const module = await readFile(new URL('../../pkg/simd/phiz_bg.wasm', import.meta.url));
  const { length } = gzipSync(module, { level: 9 });
  assert.ok(length <= 90_000, `${length} bytes`);
});

for (const build of ['simd', 'scalar']) {
  describe(build, () => {
    let model;
    let face;
    before(async () => {
      model = await load(bytes, { build });
      face = model.face();
    });
    after(() => model.free());

    test('a model says what it is', () => {
      assert.ok(model.vertexCount > 10_000);
      for (const region of ['eyes', 'nose', 'mouth', 'chin', 'forehead', 'head']) {
        assert.ok(model.regions.includes(region), region);
      }
      assert.ok(model.about.population.length > 20, 'it says whom it was learned from');
      assert.ok(model.about.caveat.length > 20, 'it says whom it does not describe');
      assert.ok(model.about.licences.length > 0);
      for (const control of model.controls) {
        assert.equal(control.unit, 'percentile');
        const [least, most] = control.limits;
        if (control.measure === null) assert.deepEqual([least, most], [0, 1]);
        // There is room for most people.
        else assert.ok(least >= 0 && least < 0.1 && most > 0.9 && most <= 1, `${control.name}: ${least} to ${most}`);
        assert.ok(model.regions.includes(control.group), control.group);
      }
      assert.equal(new Set(model.controls.map((c) => c.name)).size, model.controls.length);
    });

    test('the topology fits together', () => {
      const n = model.vertexCount;
      const corners = model.uvs.length / 2;
      assert.ok(corners >= n);
      assert.equal(model.uvVertices.length, corners);
      assert.equal(model.colours.length, 3 * n);
      assert.equal(model.regionOf.length, n);
      assert.ok(model.triangles.every((corner) => corner < corners));
      assert.ok(model.uvVertices.every((vertex) => vertex < n));
      assert.ok(model.mirror.every((m, v) => model.mirror[m] === v));
      const covered = model.parts.reduce((sum, part) => sum + part.count, 0);
      assert.equal(3 * covered, model.triangles.length);
    });

    test('a slider moves vertices, within the range that it tells', () => {
      face.reset();
      const before = { positions: face.positions.slice(), normals: face.normals.slice() };
      const { name } = model.controls[0];
      face.set(name, 0.95);
      // Half a step of the coefficient, 1/16384 sigma, is below 3e-5 of a percentile.
      assert.ok(Math.abs(face.get(name) - 0.95) < 1e-4);
      const [first, end] = face.changed;
      assert.ok(0 <= first && first < end && end <= model.vertexCount);
      const outside = (i) => i < 3 * first || i >= 3 * end;
      assert.ok(face.positions.every((x, i) => !outside(i) || x === before.positions[i]));
      assert.ok(face.normals.every((x, i) => !outside(i) || x === before.normals[i]));
      assert.ok(farthest(face.positions, before.positions) > 0.1, 'it moved visibly');
      face.reset();
      assert.deepEqual(face.positions, before.positions);
    });

    test('a face is made older and stays the same person', () => {
      const own = model.face();
      const other = model.face();
      own.randomize({ seed: 2 });
      other.randomize({ seed: 13 });
      const before = own.positions.slice();
      const reads = () => model.attributes.map(({ name }) => own.attribute(name));
      const was = reads();
      own.setAttributes({ age: 75 });
      model.attributes.forEach(({ name, limits }, i) => {
        const wanted = name === 'age' ? 75 : was[i];
        assert.ok(Math.abs(own.attribute(name) - wanted) <= 0.001 * (limits[1] - limits[0]), name);
      });
      const moved = farthest(own.positions, before);
      assert.ok(moved > 1 && moved < farthest(other.positions, before), `${moved} mm`);
      const mixture = { african: 0.6, asian: 0.3, caucasian: 0.1 };
      own.setAttributes(mixture);
      for (const [name, share] of Object.entries(mixture)) assert.ok(Math.abs(own.attribute(name) - share) <= 0.002, name);
      assert.ok(Math.abs(own.attribute('age') - 75) <= 0.1, 'what is not asked for stays');
      const { code } = own;
      for (const values of [{ age: 200 }, { age: NaN }, { 'no such': 1 }]) assert.throws(() => own.setAttributes(values), /attribute/);
      own.setAttributes({});
      assert.equal(own.code, code);
      for (const { name, deviation } of model.attributes) {
        other.reset();
        const middle = other.attribute(name);
        let squares = 0;
        for (let seed = 0; seed < 300; seed++) {
          other.randomize({ seed });
          squares += (other.attribute(name) - middle) ** 2 / 300;
        }
        // Of 300 faces a standard deviation is told to a twenty-fifth; five of these.
        assert.ok(Math.abs(Math.sqrt(squares) / deviation - 1) < 0.2, `${name}: ${Math.sqrt(squares)} and ${deviation}`);
      }
      own.free();
      other.free();
    });

    test('random faces read the attributes that they were asked for', () => {
      const names = model.attributes.map(({ name }) => name);
      assert.deepEqual(names, ['age', 'african', 'asian', 'caucasian', 'sex']);
      const own = model.face();
      for (const { name, unit, limits, description, explained } of model.attributes) {
        assert.ok(unit.length > 0 && limits[0] < limits[1]);
        assert.match(description, /synthetic/, 'it says of whom it was learned');
        assert.ok(explained > 0.25 && explained < 1);
        for (const value of limits) {
          own.randomize({ seed: 4, attributes: { [name]: value } });
          assert.ok(Math.abs(own.attribute(name) - value) <= 0.001 * (limits[1] - limits[0]), name);
        }
      }
      const of = (options) => {
        own.randomize({ seed: 9, ...options });
        return own.code;
      };
      assert.equal(of({ attributes: {} }), of({}), 'nothing asked is as it was');
      assert.notEqual(of({ attributes: { sex: 0.9 } }), of({ attributes: { sex: 0.1 } }));

      own.randomize({ seed: 1 });
      own.lock('nose');
      const inside = [...model.regionOf.keys()].filter((v) => model.regionNames[model.regionOf[v]] === 'nose');
      assert.ok(inside.length > 100);
      const before = own.positions.slice();
      own.randomize({ seed: 2, attributes: { age: 70, sex: 0.95 } });
      const moved = (v) => farthest(own.positions.slice(3 * v, 3 * v + 3), before.slice(3 * v, 3 * v + 3));
      assert.ok(inside.every((v) => moved(v) <= 1e-4), 'what is locked stays');
      assert.ok(farthest(own.positions, before) > 1);
      const { code } = own;
      for (const attributes of [{ age: 200 }, { age: NaN }, { 'no such': 1 }]) {
        assert.throws(() => own.randomize({ seed: 3, attributes }), /attribute/);
      }
      assert.throws(() => own.attribute('no such'), /no attribute/);
      assert.equal(own.code, code);
      own.free();
    });

    test('expressions go over a face and leave it as it was', async () => {
      const mine = await load(bytes, { build });
      const own = mine.face();
      own.randomize({ seed: 5 });
      assert.deepEqual(mine.expressions, []);
      assert.throws(() => own.express('jawOpen', 1), /loadExpressions/);
      await assert.rejects(mine.loadExpressions(bytes), /expressions/);
      for (const [given, reason] of [
        [undefined, /a file of expressions must be given as bytes/],
        ['expressions.phiz', /a file of expressions must be given as bytes/],
        [new Response('not here', { status: 404, statusText: 'Not Found' }), /404 Not Found/],
        [new Response('<!doctype html><title>Nothing here</title>'), /a page: is its address right/],
      ]) {
        await assert.rejects(mine.loadExpressions(given), reason);
      }
      await mine.loadExpressions(new Response(expressionBytes));
      await mine.loadExpressions(expressionBytes);
      assert.equal(mine.expressions.length, 51);
      const rest = { positions: own.positions.slice(), code: own.code, width: own.measure('mouth width') };

      own.express('jawOpen', 0.75);
      assert.deepEqual(own.expression, { jawOpen: 0.75 });
      const open = own.positions.slice();
      assert.ok(farthest(open, rest.positions) > 10, 'the jaw opened');
      const normals = own.normals.slice();
      for (let i = 0; i < normals.length; i += 3) {
        assert.ok(Math.abs(Math.hypot(normals[i], normals[i + 1], normals[i + 2]) - 1) < 1e-6);
      }
      assert.equal(own.code, rest.code);
      assert.equal(own.measure('mouth width'), rest.width);
      const twin = own.clone();
      assert.deepEqual(twin.positions, open);

      // What a weight moves is told, from what was asked for last.
      own.express('jawOpen', 0.5);
      const [first, end] = own.changed;
      assert.ok(0 <= first && first < end && end <= mine.vertexCount && end - first < mine.vertexCount);
      const outside = (_, i) => i < 3 * first || i >= 3 * end;
      assert.deepEqual(own.positions.filter(outside), open.filter(outside));
      assert.deepEqual(own.normals.filter(outside), normals.filter(outside));
      own.express('jawOpen', 0.75);
      assert.deepEqual(own.positions, open);

      // The expression stays on a face that changes; a vertex is dragged to where it is seen.
      own.randomize({ seed: 6 });
      assert.deepEqual(own.expression, { jawOpen: 0.75 });
      const tip = mine.landmarks.find((l) => l.name === 'ibug_30').stencil[0][0];
      const seen = own.positions.slice(3 * tip, 3 * tip + 3);
      own.drag(tip, [seen[0], seen[1], seen[2] + 1]);
      assert.ok(Math.abs(own.positions[3 * tip + 2] - seen[2] - 1) < 0.05);

      own.coefficients = twin.coefficients;
      assert.deepEqual(own.positions, open);
      own.expression = {};
      assert.deepEqual(own.expression, {});
      assert.deepEqual(own.positions, rest.positions);
      // What is refused leaves what was shown.
      own.expression = { jawOpen: 0.75 };
      for (const wrong of [{ jawOpen: 2 }, { noSuch: 0.5 }, { jawOpen: Number.NaN }, null, 5]) {
        assert.throws(() => (own.expression = wrong));
        assert.deepEqual(own.expression, { jawOpen: 0.75 });
      }
      mine.free();
      assert.throws(() => own.express('jawOpen', 1), /freed/);
    });

    test('normals have length 1', () => {
      for (let i = 0; i < face.normals.length; i += 3) {
        const [x, y, z] = face.normals.subarray(i, i + 3);
        // Three f32 roundings.
        assert.ok(Math.abs(Math.hypot(x, y, z) - 1) < 1e-6, `vertex ${i / 3}`);
      }
    });

    test('views stay right when the memory grows', () => {
      const kept = face.positions.slice();
      const many = Array.from({ length: 40 }, () => face.clone());
      assert.deepEqual(face.positions, kept);
      many.forEach((clone) => clone.free());
    });

    test('the memory of many faces grows in few steps', () => {
      let size = face.positions.buffer.byteLength;
      let steps = 0;
      const start = size;
      const many = Array.from({ length: 200 }, (_, seed) => {
        const own = model.face();
        own.randomize({ seed });
        const { byteLength } = own.positions.buffer;
        if (byteLength !== size) steps += 1;
        size = byteLength;
        return own;
      });
      // By an eighth each: a face may need one itself, where what is left does not hold it.
      const most = 2 * Math.ceil(Math.log(size / start) / Math.log(9 / 8)) + 2;
      assert.ok(size > 1.5 * start, 'there was room for all of them: the test says nothing');
      assert.ok(steps <= most, `${steps} steps from ${start} to ${size} bytes, at most ${most} were to be expected`);
      many.forEach((own) => own.free());
    });

    test('a code gives the same face again, and only on this model', () => {
      face.randomize({ seed: 11 });
      const again = model.fromCode(face.code);
      assert.deepEqual(again.positions, face.positions);
      assert.match(face.code, /^[A-Za-z0-9_-]+$/);
      const other = model.face();
      other.code = face.code;
      assert.deepEqual(other.coefficients, face.coefficients);
      assert.throws(() => model.fromCode(face.code.slice(0, -3)), /not a face code/);
      assert.throws(() => model.fromCode('AAAA'), /not a face code/);
      assert.throws(() => {
        other.code = '?';
      }, /not a face code/);
      again.free();
      other.free();
    });

    test('a clone lives by itself', () => {
      const clone = face.clone();
      assert.deepEqual(clone.positions, face.positions);
      clone.set(model.controls[0].name, 0.1);
      face.set(model.controls[0].name, 0.9);
      assert.ok(farthest(clone.positions, face.positions) > 0.1);
      clone.free();
      assert.ok(face.positions.length > 0);
    });

    test('a locked region stays when the rest is drawn', () => {
      face.randomize({ seed: 1 });
      // What a nose measures changes with the head that it is on.
      const nose = model.controls
        .filter((c) => c.group === 'nose' && c.measure === null)
        .map((c) => c.name);
      const values = nose.map((name) => face.get(name));
      face.lock('nose');
      assert.deepEqual(face.locked, ['nose']);
      assert.equal(face.randomize({ seed: 2 }), 2);
      assert.deepEqual(nose.map((name) => face.get(name)), values);
      face.unlock('nose');
      assert.deepEqual(face.locked, []);
      face.randomize({ seed: 2 });
      assert.notDeepEqual(nose.map((name) => face.get(name)), values);
    });

    test('twenty controls set measures, in mm', () => {
      const semantic = model.controls.filter((c) => c.measure !== null);
      assert.equal(semantic.length, 20);
      const { code } = face;
      for (const { name, measure } of semantic) {
        assert.ok(model.measures.some((m) => m.name === measure && m.unit === 'mm'), measure);
        face.set(name, 0.9);
        assert.ok(Math.abs(face.get(name) - 0.9) < 1e-3, name);
        face.setMeasure(measure, face.measure(measure) + 0.5);
        face.clear(name);
      }
      assert.equal(face.code, code, 'all of it is undone');
      face.setMeasure('nose width', 41);
      assert.ok(Math.abs(face.measure('nose width') - 41) < 0.01);
      assert.throws(() => face.setMeasure('nose width', NaN), /nose width/);
      assert.throws(() => face.setMeasure('ear width', 1), /no measure/);
    });

    test('a locked measure is held', () => {
      face.setMeasure('nose width', 40);
      face.lockMeasure('nose width');
      assert.deepEqual(face.lockedMeasures, ['nose width']);
      const held = face.measure('nose width');
      face.randomize({ seed: 4 });
      assert.ok(Math.abs(face.measure('nose width') - held) < 1e-4);
      face.unlockMeasure('nose width');
      assert.deepEqual(face.lockedMeasures, []);
      face.randomize({ seed: 4 });
      assert.ok(Math.abs(face.measure('nose width') - held) > 0.01);
    });

    test('a face moves towards another, in one region or in all', () => {
      const [from, to] = [model.face(), model.face()];
      to.randomize({ seed: 5 });
      from.blend(to, 1, { regions: ['mouth'] });
      const { group } = model.controls[0];
      assert.notEqual(group, 'mouth');
      assert.ok(Math.abs(from.get(model.controls[0].name) - 0.5) < 1e-4);
      // All of it goes over with its way of blending, and comes back without.
      const usual = from.alpha;
      to.alpha = 3;
      from.blend(to, 0.5);
      assert.ok(Math.abs(from.alpha - (usual + 3) / 2) < 0.01, `half of the way it is ${from.alpha}`);
      from.blend(to, 1);
      assert.equal(from.code, to.code);
      assert.deepEqual([...from.changed], [0, model.vertexCount]);
      assert.deepEqual(from.positions, to.positions);
      const { code } = from;
      from.blend(from, 0.5);
      assert.equal(from.code, code);
      assert.throws(() => from.blend(from, 2), /blend/);
      from.reset('nose');
      assert.equal(from.alpha, to.alpha);
      from.reset();
      const median = model.face();
      assert.equal(from.code, median.code);
      assert.deepEqual(from.positions, median.positions);
      // Borders of what is locked stay where they are.
      from.lock('nose');
      from.blend(to, 1);
      assert.equal(from.alpha, usual);
      median.free();
      from.free();
      to.free();
    });

    test('a measure is a length in mm and follows its sliders', () => {
      assert.ok(model.measures.length > 0);
      for (const { name, unit } of model.measures) {
        assert.equal(unit, 'mm');
        const length = face.measure(name);
        // Positions lie on either side of something; all else is a length.
        const least = /position|convexity|protrusion/.test(name) ? -400 : 1;
        assert.ok(length > least && length < 400, `${name} is ${length} mm`);
      }
    });

    test('a drag brings a vertex to its target', () => {
      face.reset();
      const vertex = face.model.landmarks.find((l) => l.name === 'ibug_30').stencil[0][0];
      const target = Array.from(face.positions.subarray(3 * vertex, 3 * vertex + 3));
      target[2] += 1;
      face.drag(vertex, target);
      const reached = face.positions.slice(3 * vertex, 3 * vertex + 3);
      // A millimetre on the tip of the nose is within everyone's reach; the ridge and the grid
      // leave micrometres.
      assert.ok(farthest(reached, target) < 0.01, `${reached} for ${target}`);
    });

    test('alpha is live', () => {
      face.randomize({ seed: 4 });
      const kept = face.positions.slice();
      const [least] = model.blending.limits;
      const { alpha } = face;
      face.alpha = least;
      assert.equal(face.alpha, Math.fround(least));
      assert.ok(farthest(face.positions, kept) > 0.01);
      assert.throws(() => (face.alpha = '5'), /a number, not "5"/);
      face.alpha = alpha;
      assert.deepEqual(face.positions, kept);
    });

    test('coefficients can be put back', () => {
      face.randomize({ seed: 6 });
      const { coefficients } = face;
      const kept = face.positions.slice();
      face.reset();
      face.coefficients = coefficients;
      assert.deepEqual(face.positions, kept);
    });

    test('what has no meaning is an Error with a reason, and changes nothing', () => {
      const kept = face.positions.slice();
      const { name } = model.controls[0];
      const wrong = [
        [() => face.set(name, NaN), /percentile/],
        [() => face.set(name, 1.5), /percentile/],
        [() => face.set('no such', 0.5), /no control is called "no such"/],
        [() => face.get('no such'), /no control/],
        [() => face.lock('no such'), /no region/],
        [() => face.measure('no such'), /no measure/],
        [() => face.reset('no such'), /no region/],
        [() => face.drag(1e9, [0, 0, 0]), /no vertex/],
        [() => face.drag(0, [0, NaN, 0]), /target/],
        [() => face.drag(0, []), /target/],
        [() => face.randomize({ spread: NaN }), /spread/],
        [() => face.randomize({ seed: -1 }), /./],
        [() => face.randomize({ regions: ['no such'] }), /no region/],
        [() => face.blend(face.clone(), 2), /blend/],
        [() => (face.coefficients = new Float32Array(1)), /coefficients/],
        [() => (face.coefficients = face.coefficients.fill(NaN)), /coefficient/],
        [() => (face.alpha = NaN), /blending distance/],
        [() => (face.alpha = 1e9), /blending distance/],
      ];
      for (const [act, reason] of wrong) {
        assert.throws(act, (error) => error instanceof Error && reason.test(error.message), `${act}`);
      }
      assert.deepEqual(face.positions, kept);
    });

    // What is no string would be read from somewhere in the module's memory.
    test('what is of another type is an Error that says so', () => {
      const kept = face.positions.slice();
      for (const value of [5, null, undefined, {}, ['nose 1'], Symbol('nose 1'), 5n, { length: 1e6 }]) {
        for (const act of [
          () => face.get(value),
          () => face.set(value, 0.5),
          () => face.clear(value),
          () => face.lock(value),
          () => face.unlock(value),
          () => face.measure(value),
          () => face.setMeasure(value, 20),
          () => face.lockMeasure(value),
          () => face.unlockMeasure(value),
          () => face.attribute(value),
          () => model.fromCode(value),
          () => (face.code = value),
          () => face.reset(value ?? null),
          () => face.randomize({ regions: [value] }),
        ]) {
          assert.throws(act, (error) => error instanceof TypeError && /must be/.test(error.message), `${act} of ${String(value)}`);
        }
      }
      for (const value of [null, undefined, true, '0.5', [], {}]) {
        for (const act of [
          () => face.set('nose 1', value),
          () => face.setMeasure('mouth width', value),
          () => face.blend(face.clone(), value),
          () => face.setAttributes({ age: value }),
          () => face.drag(0, [0, 0, value]),
          () => (face.coefficients = [0.5, value]),
          () => face.drag(0, value),
        ]) {
          assert.throws(act, (error) => error instanceof TypeError && /must be/.test(error.message), `${act} of ${String(value)}`);
        }
      }
      for (const vertex of [-1, 1.5, 2 ** 32 + 5, NaN, undefined, 'x', {}]) assert.throws(() => face.drag(vertex, [0, 0, 0]), /no vertex/);
      for (const act of [
        () => face.blend(face.clone(), 0.5, { region: ['nose'] }),
        () => face.blend({}, 0.5),
        () => face.randomize(5),
        () => face.randomize({ regions: 'nose' }),
        () => face.randomize({ sed: 4 }),
        // Whose names nobody would find.
        () => face.randomize([]),
        () => face.setAttributes(new Map([['age', 70]])),
        () => (face.expression = new Map([['jawOpen', 1]])),
      ]) {
        assert.throws(act, (error) => error instanceof Error && /no option|must be/.test(error.message), `${act}`);
      }
      for (const value of [undefined, null, 5, 'x']) assert.throws(() => (face.coefficients = value), /coefficients must be an array of numbers/);
      assert.deepEqual(face.positions, kept);
    });

    test('no options are no options, and buffers are taken from any realm', async () => {
      const other = await load(runInNewContext('(bytes) => Uint8Array.from(bytes).buffer')([...bytes]), null);
      const [one, two] = [other.face(), other.face()];
      one.randomize(null);
      two.blend(one, 1, null);
      assert.equal(two.code, one.code);
      other.free();
    });

    test('a response that was read is told from one that is none', async () => {
      const read = new Response(bytes);
      await read.arrayBuffer();
      await assert.rejects(load(read), /was read before/);
    });

    test('a model may be packed or not', async () => {
      const given = Uint8Array.from(bytes);
      const packed = await load(given.buffer, { build });
      assert.deepEqual(given, Uint8Array.from(bytes), 'what is given is left as it is');
    // A view of another kind, into the middle of a buffer; and of a blob that was unpacked, which is read at once.
    for (const own of [bytes, gunzipSync(bytes)]) {
      const within = new Uint8Array(own.length + 8);
      within.set(own, 8);
      for (const view of [new DataView(within.buffer, 8), new Uint8ClampedArray(within.buffer, 8)]) {
        const loaded = await load(view);
        assert.equal(loaded.face().code, model.face().code);
        loaded.free();
      }
    }
      const plain = await load(gunzipSync(bytes), { build });
      assert.equal(plain.fromCode(packed.face().code).code, packed.face().code);
      packed.free();
      plain.free();
    });

    /** Bytes as a network gives them. @param {Uint8Array} all @param {number} size of each part @param {string} [fails] after the last */
    const stream = (all, size, fails) => {
      let at = 0;
      return new ReadableStream({
        async pull(out) {
          await new Promise((done) => setTimeout(done));
          if (at < all.length) out.enqueue(Uint8Array.from(all.subarray(at, (at += size))));
          else if (fails) out.error(new Error(fails));
          else out.close();
        },
      });
    };

    test('a model may be a file that a person chose', async () => {
      const mine = await load(new Blob([bytes]), { build });
      assert.equal(mine.face().code, model.face().code);
      mine.free();
    });

    test('a model may be read while it comes in', async () => {
      const plain = gunzipSync(bytes);
      face.randomize({ seed: 5 });
      for (const given of [stream(bytes, 100_000), stream(plain, 1_000_001), stream(bytes, bytes.length), new Response(bytes), new Response(stream(bytes, 300_000))]) {
        const mine = await load(given, { build });
        const same = mine.face();
        same.randomize({ seed: 5 });
        assert.equal(same.code, face.code);
        assert.deepEqual(same.positions, face.positions);
        mine.free();
      }
      face.reset();
    });

    test('what a stream begins with may be a byte, or none', async () => {
      const pieces = (/** @type {Uint8Array[]} */ ...chunks) =>
        new ReadableStream({
          start(out) {
            for (const chunk of chunks) out.enqueue(chunk);
            out.close();
          },
        });
      const [none, plain] = [new Uint8Array(0), gunzipSync(bytes)];
      for (const file of [bytes, plain]) {
        for (const given of [pieces(none, file), pieces(file.subarray(0, 1), none, file.subarray(1)), pieces(file.subarray(0, 1), file.subarray(1, 2), file.subarray(2))]) {
          const mine = await load(given, { build });
          assert.equal(mine.vertexCount, model.vertexCount);
          mine.free();
        }
      }
      await assert.rejects(load(pieces(none, Buffer.from('<'), Buffer.from('html>')), { build }), /a page: is its address right/);
      await assert.rejects(load(pieces(bytes.subarray(0, 1)), { build }), /too few/);
      await assert.rejects(load(pieces(none, none), { build }), /too few/);
      // As some sources have them; what is no bytes at all is told.
      for (const view of [Uint8Array.from(bytes).buffer, new DataView(Uint8Array.from(bytes).buffer)]) {
        const mine = await load(pieces(view), { build });
        assert.equal(mine.vertexCount, model.vertexCount);
        mine.free();
      }
      for (const [chunk, type] of [['text', 'String'], [5, 'Number'], [new Blob([bytes]), 'Blob'], [[31, 139], 'Array'], [null, 'object'], [undefined, 'undefined']]) {
        await assert.rejects(load(pieces(bytes.subarray(0, 1000), chunk), { build }), (error) => error instanceof TypeError && error.message === `a stream must bring bytes, not ${type}`);
      }
    });

    test('models that do not come leave no memory behind', async () => {
      const before = face.positions.buffer.byteLength;
      for (let i = 0; i < 40; i++) await assert.rejects(load(stream(bytes.subarray(0, 700_000), 100_000), { build }));
      const { byteLength } = face.positions.buffer;
      // Half of a model's 8 MB have come each time.
      assert.ok(byteLength - before < 40e6, `it grew from ${before} to ${byteLength} bytes`);
    });

    test('a model that comes in wrongly is an Error with a reason', async () => {
      const damaged = Uint8Array.from(bytes);
      damaged.fill(7, 300_000, 300_100);
      const read = stream(bytes, 100_000);
      read.getReader();
      for (const [given, reason] of [
        [stream(bytes.subarray(0, 700_000), 100_000), /packed bytes are damaged/],
        [stream(damaged, 100_000), /packed bytes are damaged/],
        [stream(bytes, 100_000, 'the line is dead'), /the line is dead/],
        [stream(gunzipSync(bytes).subarray(0, 2_000_000), 100_000), /bytes long/],
        [stream(new Uint8Array(0), 1), /too few/],
        [stream(gzipSync(new Uint8Array(64 * 1024 * 1024 + 1)), 1000), /over the limit/],
        [new Response('not here', { status: 404, statusText: 'Not Found' }), /404 Not Found/],
        [new Response(null), /no body/],
        [new ReadableStream({ pull: () => Promise.reject('gone') }), /the file broke off: gone/],
        [read, /the stream is being read, or was/],
        [new Response('<!doctype html><title>Nothing here</title>'), /a page: is its address right/],
        ...['model.phiz', new URL('file:///model.phiz'), Promise.resolve(new Response(bytes)), undefined, null, 5, {}].map((given) => [given, /a model must be given as bytes/]),
      ]) {
        await assert.rejects(load(given, { build }), (error) => error instanceof Error && reason.test(error.message), `${reason}`);
      }
    });

    test('a bad blob is an Error with a reason', async () => {
      const plain = gunzipSync(bytes);
      const flip = (blob, at) => Uint8Array.from(blob, (byte, i) => (i === at ? byte ^ 1 : byte));
      for (const [blob, reason] of [
        [new Uint8Array(0), /too few/],
        [new Uint8Array(1000), /signature/],
        [plain.subarray(0, plain.length - 1), /bytes long/],
        [flip(plain, 5000), /checksum/],
        [flip(plain, 8), /version/],
        [bytes.subarray(0, bytes.length - 1), /packed bytes are damaged/],
        [bytes.subarray(0, 5000), /packed bytes are damaged/],
        [flip(bytes, 5000), /packed bytes are damaged|checksum/],
        [flip(bytes, bytes.length - 8), /packed bytes are damaged/],
        [gzipSync(bytes), /packed/],
        [gzipSync(plain.subarray(0, 1000)), /bytes long/],
        // A few kilobytes that would inflate without end.
        [gzipSync(new Uint8Array(64 * 1024 * 1024 + 1)), /over the limit of 67108864 bytes/],
      ]) {
        await assert.rejects(load(blob, { build }), (error) => {
          return error instanceof Error && reason.test(error.message);
        });
      }
    });

    test('what was freed throws, and does so again', async () => {
      const mine = await load(bytes, { build });
      const child = mine.face();
      const [a, b] = [child.clone(), child.clone()];
      a.free();
      a.free();
      for (const use of [
        () => a.positions,
        () => a.set(model.controls[0].name, 0.5),
        () => a.code,
        () => a.clone(),
        () => b.blend(a, 0.5),
        () => a.changed,
      ]) {
        assert.throws(use, /freed/);
      }
      // A model takes its faces along.
      mine.free();
      mine.free();
      assert.throws(() => mine.face(), /freed/);
      assert.throws(() => child.positions, /freed/);
      assert.throws(() => b.get(model.controls[0].name), /freed/);
    });
  });
}

// A bundler may leave the module anywhere.
test('the module may be given', async () => {
  const place = (name) => new URL(`../../pkg/${name}_bg.wasm`, import.meta.url);
  const wasm = await readFile(place('simd/phiz'));
  for (const [i, given] of [wasm, new WebAssembly.Module(wasm), new Response(wasm, { headers: { 'content-type': 'application/wasm' } }), place('simd/phiz'), place('simd/phiz').href].entries()) {
    // As many packages as there are ways: each is instantiated once.
    const own = await import(`../../pkg/index.js?${i}`);
    await own.prepare({ build: 'simd', wasm: given });
    const model = await own.load(bytes, { build: 'simd' });
    assert.ok(model.face().positions.length > 0);
    model.free();
  }
  const other = await import('../../pkg/index.js?none');
  await assert.rejects(other.prepare({ build: 'nope' }), /no build "nope"/);
  await assert.rejects(other.load(bytes, { build: 'nope' }), /no build "nope"/);
  await assert.rejects(other.prepare({ biuld: 'simd' }), /no option "biuld"/);
  // As servers answer who asks for a file that a bundler did not copy; in a process that has none yet.
  const script = `
    const { prepare } = await import(${JSON.stringify(new URL('../../pkg/index.js', import.meta.url))});
    for (const wasm of [new TextEncoder().encode('<!doctype html>'), new URL('file:///nowhere.wasm')]) {
      await prepare({ build: 'scalar', wasm }).catch(({ message, cause }) => console.log(message, cause instanceof Error));
    }
    await prepare({ build: 'scalar' });`;
  const { stdout, status } = spawnSync(process.execPath, ['--input-type=module', '-e', script], { encoding: 'utf8' });
  assert.match(stdout, /no wasm file \(see Bundlers.*magic.* true\n.*no wasm file.*nowhere.* true\n$/);
  assert.equal(status, 0, 'a right one may follow');
});

test('the types are true of what a program writes, and strict', async () => {
  const folder = await mkdtemp(join(tmpdir(), 'phiz-'));
  try {
    await mkdir(join(folder, 'node_modules'));
    await symlink(here('pkg'), join(folder, 'node_modules/phiz'));
    await writeFile(
      join(folder, 'page.ts'),
      `import { fastestBuild, load, prepare, type PhotoFit } from 'phiz';
      import { toGlb } from 'phiz/export';
      import photo from 'phiz/photo/photo_bg.wasm';
      import scalar from 'phiz/scalar/phiz_bg.wasm';
      import simd from 'phiz/simd/phiz_bg.wasm';
      export async function picture(rgba: Uint8ClampedArray, fit: PhotoFit) {
        const build = fastestBuild();
        await prepare({ build, wasm: build === 'simd' ? simd : scalar });
        const model = await load(new ReadableStream<ArrayBuffer>());
        await model.loadExpressions(new ReadableStream<Uint8Array>());
        await model.preparePhotos({ wasm: photo });
        const edit = await model.editPhoto({ width: 4, height: 4, fit, rgba });
        return [new ImageData(edit.render(model.face(), rgba), 4, 4), new ImageData(edit.texture(rgba, 64), 64, 64)];
      }
      // What is not there is as if it were not named.
      export async function other(file: Blob, seed?: number, rgba?: Uint8ClampedArray, targets?: boolean) {
        const model = await load(file, { build: undefined });
        const face = model.face();
        face.randomize({ seed, regions: undefined });
        const half: number[] = Array.from(face.coefficients, (value) => value / 2);
        face.coefficients = half;
        new Blob([face.coefficients]);
        const fit = await model.fitPhoto({ width: 4, height: 4, points: [], rgba, focal: undefined });
        await model.editPhoto({ width: 4, height: 4, fit, rgba });
        return toGlb(face, { targets });
      }
      // @ts-expect-error a stream of text is none of bytes
      load(new ReadableStream<string>());`,
    );
    for (const resolution of ['--module nodenext', '--module esnext --moduleResolution bundler']) {
      const flags = `--strict --exactOptionalPropertyTypes --noEmit --target es2022 --lib es2023,dom ${resolution}`.split(' ');
      const { status, stdout } = spawnSync(process.execPath, [here('www/node_modules/typescript/bin/tsc'), ...flags, 'page.ts'], { cwd: folder, encoding: 'utf8' });
      assert.equal(status, 0, stdout);
    }
  } finally {
    await rm(folder, { recursive: true });
  }
});

test('what is imported, and all that it imports, is packed', async () => {
  const { files } = JSON.parse(await readFile(new URL('../../pkg/package.json', import.meta.url), 'utf8'));
  const packed = (name) => files.some((file) => file === name || name.startsWith(`${file}/`));
  const seen = new Set(['index.js', 'index.d.ts', 'wasm.d.ts', 'export/index.js']);
  for (const name of seen) {
    const at = new URL(`../../pkg/${name}`, import.meta.url);
    assert.ok(packed(name), name);
    if (!name.endsWith('.js')) continue;
    // Comments name types, which stay.
    const code = (await readFile(at, 'utf8')).replace(/\/\*[^]*?\*\//g, '');
    for (const [, other] of code.matchAll(/(?:from |import\(|new URL\()'(\.[^']+)'/g)) {
      seen.add(new URL(other, at).pathname.split('/pkg/').at(-1));
    }
  }
  assert.ok(seen.has('photoedit.js') && seen.has('simd/phiz_bg.wasm'));
});

test('faces that nobody has are given back, whenever memory is collected', async () => {
  setFlagsFromString('--expose-gc');
  const collect = runInNewContext('gc');
  const model = await load(bytes);
  const { byteLength } = model.face().positions.buffer;
  // Each is 0.4 MB: without an end they would need a larger memory.
  const room = Math.ceil(byteLength / 400_000);
  for (let turn = 0; turn < 3 * room; turn += 10) {
    for (let i = 0; i < 10; i++) model.face();
    // Where a browser or Node would, while there is work: what was made before goes all the same.
    collect();
    await setImmediate();
  }
  const most = model.face().positions.buffer.byteLength;
  assert.ok(most <= 2 * byteLength + 8e6, `${most} bytes, ${byteLength} before`);
  model.free();
});

// Wherever memory is full: a face each fills it.
test('views outlive that the topology of their model is read', async () => {
  const head = gunzipSync(await readFile(new URL('../../www/public/head.phiz', import.meta.url)));
  const models = [];
  for (let i = 0; i < 40; i++) models.push(await load(head));
  for (const model of models) {
    const face = model.face();
    const { positions, normals } = face;
    const read = [model.triangles, model.uvs, model.uvVertices, model.colours, model.regionOf, model.mirror, face.changed];
    assert.ok(read.every(({ length }) => length > 0));
    assert.deepEqual([positions.length, normals.length], [3 * model.vertexCount, 3 * model.vertexCount]);
  }
  for (const model of models) model.free();
});

test('both builds give the same faces', async () => {
  const [simd, scalar] = [
    await load(bytes, { build: 'simd' }),
    await load(bytes, { build: 'scalar' }),
  ];
  for (let seed = 0; seed < 10; seed++) {
    const [a, b] = [simd.face(), scalar.face()];
    a.randomize({ seed });
    b.randomize({ seed });
    assert.equal(a.code, b.code, 'a face is the same everywhere');
    // Sums may be taken in another order: some 30 terms of f32 near 100 mm, a last bit of 8 nm
    // each, stay within 2 micrometres; a normal on an edge of 0.1 mm turns by 1e-3 at most.
    assert.ok(farthest(a.positions, b.positions) < 0.002);
    assert.ok(farthest(a.normals, b.normals) < 1e-3);
  }
  simd.free();
  scalar.free();
});
