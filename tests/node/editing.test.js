// What can be done to a face and undone, without a page around it.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { afterEach, beforeEach, describe, test } from 'node:test';
import { load } from '../../pkg/index.js';
import { createEditor } from '../../www/src/editing/editor.js';

const file = (/** @type {string} */ name) => readFile(new URL(`../../www/public/${name}.phiz`, import.meta.url));
const model = await load(await file('model'));
await model.loadExpressions(await file('expressions'));

describe('editing', () => {
  /** @type {import('../../www/src/editing/editor.js').Editor} */
  let editor;
  beforeEach(() => void (editor = createEditor(model, model.face(), {})));
  afterEach(() => editor.face.free());
  /** A press of a key of a slider. @param {number} value */
  const press = (value) => {
    editor.move('nose 1', value);
    editor.finish('slide nose 1');
  };

  test('presses that take back each other are no step', () => {
    const at = editor.face.get('nose 1');
    press(0.6);
    press(at);
    assert.equal(editor.canUndo, false);
    // And what comes next is not one with the step before them.
    press(0.7);
    editor.part();
    press(0.8);
    press(0.7);
    press(0.9);
    editor.undo();
    assert.equal(editor.face.get('nose 1').toFixed(3), '0.700');
    editor.undo();
    assert.equal(editor.face.get('nose 1'), at);
    assert.equal(editor.canUndo, false);
  });

  test('a gesture that is given up leaves the face, its colours and what is locked as they were, and no step', () => {
    press(0.6);
    editor.toggleLock('mouth');
    const before = editor.state;
    let told = 0;
    editor.onStep(() => void (told += 1));
    editor.cancel();
    assert.equal(told, 0, 'there was nothing to give up');
    editor.move('nose 1', 0.9);
    editor.moveColours({ skin: 0.9 });
    editor.moveExpression({ jawOpen: 0.5 });
    editor.cancel();
    assert.deepEqual(editor.state, before);
    assert.equal(told, 1);
    editor.finish('slide nose 1');
    editor.undo();
    assert.deepEqual(editor.face.locked, []);
  });

  test('a reset of all leaves what is locked as it looks, and the photo that it is of', () => {
    const colouring = { skin: 0.9 };
    editor.take({ code: editor.face.code, colouring }, 7);
    editor.toggleLock('nose');
    editor.reset();
    assert.deepEqual([editor.colouring, editor.photo], [colouring, 7]);
    editor.toggleLock('nose');
    editor.reset();
    assert.deepEqual([editor.colouring, editor.photo], [{}, 0]);
  });

  test('an expression that comes late is of every state of the face that it was for, and of no other', () => {
    const { face } = editor;
    /** @type {[string, Record<string, number>][]} */
    const kept = [];
    editor.onStep(() => void kept.push([editor.awaited, face.expression]));
    // A face has fewer digits.
    const [asked, smile] = [{ mouthSmileLeft: 0.8 }, { mouthSmileLeft: Math.fround(0.8) }];
    const came = editor.awaitExpression('ABC');
    editor.set('nose 1', 0.9);
    const held = editor.state;
    assert.deepEqual(kept, [['ABC', {}]]);
    came(asked);
    assert.deepEqual([kept.at(-1), kept.length], [['', smile], 2], 'what was done meanwhile is kept with it');
    editor.undo();
    assert.deepEqual(face.expression, smile);
    editor.redo();
    assert.deepEqual(face.expression, smile);
    editor.moveFrom(held, () => {});
    editor.finish('nothing');
    assert.deepEqual(face.expression, smile);
    editor.undo();
    assert.equal(editor.canUndo, false, 'what is the same face is no step');

    // Who took it off meanwhile does not get it, unless that is undone.
    for (const take of [() => editor.reset(), () => editor.take({ code: face.code, expression: {} })]) {
      editor.express({});
      const late = editor.awaitExpression('DEF');
      take();
      assert.equal(editor.awaited, '');
      late(asked);
      assert.deepEqual(face.expression, {});
      editor.undo();
      assert.deepEqual(face.expression, smile);
    }
    // Nothing was done: nobody is told.
    const many = kept.length;
    const other = createEditor(model, model.face(), {});
    other.onStep(() => void kept.push(['other', {}]));
    other.awaitExpression('GHI')(asked);
    assert.deepEqual([other.face.expression, other.canUndo, kept.length], [smile, false, many]);
    other.face.free();
  });

  test('of faces that are asked for, the newest is wanted', () => {
    const first = editor.ask();
    assert.ok(first());
    press(0.6);
    assert.ok(first(), 'a slider is no other face');
    const second = editor.ask();
    assert.deepEqual([first(), second()], [false, true]);
    for (const other of [() => editor.take({ code: editor.face.code }), () => editor.undo(), () => editor.reset(), () => editor.randomise({ seed: 1 })]) {
      const before = editor.ask();
      other();
      assert.equal(before(), false);
    }
  });
});
