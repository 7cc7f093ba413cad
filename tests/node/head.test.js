// The head that the page draws, without a page: what of a face it takes over.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { describe, test } from 'node:test';
import { load } from '../../pkg/index.js';
import { measureTurns } from '../../www/src/head/eyeturns.js';
import { atRest, createHead } from '../../www/src/head/head.js';
import { measureShifts } from '../../www/src/head/shifts.js';

// Brows and irises are painted, and nobody looks.
const brush = new Proxy({}, { get: (_, name) => () => (name === 'createRadialGradient' ? { addColorStop() {} } : undefined), set: () => true });
globalThis.document = /** @type {any} */ ({ createElement: () => ({ getContext: (/** @type {string} */ kind) => (kind === '2d' ? brush : null) }) });

const file = (/** @type {string} */ name) => readFileSync(new URL(`../../www/public/${name}.phiz`, import.meta.url));
const model = await load(file('model'));
await model.loadExpressions(file('expressions'));
const face = model.face();
const blank = { size: 1, rgba: new Uint8Array(4) };

const head = createHead(model, atRest(model, face), /** @type {any} */ ({ open: new Float32Array(model.vertexCount).fill(1), paint: { map: blank, frame: [0, 0, 1, 1] }, pores: blank }));
head.expressBy(measureTurns(model), (vertices) => measureShifts(model, vertices));

describe('the head', () => {
  test('has eyes behind their lids by the size that they have now', () => {
    const [eye] = head.group.children.filter(({ name }) => name === 'right eye');
    /** @type {{ behind?: { value: number } }} */
    const uniforms = {};
    /** @type {any} */ (eye).material.onBeforeCompile({ uniforms, vertexShader: '', fragmentShader: '' });
    const behind = () => {
      head.update(face);
      return uniforms.behind?.value;
    };
    assert.equal(behind(), 0);
    face.expression = { eyeBlinkRight: 0.5 };
    const before = behind();
    face.randomize({ seed: 3 });
    const now = behind();
    assert.notEqual(now, before);
    assert.equal(now, behind());
  });

  test('has no more to upload than all of it, however long nothing is drawn', () => {
    face.expression = {};
    const { position, normal } = head.skin.geometry.attributes;
    /** Of the numbers of an attribute those that go to the graphics card. @param {any} attribute */
    const uploaded = ({ array, updateRanges }) => {
      const found = new Uint8Array(array.length);
      for (const { start, count } of updateRanges) found.fill(1, start, start + count);
      return found;
    };
    const control = model.controls.find(({ group }) => group === 'nose')?.name ?? '';
    for (let i = 0; i < 200; i++) {
      face.set(control, 0.2 + 0.003 * i);
      head.update(face, face.changed);
    }
    for (const attribute of [position, normal]) {
      assert.ok(/** @type {any} */ (attribute).updateRanges.length < 40);
      const [first, end] = face.changed;
      assert.ok(uploaded(attribute).subarray(3 * first, 3 * end).every(Boolean));
    }
    // The first to go are not lost.
    face.randomize({ seed: 4 });
    head.update(face);
    for (let i = 0; i < 100; i++) head.update(face, [0, 1]);
    assert.ok(uploaded(position).every(Boolean));
  });
});
