// What can be done to a face and undone, without a page around it.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { afterEach, beforeEach, describe, test } from 'node:test';
import { load } from '../../pkg/index.js';
import { createEditor } from '../../www/src/editing/editor.js';

const file = (/** @type {string} */ name) => readFile(new URL(`../../www/public/${name}.phiz`, import.meta.url));
const model = await load(await file('model'));

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
});
