// What the stage is told to show, without one: whose shape and whose colours.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { createDisplay } from '../../www/src/stage/display.js';
import { distances, heatColours, scaleEnd } from '../../www/src/stage/heat.js';

/** A head that knows whose it is, on a stage that draws nothing. */
function setUp() {
  const model = { vertexCount: 2 };
  const face = (/** @type {number} */ x) => ({ model, expression: {}, positions: Float32Array.of(x, 0, 0, 0, 0, 0) });
  /** @type {any} */
  const head = {
    updates: 0,
    /** @type {object | null} */
    of: null,
    colouring: {},
    wears: true,
    wornStrength: { value: 0 },
    heatStrength: { value: 0 },
    update(/** @type {object} */ from) {
      head.updates += 1;
      head.of = from;
    },
    paint: (/** @type {object} */ colours) => void (head.colouring = colours),
    paintHeat() {},
  };
  /** @type {{ pose: (side: 'left' | 'right') => void } | null} */
  let sides = null;
  const scene = { split: (/** @type {typeof sides} */ now) => void (sides = now), shapeChanged() {} };
  const own = face(0);
  let colours = { skin: 0.5 };
  const display = createDisplay({ face: own, head, scene, colouring: (of = colours) => of, onScale() {} });
  return {
    display,
    head,
    own,
    other: face(1),
    recolour: (/** @type {typeof colours} */ now) => void (colours = now),
    draw: () => (['left', 'right']).map((side) => (sides?.pose(side), head.of)),
  };
}

describe('the stage', () => {
  test('shows another face in its own colours, whatever those of the face become', () => {
    const { display, head, other, recolour } = setUp();
    const theirs = { skin: 0.9 };
    display.show(other, { colours: theirs });
    recolour({ skin: 0.1 });
    display.repaint();
    assert.equal(head.colouring, theirs);
    display.show(null);
    assert.deepEqual(head.colouring, { skin: 0.1 });
    recolour({ skin: 0.2 });
    display.repaint();
    assert.deepEqual(head.colouring, { skin: 0.2 });
  });

  test('has two faces side by side when they are drawn, and does no more for them before that', () => {
    const { display, head, own, other, draw } = setUp();
    display.refresh();
    assert.equal(head.updates, 1);
    display.split(other);
    display.refresh([0, 1]);
    assert.equal(head.updates, 1);
    assert.deepEqual(draw(), [other, own]);
    display.split(null);
    assert.equal(head.of, own);
    assert.equal(head.updates, 4);
  });
});

describe('distances', () => {
  test('are from a face that is looked up when it is another, and not with each change of this one', () => {
    const { display, head, own } = setUp();
    const reads = { positions: 0 };
    const from = {
      code: 'a',
      expression: {},
      get positions() {
        reads.positions += 1;
        return Float32Array.of(0, 0, 0, 0, this.code === 'a' ? 0 : 40, 0);
      },
    };
    /** @type {number[]} */
    let seen = [];
    head.paintHeat = (/** @type {Float32Array} */ colours) => void (seen = [...colours]);
    display.heat(/** @type {any} */ (from));
    const alike = seen;
    own.positions[0] = 40;
    display.refresh();
    assert.notDeepEqual(seen, alike);
    own.positions[0] = 0;
    display.refresh();
    assert.deepEqual([seen, reads.positions], [alike, 1]);
    from.code = 'b';
    display.refresh();
    assert.equal(reads.positions, 2);
    assert.notDeepEqual(seen, alike);
    own.expression = { jawOpen: 1 };
    display.refresh();
    assert.equal(reads.positions, 3);
  });

  test('end where all but one in a hundred do', () => {
    const away = distances(Float32Array.of(3, 4, 12, 0, 0, 0), Float32Array.of(0, 0, 0, 0, 0, 0));
    assert.deepEqual([...away], [13, 0]);
    const ends = [0.5, 1, 2, 3, 4, 6, 8, 10, 15, 20, 30];
    for (const count of [1, 2, 100, 101, 1000]) {
      for (const most of [0, 0.3, 0.5, 0.51, 2, 7, 29.9, 30, 31, 1e4]) {
        const all = Float32Array.from({ length: count }, (_, i) => (most * ((i * 37) % count)) / count);
        const seen = all.slice().sort()[Math.floor(0.99 * (count - 1))];
        assert.equal(scaleEnd(all), ends.find((end) => seen <= end) ?? 30, `${count} up to ${most}`);
      }
    }
    const colours = new Float32Array(6);
    heatColours(Float32Array.of(0, 5), 3, colours);
    assert.deepEqual([...colours].map((value) => Math.round(255 * value)), [68, 1, 84, 253, 231, 37]);
  });
});
