// What the package writes (phiz/export), read back by three's loaders and the Khronos validator.
// The same files go through the crate's own readers in tests/offline/export.rs.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { after, before, describe, test } from 'node:test';

import { morphTargets, toGlb, toObj, toPly, toStl } from '../../pkg/export/index.js';
import { expressionTargets } from '../../pkg/export/targets.js';
import { load } from '../../pkg/index.js';

const require = createRequire(new URL('../../www/package.json', import.meta.url));
const loaders = new URL('../../www/node_modules/three/examples/jsm/loaders/', import.meta.url);
const { OBJLoader } = await import(new URL('OBJLoader.js', loaders));
const { PLYLoader } = await import(new URL('PLYLoader.js', loaders));
const { STLLoader } = await import(new URL('STLLoader.js', loaders));
const { GLTFLoader } = await import(new URL('GLTFLoader.js', loaders));
const { Vector3 } = await import('../../www/node_modules/three/build/three.module.js');
const validator = require('gltf-validator');
const { fitSphere } = await import('../../www/src/head/eyes.js');

/** What a text file with four decimals and a binary one with f32 must keep, mm. */
const KEPT = 0.01;

/** The largest distance between vertices `a` and `b`, mm; `at` gives the vertex of b's i-th. */
function farthest(a, b, at = (i) => i) {
  let most = 0;
  for (let i = 0; i < b.length / 3; i++) {
    const o = 3 * at(i);
    most = Math.max(most, Math.hypot(a[o] - b[3 * i], a[o + 1] - b[3 * i + 1], a[o + 2] - b[3 * i + 2]));
  }
  return most;
}

/** The vertices of all triangles, one after the other. */
const corners = (model) => Array.from(model.triangles, (corner) => model.uvVertices[corner]);

const parseGlb = (bytes) =>
  new Promise((done, fail) => new GLTFLoader().parse(bytes.buffer.slice(0), '', done, fail));

/** The JSON of a GLB. */
const jsonOf = (glb) => {
  const length = new DataView(glb.buffer, glb.byteOffset).getUint32(12, true);
  return JSON.parse(new TextDecoder().decode(glb.subarray(20, 20 + length)));
};

for (const name of ['model', 'synthetic']) {
  describe(`exports of ${name}.phiz`, () => {
    let model;
    let face;
    before(async () => {
      model = await load(await readFile(new URL(`../../www/public/${name}.phiz`, import.meta.url)));
      face = model.face();
      face.randomize({ seed: 11 });
    });
    after(() => model.free());

    test('OBJ', () => {
      const text = new TextDecoder().decode(toObj(face));
      for (const { source } of model.about.licences) assert.ok(text.includes(source), source);
      const meshes = new OBJLoader().parse(text).children;
      assert.deepEqual(
        meshes.map((mesh) => mesh.name),
        model.parts.map((part) => part.name.replaceAll(' ', '_')),
      );
      const vertices = corners(model);
      let first = 0;
      for (const [p, { geometry }] of meshes.entries()) {
        const read = geometry.getAttribute('position').array;
        assert.equal(read.length, 9 * model.parts[p].count);
        const at = (i) => vertices[first + i];
        assert.ok(farthest(face.positions, read, at) < KEPT);
        // Four decimals of a unit vector.
        assert.ok(farthest(face.normals, geometry.getAttribute('normal').array, at) < 1e-3);
        const uv = geometry.getAttribute('uv');
        const uvs = model.uvs;
        for (let i = 0; i < uv.count; i++) {
          const corner = model.triangles[first + i];
          assert.ok(Math.abs(uv.getX(i) - uvs[2 * corner]) < 1e-5);
          assert.ok(Math.abs(uv.getY(i) - uvs[2 * corner + 1]) < 1e-5);
        }
        first += read.length / 3;
      }
    });

    test('PLY', () => {
      const geometry = new PLYLoader().parse(toPly(face).buffer);
      assert.ok(farthest(face.positions, geometry.getAttribute('position').array) < KEPT);
      assert.ok(farthest(face.normals, geometry.getAttribute('normal').array) < 1e-6);
      assert.equal(geometry.getAttribute('position').count, model.vertexCount);
      assert.deepEqual(Array.from(geometry.index.array), corners(model));
      assert.equal(geometry.getAttribute('color').count, model.vertexCount);
    });

    test('colours of its own, in PLY and OBJ', () => {
      const colours = Uint8Array.from({ length: 3 * model.vertexCount }, (_, i) => (7 * i) % 256);
      const ply = toPly(face, { colours });
      const start = Buffer.from(ply.buffer).indexOf('end_header\n') + 11;
      for (const v of [0, 1, model.vertexCount - 1]) assert.deepEqual(ply.subarray(start + 27 * v + 24, start + 27 * v + 27), colours.subarray(3 * v, 3 * v + 3));
      const lines = new TextDecoder().decode(toObj(face, { colours })).split('\n').filter((line) => line.startsWith('v '));
      assert.deepEqual(lines[5].split(' ').slice(4), [15, 16, 17].map((i) => (((7 * i) % 256) / 255).toFixed(4)));
      assert.throws(() => toPly(face, { colours: colours.subarray(3) }), /three a vertex, not/);
      assert.throws(() => toObj(face, { colours: [...colours] }), /must be a Uint8Array/);
    });

    test('STL', () => {
      const geometry = new STLLoader().parse(toStl(face).buffer);
      const { array } = geometry.getAttribute('position');
      const standing = Float32Array.from(array, (_, i) => [array[i], array[i + 1], -array[i - 1]][i % 3]);
      const vertices = corners(model);
      // What closes it comes after.
      assert.ok(farthest(face.positions, standing.subarray(0, 3 * vertices.length), (i) => vertices[i]) < KEPT);
      // A slicer takes it for a body: each edge is there once in each direction.
      const points = Array.from({ length: standing.length / 3 }, (_, i) => standing.subarray(3 * i, 3 * i + 3).join(' '));
      const edges = new Set();
      for (let t = 0; t < points.length; t += 3) for (let k = 0; k < 3; k++) edges.add(`${points[t + k]}|${points[t + ((k + 1) % 3)]}`);
      assert.equal(edges.size, points.length, 'none is there twice');
      for (const edge of edges) assert.ok(edges.has(edge.split('|').reverse().join('|')), edge);
      // The neck and two openings of lids, which the mesh itself leaves open; behind lids nothing stands out.
      assert.ok(standing.length > 3 * vertices.length);
      const lids = standing.subarray(3 * vertices.length);
      assert.ok(Math.max(...lids.filter((_, i) => i % 3 === 2)) < Math.max(...face.positions.slice().filter((_, i) => i % 3 === 2)) - 20);
    });

    describe('GLB', () => {
      let glb;
      let mesh;
      before(async () => {
        glb = toGlb(face);
        const { scene } = await parseGlb(glb);
        mesh = scene.getObjectByName('face');
      });

      test('the Khronos validator finds nothing wrong', async () => {
        for (const bytes of [glb, toGlb(face, { targetNormals: false }), toGlb(face, { targets: false })]) {
          const { issues } = await validator.validateBytes(bytes);
          const { numErrors, numWarnings } = issues;
          assert.deepEqual({ numErrors, numWarnings }, { numErrors: 0, numWarnings: 0 }, JSON.stringify(issues.messages));
        }
      });

      test('who has measured targets gets the same file of them', () => {
        const measured = { controls: morphTargets(face), expressions: expressionTargets(face) };
        assert.ok(Buffer.from(glb).equals(Buffer.from(toGlb(face, { measured }))));
        const none = toGlb(face, { measured: { controls: [], expressions: [] } });
        assert.equal(jsonOf(none).meshes[0].extras, undefined);
      });

      test('the mesh is the face, in metres', () => {
        const read = mesh.geometry.getAttribute('position').array.map((x) => 1000 * x);
        const vertices = model.uvVertices;
        assert.ok(farthest(face.positions, read, (i) => vertices[i]) < KEPT);
        assert.deepEqual(Array.from(mesh.geometry.index.array), Array.from(model.triangles));
        assert.equal(jsonOf(glb).extras.phiz.code, face.code);
      });

      test('a target for each control, by its name', () => {
        assert.deepEqual(jsonOf(glb).meshes[0].extras.targetNames, model.controls.map((c) => c.name));
        assert.deepEqual(Object.keys(mesh.morphTargetDictionary), model.controls.map((c) => c.name));
        assert.ok(mesh.morphTargetInfluences.every((weight) => weight === 0));
      });

      test('driving the targets gives the mesh of the page', () => {
        const other = model.face();
        const at = new Vector3();
        const { direction } = Object.fromEntries(
          jsonOf(glb).meshes[0].extras.phiz.targets.map((target) => [target.name, target]),
        )[model.controls[0].name];
        assert.deepEqual(direction, [[0, 1]], 'a mode is one coefficient, one sigma');
        // Unusual people: three sigmas in many directions at once.
        for (const [seed, spread] of [[1, 1], [2, 2], [3, 3]]) {
          other.reset();
          other.randomize({ seed, spread });
          const wanted = other.coefficients;
          const from = face.coefficients;
          const weights = new Float64Array(model.controls.length);
          const { targets } = jsonOf(glb).meshes[0].extras.phiz;
          targets.forEach((target, t) => {
            if (target.direction.length > 1) return;
            const [[coefficient, change]] = target.direction;
            weights[t] = (wanted[coefficient] - from[coefficient]) / change;
          });
          mesh.morphTargetInfluences = Array.from(weights);
          // What the weights amount to is what the page is asked for.
          const reached = from.slice();
          targets.forEach((target, t) => {
            for (const [i, change] of target.direction) reached[i] += weights[t] * change;
          });
          other.coefficients = reached;
          const expected = other.positions.slice();
          const driven = new Float32Array(3 * model.vertexCount);
          for (let v = 0; v < model.vertexCount; v++) {
            mesh.getVertexPosition(v, at);
            driven.set([1000 * at.x, 1000 * at.y, 1000 * at.z], 3 * v);
          }
          const moved = farthest(face.positions, expected);
          assert.ok(moved > 3, `the two differ: ${moved} mm`);
          const error = farthest(expected, driven);
          assert.ok(error < 0.05, `${error} mm`);
        }
        other.free();
      });

      test('controls that move many coefficients drive the mesh too', () => {
        // Weights of all targets at once, whatever their directions are.
        const { targets } = jsonOf(glb).meshes[0].extras.phiz;
        const coefficients = face.coefficients.slice();
        targets.forEach((target, t) => {
          const weight = (((t * 7919) % 13) - 6) / 6;
          mesh.morphTargetInfluences[t] = weight;
          for (const [i, change] of target.direction) coefficients[i] += weight * change;
        });
        const other = model.face();
        other.coefficients = coefficients;
        const expected = other.positions.slice();
        other.free();
        const at = new Vector3();
        let error = 0;
        for (let v = 0; v < model.vertexCount; v++) {
          mesh.getVertexPosition(v, at).multiplyScalar(1000);
          error = Math.max(error, at.distanceTo(new Vector3().fromArray(expected, 3 * v)));
        }
        assert.ok(error < 0.05, `${error} mm`);
      });

      test('normals of the targets turn the shading the way the face does', () => {
        const targets = morphTargets(face);
        const index = targets.findIndex((target) => target.group === 'nose');
        const target = targets[index];
        const other = face.clone();
        const coefficients = face.coefficients;
        for (const [i, change] of target.direction) coefficients[i] += change;
        other.coefficients = coefficients;
        const expected = other.normals.slice();
        other.free();
        const normals = face.normals.slice();
        const rms = (a, b) => Math.sqrt(a.reduce((sum, x, i) => sum + (x - b[i]) ** 2, 0) / a.length);
        const turned = normals.map((x, i) => x + target.normals[i]);
        // To first order: what is left is what a large feature bends beyond it.
        const before = rms(expected, normals);
        assert.ok(before > 1e-3, `the nose turns its normals: ${before}`);
        const left = rms(expected, turned);
        assert.ok(left < 0.3 * before, `${left} of ${before}`);
      });
    });

    test('morph targets are those of the face without what is held on it', () => {
      const free = morphTargets(face);
      const held = face.clone();
      held.lock('nose');
      held.lockMeasure('face width');
      const code = held.code;
      const targets = morphTargets(held);
      assert.deepEqual(targets.map(({ name, direction }) => [name, direction]), free.map(({ name, direction }) => [name, direction]));
      for (const [i, target] of targets.entries()) assert.equal(farthest(target.positions, free[i].positions), 0, target.name);
      assert.deepEqual([held.locked, held.lockedMeasures, held.code], [['nose'], ['face width'], code]);
      held.free();
    });

    test('a face at the end of what coefficients may be is written as any other', async () => {
      const farthest255 = model.face();
      const ends = farthest255.coefficients;
      [ends[0], ends[3]] = [255, -254.5];
      farthest255.coefficients = ends;
      const plain = morphTargets(face);
      for (const i of [0, 3]) {
        const [target, usual] = [morphTargets(farthest255), plain].map((all) => all.find(({ direction }) => direction.length === 1 && direction[0][0] === i));
        // Vertices are linear in coefficients: rounding of f32 at some thousand mm is left.
        assert.ok(farthest(target.positions, usual.positions) < 0.01, target.name);
      }
      farthest255.free();
    });

    test('targets that were measured otherwise are refused with what is wrong', () => {
      const controls = morphTargets(face).slice(0, 1);
      const expressions = expressionTargets(face);
      assert.deepEqual(jsonOf(toGlb(face, { measured: { controls, expressions } })).meshes[0].extras.targetNames.slice(0, 1), [controls[0].name]);
      const bad = (/** @type {object} */ change) => ({ controls: [{ ...controls[0], ...change }], expressions });
      for (const [measured, said] of [
        [{}, /measured controls must be an array/],
        [{ controls }, /measured expressions must be an array/],
        [bad({ positions: new Float32Array(3) }), /three a vertex, not 3/],
        [bad({ normals: controls[0].normals.map((x, i) => (i === 7 ? NaN : x)) }), /vertex 2 is NaN/],
        [bad({ name: 3 }), /must have a name/],
      ]) {
        assert.throws(() => toGlb(face, { measured }), said);
      }
    });

    test('an option that is misspelled is refused, and null is none', () => {
      for (const [write, options] of [[toObj, { colors: 1 }], [toPly, { colour: 1 }], [toGlb, { target: false }]]) {
        assert.throws(() => write(face, options), new RegExp(`^Error: ${write.name} knows no option "${Object.keys(options)}"$`));
        assert.throws(() => write(face, true), new RegExp(`^TypeError: the options of ${write.name} must be an object$`));
      }
      assert.deepEqual(toPly(face, null), toPly(face));
    });

    test('a freed face is refused', () => {
      const gone = model.face();
      gone.free();
      for (const write of [toObj, toPly, toStl, toGlb]) assert.throws(() => write(gone), /freed/);
      for (const none of [undefined, null, {}, model]) {
        for (const write of [toObj, toPly, toStl, toGlb]) assert.throws(() => write(none), /must be a Face/);
      }
    });
  });
}

describe('exports of a face with an expression', () => {
  const shown = { jawOpen: 0.4, mouthSmileLeft: 0.75, eyeLookUpLeft: 0.5 };
  let model;
  let face;
  before(async () => {
    const file = (name) => readFile(new URL(`../../www/public/${name}.phiz`, import.meta.url));
    model = await load(await file('model'));
    await model.loadExpressions(await file('expressions'));
    face = model.face();
    face.randomize({ seed: 5 });
    face.expression = shown;
  });
  after(() => model.free());

  test('OBJ, PLY and STL have the face as it is shown', () => {
    const rest = face.clone();
    rest.expression = {};
    assert.ok(farthest(face.positions.slice(), rest.positions) > 3, 'it is shown');
    const vertices = corners(model);
    const ply = new PLYLoader().parse(toPly(face).buffer).getAttribute('position').array;
    assert.ok(farthest(face.positions, ply) < KEPT);
    const stl = new STLLoader().parse(toStl(face).buffer).getAttribute('position').array;
    const standing = Float32Array.from(stl, (_, i) => [stl[i], stl[i + 1], -stl[i - 1]][i % 3]);
    assert.ok(farthest(face.positions, standing.subarray(0, 3 * vertices.length), (i) => vertices[i]) < KEPT);
    const [first] = new OBJLoader().parse(new TextDecoder().decode(toObj(face))).children;
    assert.ok(farthest(face.positions, first.geometry.getAttribute('position').array, (i) => vertices[i]) < KEPT);
    const plain = toGlb(face, { targets: false });
    assert.ok(jsonOf(plain).meshes[0].weights === undefined);
    rest.free();
  });

  test('GLB has a target for each expression by ARKit’s name, which gives the mesh of the page', async () => {
    const glb = toGlb(face);
    const { issues } = await validator.validateBytes(glb);
    assert.deepEqual([issues.numErrors, issues.numWarnings], [0, 0], JSON.stringify(issues.messages));
    const mesh = (await parseGlb(glb)).scene.getObjectByName('face');
    const { targetNames, phiz } = jsonOf(glb).meshes[0].extras;
    assert.deepEqual(targetNames, [...model.controls.map(({ name }) => name), ...model.expressions]);
    assert.deepEqual(phiz.expressions, model.expressions);
    assert.equal(model.expressions.length, 51);
    // It opens with the expression that it was shown with.
    for (const [name, at] of Object.entries(mesh.morphTargetDictionary)) {
      assert.ok(Math.abs(mesh.morphTargetInfluences[at] - (shown[name] ?? 0)) < 1e-6, name);
    }
    const probe = face.clone();
    const at = new Vector3();
    for (const name of ['jawOpen', 'mouthSmileRight', 'eyeBlinkLeft', 'eyeLookInRight', 'cheekPuff', 'mouthRollLower']) {
      probe.expression = { [name]: 1 };
      const expected = probe.positions.slice();
      mesh.morphTargetInfluences.fill(0);
      mesh.morphTargetInfluences[mesh.morphTargetDictionary[name]] = 1;
      const driven = new Float32Array(expected.length);
      for (let v = 0; v < model.vertexCount; v++) {
        mesh.getVertexPosition(v, at);
        driven.set([1000 * at.x, 1000 * at.y, 1000 * at.z], 3 * v);
      }
      const error = farthest(expected, driven);
      assert.ok(error < 0.05, `${name}: ${error} mm`);
    }
    probe.free();
  });

  test('a GLB with an appearance has pictures on skin and eyes and meshes beside the face, and the same targets', async () => {
    const { PNG } = require('pngjs');
    const picture = { mimeType: 'image/png', bytes: PNG.sync.write(new PNG({ width: 4, height: 4 })) };
    const row = {
      name: 'a tooth',
      positions: Float32Array.of(0, 0, 80, 10, 0, 80, 0, 10, 80),
      normals: Float32Array.of(0, 0, 1, 0, 0, 1, 0, 0, 1),
      colours: Float32Array.of(1, 0.8, 0.6, 1, 0.8, 0.6, 1, 0.8, 0.6),
      triangles: Uint32Array.of(0, 1, 2),
      roughness: 0.3,
      targets: { jawOpen: Float32Array.of(0, -10, 0, 0, -10, 0, 0, -10, 0) },
    };
    // Hair that is shaved off is nothing, and not in the file.
    const none = new Float32Array();
    const bald = { ...row, name: 'hair', positions: none, normals: none, colours: none, triangles: new Uint32Array(), targets: { jawOpen: none } };
    const reach = 1.9;
    const skin = { colour: picture, normal: picture, surface: picture };
    const glb = toGlb(face, { appearance: { skin, eyes: { colour: picture, reach }, parts: [row, bald] } });
    const { issues } = await validator.validateBytes(glb);
    assert.deepEqual([issues.numErrors, issues.numWarnings], [0, 0], JSON.stringify(issues.messages));
    const json = jsonOf(glb);
    assert.deepEqual(json.nodes.map(({ name }) => name), ['face', 'a tooth']);
    assert.equal(json.images.length, 4);
    const { targetNames } = json.meshes[0].extras;
    assert.deepEqual(targetNames, [...model.controls.map(({ name }) => name), ...model.expressions]);
    const [onSkin, onEyes] = json.meshes[0].primitives;
    assert.equal(onSkin.attributes.COLOR_0, undefined, 'colours a vertex would be multiplied with the picture');
    assert.deepEqual(onSkin.targets, onEyes.targets);
    // All triangles are there, each once.
    const many = (primitive) => json.accessors[primitive.indices].count / 3;
    const eyeballs = model.parts.filter(({ name }) => /eyeball/.test(name));
    assert.equal(many(onEyes), eyeballs.reduce((sum, { count }) => sum + count, 0));
    assert.equal(many(onSkin) + many(onEyes), model.triangles.length / 3);
    assert.deepEqual(json.meshes[1].weights.map((w) => Math.round(100 * w)), [40]);
    assert.deepEqual(json.meshes[1].extras.targetNames, ['jawOpen']);

    // What would make a file that nobody can open names what is wrong.
    const { positions, triangles } = row;
    for (const [wrong, reason] of [
      [{}, /skin.colour/],
      [{ skin: { ...skin, normal: undefined } }, /skin.normal/],
      [{ skin: { ...skin, surface: { mimeType: 'image/webp', bytes: picture.bytes } } }, /skin.surface/],
      [{ skin, eyes: { colour: picture } }, /eyes.reach .* not undefined/],
      [{ skin, parts: {} }, /parts .* an array/],
      [{ skin, parts: [null] }, /part 0 .* a name/],
      ...[
        [{ positions: positions.with(4, NaN) }, 'positions', 'one of vertex 1 is NaN'],
        [{ positions: positions.subarray(1) }, 'positions', '9 numbers, three a vertex, not 8'],
        [{ positions: Array.from(positions) }, 'positions', 'a Float32Array'],
        [{ normals: positions.subarray(3) }, 'normals', '9 numbers, three a vertex, not 6'],
        [{ colours: new Float32Array(3) }, 'colours', '9 numbers, three a vertex, not 3'],
        [{ triangles: Uint32Array.of(0, 1, 3) }, 'triangles', 'vertex 3, and it has 3'],
        [{ triangles: triangles.subarray(1) }, 'triangles', 'are 2 corners'],
        [{ triangles: [0, 1, 2] }, 'triangles', 'a Uint32Array'],
        [{ roughness: undefined }, 'roughness', 'from 0 to 1, not undefined'],
        [{ targets: undefined }, 'targets', 'an object'],
        [{ targets: { jawOpen: new Float32Array(12) } }, 'target "jawOpen"', 'three a vertex, not 12'],
        [{ targets: { jawOpen: new Float32Array(9).fill(Infinity) } }, 'target "jawOpen"', 'vertex 0 is Infinity'],
      ].map(([part, what, why]) => [{ skin, parts: [bald, { ...row, ...part }] }, new RegExp(`^the ${what} of the part "a tooth" .*${why}$`)]),
    ]) {
      assert.throws(() => toGlb(face, { appearance: wrong }), (error) => error instanceof Error && reason.test(error.message), `${reason}`);
    }

    // Each eyeball's picture is around its gaze: what looks ahead at rest is in the middle, and an angle is as long
    // anywhere. The file's coordinates count from the top.
    const view = json.bufferViews[json.accessors[onSkin.attributes.TEXCOORD_0].bufferView];
    const start = 28 + new DataView(glb.buffer, glb.byteOffset).getUint32(12, true) + view.byteOffset;
    const uv = new Float32Array(glb.slice(start, start + view.byteLength).buffer);
    const rest = face.clone();
    rest.expression = {};
    for (const { first, count } of eyeballs) {
      const corner = [...new Set(model.triangles.subarray(3 * first, 3 * (first + count)))];
      const centre = new Vector3();
      fitSphere(rest.positions, [...new Set(corner.map((c) => model.uvVertices[c]))], centre);
      for (const c of corner) {
        const point = new Vector3().fromArray(rest.positions, 3 * model.uvVertices[c]).sub(centre);
        const away = point.angleTo(new Vector3(0, 0, 1));
        const drawn = 2 * reach * Math.hypot(uv[2 * c] - 0.5, uv[2 * c + 1] - 0.5);
        // It is not quite a ball: 2 degrees.
        assert.ok(Math.abs(drawn - Math.min(away, reach)) < 0.035, `${drawn} for ${away}`);
        if (Math.abs(point.y) > 1) assert.equal(Math.sign(uv[2 * c + 1] - 0.5), -Math.sign(point.y), 'up is up');
      }
    }
    rest.free();
    // Elsewhere they are the model's.
    const skinCorner = model.triangles[3 * model.parts.find(({ name }) => name === 'skin').first];
    assert.ok(Math.abs(uv[2 * skinCorner] - model.uvs[2 * skinCorner]) < 1e-6);
  });

  test('its targets are as long as what can be seen of them: a GLB with all is below 31 MB', async () => {
    const glb = toGlb(face);
    assert.ok(glb.length < 31e6, `${glb.length} bytes`);
    // Normals that were left out, wholly or in part, are off by no more than the package says, a hundredth.
    const mesh = (await parseGlb(glb)).scene.getObjectByName('face');
    const wanted = [...morphTargets(face), ...expressionTargets(face)];
    let most = 0;
    let kept = 0;
    for (const [t, { normals }] of wanted.entries()) {
      const { array } = mesh.geometry.morphAttributes.normal[t];
      most = Math.max(most, farthest(normals, array, (corner) => model.uvVertices[corner]));
      kept = Math.max(kept, ...array);
    }
    assert.ok(most < 0.0101, `${most}`);
    assert.ok(kept > 0.1, 'normals do turn');
  });
});
