// What is shown of longer hair while it grows beside the page, whoever has sat for a portrait meanwhile: on strands of nobody's.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { Color, Vector3 } from '../../www/node_modules/three/build/three.module.js';
import { hairLength } from '../../www/src/hair/length.js';
import { layRibbons, ribbonsOf } from '../../www/src/hair/ribbons.js';
import { ANCHORS, POINTS } from '../../www/src/hair/strands.js';
import { createTresses } from '../../www/src/hair/tresses.js';
import { pigments } from '../../www/src/head/pigments.js';

// A graphics card, of which nothing is asked.
globalThis.document = /** @type {any} */ ({ createElement: () => ({ getContext: () => null }) });

const STRANDS = 240;
const planted = { strands: STRANDS, locks: 1, lockOf: new Uint16Array(STRANDS), parts: new Uint8Array(4 * STRANDS).fill(255) };
const planting = { ...planted, ...layRibbons(planted) };
const rest = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0);
const anchors = { places: new Float32Array(3 * ANCHORS), corners: Uint32Array.from({ length: 3 * ANCHORS }, () => 0), weights: Float32Array.from({ length: 3 * ANCHORS }, (_, i) => (i % 3 ? 0 : 1)) };

/** Strands that hang down side by side, each style's as long as it says. @param {{ length: number }} style */
function grown({ length }) {
  const count = STRANDS * POINTS;
  const points = Float32Array.from({ length: 3 * count }, (_, i) => [Math.floor(i / 3 / POINTS) - STRANDS / 2, -100 * length * (Math.floor(i / 3) % POINTS), 0][i % 3]);
  return {
    planting,
    ribbons: ribbonsOf({ points, outward: Float32Array.from(points, (_, i) => Number(i % 3 === 2)), open: new Float32Array(count).fill(1), breadth: new Float32Array(count).fill(1), ends: new Float32Array(STRANDS).fill(1), anchors }),
  };
}

/** Hair that grows when it is told to. */
function setUp() {
  /** What was asked for and has not come. @type {{ length: number, come: () => void }[]} */
  const asked = [];
  const grower = {
    now: (/** @type {string} */ _, /** @type {{ length: number }} */ style) => grown(style),
    later: (/** @type {string} */ _, /** @type {{ length: number }} */ style, /** @type {(grown: object) => void} */ done) => void asked.push({ length: style.length, come: () => done(grown(style)) }),
    dispose() {},
  };
  const tresses = createTresses(
    { kind: 'hair', style: (paints) => paints.style, thinning: ({ standing, gone }) => ({ share: standing[0], gone: [0, 0, 0, gone[3]] }), long: hairLength, half: 0.83 },
    { grower: /** @type {any} */ (grower), rest, onGrown() {} },
    { heatStrength: { value: 0 } },
    [-1e4, -9e3],
  );
  return {
    tresses,
    asked,
    /** @param {import('../../www/src/head/colouring.js').Colouring} colouring @param {boolean} [asks] */
    paint: (colouring, asks) => tresses.paint(pigments(new Color(0.6, 0.4, 0.3), colouring), asks),
    /** Of the style that is seen. */
    length: () => (tresses.worn ? JSON.parse(tresses.worn).length : 0),
    come: () => asked.shift()?.come(),
    /** How many corners are drawn, for the light and then for the eye. */
    drawn() {
      const { mesh } = tresses;
      const of = () => (mesh.visible ? mesh.geometry.drawRange.count : 0);
      /** @type {any} */ (mesh).onBeforeShadow();
      const shadow = of();
      /** @type {any} */ (mesh).onAfterShadow();
      return { shadow, seen: of() };
    },
  };
}

describe('hair that is worn', () => {
  test('stays until another style has grown, also where there is to be more or less of it', () => {
    const { paint, come, drawn, length } = setUp();
    paint({ length: 0.5 });
    assert.equal(length(), 0);
    come();
    const whole = drawn();
    assert.ok(whole.shadow > 0 && whole.seen > whole.shadow);
    paint({ length: 0.6, thin: 0.4 });
    assert.deepEqual([length(), drawn()], [0.5, whole]);
    come();
    assert.equal(length(), 0.6);
    const thinner = drawn();
    assert.ok(thinner.shadow > 0 && thinner.seen < 0.8 * whole.seen);
    // And where the style is the same, there is more or less of it at once.
    paint({ length: 0.6 });
    assert.ok(drawn().seen > thinner.seen);
  });

  test('follows a slider by what was asked for a moment ago', () => {
    const { paint, come, length } = setUp();
    for (const value of [0.5, 0.6, 0.7]) paint({ length: value });
    come();
    assert.equal(length(), 0.5);
    come();
    assert.equal(length(), 0.7);
  });

  test('is nobody else’s when what was shown for a moment comes late, and who cannot wait asks for nothing', () => {
    const { tresses, paint, asked, come, length } = setUp();
    const own = { length: 0.5 };
    paint(own);
    come();
    // A portrait of somebody.
    paint({ length: 0.9 }, false);
    tresses.finish();
    assert.equal(length(), 0.9);
    paint(own);
    assert.deepEqual([length(), asked.length], [0.5, 0]);
    // Somebody on the stage, who is filmed, or who is left before the hair has come.
    for (const [somebody, filmed] of /** @type {[number, boolean][]} */ ([[0.8, true], [0.85, false]])) {
      paint({ length: somebody });
      if (filmed) tresses.finish();
      paint(own);
      assert.deepEqual(asked.map((one) => one.length), [somebody]);
      paint({ length: somebody - 0.2 });
      come();
      assert.equal(length(), 0.5);
      come();
      assert.equal(length(), somebody - 0.2);
      paint(own);
    }
    assert.equal(asked.length, 0);
  });

  test('is in view where it is: with the head, in another style, and with less of it', () => {
    const { tresses, paint, come } = setUp();
    // From so far away that all of it is as near.
    const reach = () => tresses.reach(new Vector3(), 1e9).map((value) => Math.round(value));
    const breadth = () => tresses.breadth({ x: 0, axis: 0 }, 0, 1e9).map((value) => Math.round(value));
    paint({ length: 0.5 });
    come();
    assert.deepEqual([reach(), breadth()], [[-50 * (POINTS - 1), 0], [STRANDS / 2, STRANDS / 2 - 1]]);
    tresses.update(rest.map((value, i) => value + [7, 20, 0][i % 3]));
    assert.deepEqual([reach(), breadth()], [[20 - 50 * (POINTS - 1), 20], [STRANDS / 2 - 7, STRANDS / 2 + 6]]);
    paint({ length: 0.6 });
    come();
    assert.deepEqual(reach(), [20 - 60 * (POINTS - 1), 20]);
    const [, before] = breadth();
    paint({ length: 0.6, thin: 0.5 });
    assert.ok(breadth()[1] < before - 10);
    paint({});
    assert.deepEqual(reach(), [Infinity, -Infinity]);
  });

  test('of two heads side by side goes to the graphics card once, and of a slider’s styles no more stay there than it takes', () => {
    const { tresses, paint, come } = setUp();
    const { attributes } = tresses.mesh.geometry;
    const shown = () => attributes.position;
    for (const length of [0.5, 0.7]) {
      paint({ length });
      come();
    }
    const before = shown().version;
    const [left, right] = [0.5, 0.7].map((length) => (paint({ length }), shown()));
    assert.notEqual(left, right);
    for (const [length, place] of /** @type {const} */ ([[0.5, left], [0.7, right], [0.5, left]])) {
      paint({ length });
      assert.equal(shown(), place);
    }
    assert.deepEqual([left.version, right.version], [0, before]);
    const places = new Set([left, right]);
    for (let length = 0.71; length < 0.8; length += 0.01) {
      paint({ length });
      come();
      places.add(shown());
      assert.equal(shown().array[3 * 2 * (POINTS - 1) + 1], Math.fround(-100 * length * (POINTS - 1)));
      // And who is beside it stays.
      paint({ length: 0.5 });
      assert.equal(shown(), left);
    }
    assert.deepEqual([places.size, left.version], [3, 0]);
  });
});
