// Marks of the skin: how they are kept, where they are, and what becomes of them when faces are mixed.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { load, prepare } from '../../pkg/index.js';
import { mirroredColouring } from '../../www/src/editing/mirror.js';
import { mixture, readColouring, readKept } from '../../www/src/head/colouring.js';
import { createMarking, placed, placeNear } from '../../www/src/head/marking.js';
import { decodeMarks, encodeMarks, FIRST, KINDS, marksOf, MOST, SIZES, skinTriangles } from '../../www/src/head/marks.js';
import { coloursAlong } from '../../www/src/head/someone.js';
import { decodeColouring, encodeColouring, joinHash, splitHash } from '../../www/src/keep/addresscode.js';

const { Vector3 } = await import('../../www/node_modules/three/build/three.module.js');

const root = new URL('../../', import.meta.url);
await prepare({ build: 'simd', wasm: await readFile(new URL('pkg/simd/phiz_bg.wasm', root)) });
const model = await load(await readFile(new URL('www/public/model.phiz', root)));
const face = model.face();
const triangles = skinTriangles(model);

/** @type {import('../../www/src/head/marks.js').Mark[]} */
const SOME = [
  { kind: 'mole', at: { triangle: 1234, b: 17, c: 200 }, size: 3.4, tone: 0.61, form: 0.4, strength: 1 },
  { kind: 'scar', at: { triangle: 20_001, b: 0, c: 0 }, to: { triangle: 20_040, b: 255, c: 0 }, size: 0.5, tone: 0, form: 0.5, strength: 0.33 },
  { kind: 'birthmark', at: { triangle: 65_535, b: 1, c: 2 }, size: 99.5, tone: 1, form: 0.07, strength: 0.5 },
];
const codeOf = (/** @type {number[]} */ ...bytes) => Buffer.from(bytes).toString('base64url');
const MOLE = [0, 8, 0, 5, 10, 10, 40, 60, 40, 100];

describe('marks that are kept', () => {
  test('are what they were', () => {
    assert.deepEqual(decodeMarks(encodeMarks(SOME)), SOME);
    assert.equal(encodeMarks([]), '');
    for (const kind of KINDS) {
      for (const size of [SIZES[kind].least, SIZES[kind].most]) {
        const mark = { ...SOME[kind === 'scar' ? 1 : 0], kind, size };
        assert.deepEqual(decodeMarks(encodeMarks([mark])), [mark]);
      }
      const first = { ...SOME[kind === 'scar' ? 1 : 0], kind, ...FIRST[kind] };
      assert.deepEqual(decodeMarks(encodeMarks([first])), [first]);
    }
  });

  test('are the same letters in every version', () => {
    // A mole on the triangle 5, of 4 mm.
    assert.equal(codeOf(...MOLE), 'AAgABQoKKDwoZA');
    assert.deepEqual(decodeMarks('AAgABQoKKDwoZA'), [{ kind: 'mole', at: { triangle: 5, b: 10, c: 10 }, size: 4, tone: 0.6, form: 0.4, strength: 1 }]);
    assert.deepEqual(KINDS, ['mole', 'scar', 'birthmark']);
  });

  test('of kinds that are not known yet are left out, and what is known of others stays', () => {
    assert.deepEqual(decodeMarks(codeOf(77, 3, 1, 2, 3, ...MOLE)), decodeMarks(codeOf(...MOLE)));
    // A mole of which a later version tells more.
    assert.deepEqual(decodeMarks(codeOf(0, 9, ...MOLE.slice(2), 44)), decodeMarks(codeOf(...MOLE)));
  });

  test('are refused when they are none', () => {
    for (const [what, code] of Object.entries({
      'no base64': '!',
      'cut short': codeOf(...MOLE.slice(0, -1)),
      'without a length': codeOf(0),
      'shorter than a mark': codeOf(0, 7, ...MOLE.slice(2, 9)),
      'a scar without an end': codeOf(1, ...MOLE.slice(1)),
      'beside its triangle': codeOf(...MOLE.with(4, 250)),
      'of no size': codeOf(...MOLE.with(6, 0)),
      'too large': codeOf(...MOLE.with(6, 200)),
      'more than all': codeOf(...MOLE.with(9, 101)),
      'too many': codeOf(...new Array(MOST + 1).fill(MOLE).flat()),
    })) {
      assert.throws(() => decodeMarks(code), Error, what);
      assert.throws(() => decodeColouring(`AAA~${code}`), Error, what);
      assert.deepEqual(readKept({ skin: 0.5, marks: code }), { skin: 0.5 }, what);
    }
    assert.equal(decodeMarks(codeOf(...new Array(MOST).fill(MOLE).flat())).length, MOST);
    for (const marks of [7, null, [SOME[0]], {}]) assert.deepEqual(readKept({ marks }), {});
  });
});

describe('links', () => {
  const marks = encodeMarks(SOME);

  test('with marks have them after their colours', () => {
    const colouring = readColouring({ skin: 0.5, marks });
    const code = encodeColouring(colouring);
    assert.equal(code, `${encodeColouring({ skin: 0.5 })}~${marks}`);
    assert.deepEqual(decodeColouring(code), colouring);
    const parts = { code: 'face', expression: '', colouring: code };
    assert.equal(joinHash(parts), `face~~${code}`);
    assert.deepEqual(splitHash(`#${joinHash(parts)}`), parts);
    // As a sentence ends with one, and as some programs write it.
    assert.deepEqual(splitHash(`#${joinHash(parts).replaceAll('~', '%7E')}.`), parts);
    // Of a face that has nothing but them.
    assert.equal(encodeColouring({ marks }), `~${marks}`);
    assert.deepEqual(decodeColouring(`~${marks}`), { marks });
  });

  test('without marks are as they were', () => {
    assert.equal(joinHash({ code: 'face', expression: 'Ag8', colouring: encodeColouring({ skin: 0.5, freckles: 0.2 }) }), 'face~Ag8~ADIPFA');
    assert.deepEqual(splitHash('#face~Ag8~ADIPFA'), { code: 'face', expression: 'Ag8', colouring: 'ADIPFA' });
    assert.deepEqual(decodeColouring('ADIPFA'), { skin: 0.5, freckles: 0.2 });
    assert.equal(joinHash({ code: 'face', expression: '', colouring: encodeColouring({}) }), 'face');
    for (const hash of ['face', 'face~~', 'face~~~']) assert.deepEqual(splitHash(hash), { code: 'face', expression: '', colouring: '' });
    assert.deepEqual(Object.keys(decodeColouring('ADIPFA')), ['skin', 'freckles']);
  });
});

describe('places', () => {
  test('on the skin are found again, a tenth of a millimetre from where they were asked for', () => {
    const positions = face.positions.slice();
    for (const { triangle } of SOME.slice(0, 2).map(({ at }) => at)) {
      const there = placed(triangles, positions, { triangle, b: 80, c: 90 }, new Vector3());
      const found = placed(triangles, positions, placeNear(triangles, positions, there), new Vector3());
      assert.ok(found.distanceTo(there) < 0.1);
      // Off the skin it is the place below.
      const corners = [0, 1, 2].map((k) => new Vector3().fromArray(positions, 3 * triangles[3 * triangle + k]));
      const out = corners[1].clone().sub(corners[0]).cross(corners[2].clone().sub(corners[0])).normalize();
      const below = placed(triangles, positions, placeNear(triangles, positions, there.clone().addScaledVector(out, 0.5)), new Vector3());
      assert.ok(below.distanceTo(there) < 0.1);
    }
  });

  test('are those of the other side in the mirror, and the first again in another', () => {
    const colouring = { parting: 0.4, marks: encodeMarks(SOME.slice(0, 2)) };
    const mirrored = mirroredColouring(colouring, model);
    assert.notEqual(mirrored.marks, colouring.marks);
    const { mirror } = model;
    const positions = face.positions.slice();
    // On a head whose sides are alike to the digit.
    const even = positions.map((value, i) => {
      const other = positions[3 * mirror[Math.floor(i / 3)] + (i % 3)];
      return i % 3 === 0 ? (value - other) / 2 : (value + other) / 2;
    });
    const where = (/** @type {import('../../www/src/head/marks.js').Place} */ place) => placed(triangles, even, place, new Vector3());
    for (const [i, mark] of marksOf(mirrored).entries()) {
      for (const end of /** @type {const} */ (['at', 'to'])) {
        const [own, other] = [SOME[i][end], mark[end]];
        if (!own || !other) continue;
        const there = where(other);
        assert.ok(where(own).distanceTo(new Vector3(-there.x, there.y, there.z)) < 1e-4);
        assert.ok(Math.abs(there.x) > 1, 'it is not in the middle');
      }
    }
    assert.deepEqual(mirroredColouring(mirrored, model), readColouring({ marks: colouring.marks }));
    assert.equal(mirroredColouring({}, model).marks, undefined);
  });

  test('beside the mesh are nowhere, and scars tell where nothing grows', () => {
    const marking = createMarking({ positions: face.positions.slice(), normals: face.normals.slice(), triangles });
    const bald = marking.lay({ marks: encodeMarks(SOME.map((mark) => ({ ...mark, strength: 1 }))) });
    assert.equal(marking.uniforms.markCount.value, 2, 'the model has 32,096 triangles of skin');
    assert.equal(bald.length, 1);
    const begin = placed(triangles, face.positions, SOME[1].at, new Vector3());
    assert.ok(begin.distanceTo(new Vector3(...bald[0])) < 1e-4);
    assert.deepEqual(marking.lay({}), []);
    assert.equal(marking.uniforms.markCount.value, 0);
  });
});

describe('the marks of several faces', () => {
  const [mole, scar] = SOME;
  const [a, b] = [{ skin: 0.2, marks: encodeMarks([mole]) }, { skin: 0.6, marks: encodeMarks([scar]) }];

  test('fade as they count less', () => {
    assert.deepEqual(marksOf(mixture([[a, 0.75], [b, 0.25]])), [{ ...mole, strength: 0.75 }, { ...scar, strength: 0.08 }]);
    assert.deepEqual(mixture([[a, 1], [b, 0]]), a);
    assert.deepEqual(mixture([[a, 0], [b, 1]]), b);
  });

  test('stay where both have them', () => assert.deepEqual(mixture([[a, 0.5], [{ ...a, skin: 0.4 }, 0.5]]), { marks: a.marks }));

  test('are the strongest, of too many', () => {
    const many = (/** @type {number} */ from, /** @type {number} */ strength) =>
      encodeMarks(Array.from({ length: MOST }, (_, i) => ({ ...mole, at: { ...mole.at, triangle: from + i }, strength: strength - 0.02 * i })));
    const left = marksOf(mixture([[{ marks: many(0, 1) }, 0.6], [{ marks: many(100, 1) }, 0.4]]));
    assert.equal(left.length, MOST);
    assert.deepEqual(left.map(({ at }) => at.triangle), Array.from({ length: MOST }, (_, i) => i));
  });

  test('stay when somebody grows older', () => assert.equal(coloursAlong(a, { age: 0.2 }, { age: 0.9 }).marks, a.marks));
});
