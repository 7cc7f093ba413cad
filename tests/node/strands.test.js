// How hair grows, on an egg: what holds on any head. What it looks like is looked at on the page.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { beardGround, beardLength } from '../../www/src/hair/beard.js';
import { scalpGround } from '../../www/src/hair/hairstyle.js';
import { createHull } from '../../www/src/hair/hull.js';
import { hairLength } from '../../www/src/hair/length.js';
import { standingOf } from '../../www/src/hair/standing.js';
import { ANCHORS, growOn, POINTS, shiftsOf } from '../../www/src/hair/strands.js';

const [WIDE, TALL, DEEP] = [75, 110, 95];
const HAIRLINE = 40;
const BROW = 25;

/** An egg of a head, hair above a level in front and lower at the back. */
function egg() {
  const [rows, columns] = [60, 120];
  const positions = [];
  const normals = [];
  const triangles = [];
  for (let i = 0; i <= rows; i++) {
    for (let j = 0; j < columns; j++) {
      const [a, b] = [(Math.PI * i) / rows, (2 * Math.PI * j) / columns];
      const way = [Math.sin(a) * Math.sin(b), Math.cos(a), Math.sin(a) * Math.cos(b)];
      positions.push(WIDE * way[0], TALL * way[1], DEEP * way[2]);
      const normal = [way[0] / WIDE, way[1] / TALL, way[2] / DEEP];
      normals.push(...normal.map((x) => x / Math.hypot(...normal)));
    }
  }
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < columns; j++) {
      const [a, b] = [i * columns + j, i * columns + ((j + 1) % columns)];
      triangles.push(a, a + columns, b, b, a + columns, b + columns);
    }
  }
  const rest = Float32Array.from(positions);
  const scalp = Float32Array.from({ length: rest.length / 3 }, (_, v) => Math.max(-1, Math.min(1, (rest[3 * v + 1] - HAIRLINE + (rest[3 * v + 2] < 0 ? 60 : 0)) / 20)));
  /** @type {Map<string, [number, number, number]>} */
  const landmarks = new Map([['trichion', [0, HAIRLINE, 88]], ['tragion left', [WIDE, -20, 0]], ['ibug_19', [20, BROW, 90]]]);
  // Half of it recedes at once, and half stays.
  const parts = Uint8Array.from({ length: (4 * rest.length) / 3 }, (_, i) => (i % 4 < 3 ? 0 : rest[(3 * (i - 3)) / 4] > 0 ? 60 : 255));
  return { rest, normals: Float32Array.from(normals), triangles: Uint32Array.from(triangles), scalp, landmarks, parts };
}

const head = egg();
const hull = createHull(head.rest, head.triangles, head.landmarks);
assert.ok(hull);
const grown = () => {
  const ground = scalpGround(head.scalp, head.landmarks, hull);
  assert.ok(ground);
  const hair = growOn(head.rest, head.normals, head.triangles, hull, ground, head.parts);
  assert.ok(hair);
  return hair;
};
const STYLES = [
  { length: 0.2, comb: 0, parting: 0.5, curl: 0 },
  { length: 0.6, comb: 0.5, parting: 0.2, curl: 0 },
  { length: 1, comb: 0.4, parting: 0.6, curl: 0.1 },
  { length: 0.7, comb: 1, parting: 0.5, curl: 0.4 },
  { length: 0.8, comb: 0.3, parting: 0.5, curl: 1 },
];
/** How far outside of the egg, as a factor: 1 on it. */
const outside = (points, o) => Math.hypot(points[o] / WIDE, points[o + 1] / TALL, points[o + 2] / DEEP);

describe('hair', () => {
  test('is the same for a style, and nearly the same for nearly the same style', () => {
    const hair = grown();
    for (const style of STYLES) {
      const { points } = hair.grow(style);
      assert.deepEqual(grown().grow(style).points, points);
      assert.ok(points.every(Number.isFinite));
      for (const [name, step] of [['length', -0.005], ['comb', 0.005], ['parting', 0.005], ['curl', -0.005]]) {
        const value = style[name] + step;
        if (value < 0 || value > 1) continue;
        const { points: next } = hair.grow({ ...style, [name]: value });
        const moved = Float32Array.from({ length: points.length / 3 }, (_, i) => Math.hypot(...[0, 1, 2].map((k) => next[3 * i + k] - points[3 * i + k]))).sort();
        // What lies on the line of a parting falls to the other side, and a strand of a curl is turned half around at most.
        assert.ok(moved[moved.length >> 1] < 1.5, `${name}: half of the hair goes ${moved[moved.length >> 1]} mm for half a per cent`);
      }
    }
  });

  test('is nearly the same on nearly the same head', () => {
    // As much as the head that shows first and the model's median are apart.
    const near = head.rest.map((value, i) => value + 0.01 * Math.sin(12.9898 * i));
    const nearHull = createHull(near, head.triangles, head.landmarks);
    const ground = nearHull && scalpGround(head.scalp, head.landmarks, nearHull);
    const other = nearHull && ground && growOn(near, head.normals, head.triangles, nearHull, ground, head.parts);
    assert.ok(other);
    for (const style of STYLES) {
      const [{ points }, { points: next }] = [grown().grow(style), other.grow(style)];
      assert.equal(points.length, next.length);
      const moved = Float32Array.from({ length: points.length / 3 }, (_, i) => Math.hypot(...[0, 1, 2].map((k) => next[3 * i + k] - points[3 * i + k]))).sort();
      const [half, most] = [moved[moved.length >> 1], moved[Math.floor(0.98 * moved.length)]];
      assert.ok(half < 0.1 && most < 1.5, `${JSON.stringify(style)}: half of the hair is ${half} mm off, and 2 in 100 more than ${most}`);
    }
  });

  test('grows out of the scalp, lies on the head, is as long as asked for, and leaves the eyes free', () => {
    const hair = grown();
    for (const style of STYLES) {
      const { points, outward, open } = hair.grow(style);
      const long = hairLength(style);
      let bare = 0;
      let longest = 0;
      for (let n = 0; n < hair.strands; n++) {
        const from = 3 * POINTS * n;
        assert.ok(Math.abs(outside(points, from) - 1) < 0.03, `a root at ${points.subarray(from, from + 3)}`);
        assert.ok(points[from + 1] > HAIRLINE - 12 - (points[from + 2] < 10 ? 62 : 0), `a root below the hairline: ${points.subarray(from, from + 3)}`);
        let length = 0;
        for (let s = 1; s < POINTS; s++) {
          const o = from + 3 * s;
          length += Math.hypot(...[0, 1, 2].map((k) => points[o + k] - points[o + k - 3]));
          // The hull is of cells of some 5 mm.
          assert.ok(outside(points, o) > 0.985, `hair in the head at ${points.subarray(o, o + 3)}`);
          if (points[o + 2] > 60 && Math.abs(points[o]) < 45 && points[o + 1] < BROW - 6) bare++;
        }
        longest = Math.max(longest, length);
      }
      assert.equal(bare, 0, `${JSON.stringify(style)} hangs before the eyes`);
      // Curls wind, and roll up as they do.
      assert.ok(longest < 1.25 * long + 12 && (style.curl > 0.5 || longest > 0.8 * long), `${JSON.stringify(style)}: ${longest} mm for ${long}`);
      for (let i = 0; i < open.length; i++) {
        assert.ok(open[i] >= 0 && open[i] <= 1);
        assert.ok(Math.abs(Math.hypot(outward[3 * i], outward[3 * i + 1], outward[3 * i + 2]) - 1) < 1e-4);
      }
    }
  });

  test('waves and curls wind without a zigzag', () => {
    const hair = grown();
    for (const length of [0.3, 0.6, 0.85, 1]) {
      for (const curl of [0, 0.3, 0.5, 0.75, 1]) {
        const { points } = hair.grow({ length, comb: 0.45, parting: 0.4, curl });
        const turns = [];
        for (let n = 0; n < hair.strands; n++) {
          for (let s = 2; s < POINTS - 1; s++) {
            const o = 3 * (POINTS * n + s);
            const [before, after] = [-3, 0].map((from) => [0, 1, 2].map((k) => points[o + from + 3 + k] - points[o + from + k]));
            const scale = Math.hypot(...before) * Math.hypot(...after);
            if (scale > 0.01) turns.push(Math.acos(Math.min(1, Math.max(-1, before.reduce((sum, x, k) => sum + x * after[k], 0) / scale))));
          }
        }
        turns.sort((a, b) => a - b);
        // A circle of seven points turns by 51 degrees at each.
        const [most, usual] = [turns[Math.floor(0.99 * turns.length)], turns[turns.length >> 1]].map((turn) => (180 / Math.PI) * turn);
        assert.ok(usual < 15 + 35 * curl && most < 40 + 50 * curl, `length ${length}, curl ${curl}: half turns by ${usual} degrees at a point, 1 in 100 by more than ${most}`);
      }
    }
  });

  test('does not hang before the forehead: what is no fringe goes around it, and a fringe lies on it', () => {
    const hair = grown();
    for (const comb of [0, 0.3, 0.5, 1]) {
      for (const length of [0.3, 0.6, 0.9]) {
        for (const curl of [0, 0.5, 1]) {
          const { points } = hair.grow({ length, comb, parting: 0.4, curl });
          let farthest = 0;
          for (let o = 0; o < points.length; o += 3) {
            const [x, y, z] = points.subarray(o, o + 3);
            // Below this head it hangs before nothing.
            if (Math.abs(x) > 45 || y > HAIRLINE - 8 || y < -TALL || z < 0) continue;
            const skin = DEEP * Math.sqrt(Math.max(0, 1 - (x / WIDE) ** 2 - (y / TALL) ** 2));
            farthest = Math.max(farthest, z - skin);
          }
          assert.ok(farthest < (comb === 1 ? 19 + 10 * curl : 5), `length ${length}, comb ${comb}, curl ${curl}: hair ${farthest} mm before the forehead`);
        }
      }
    }
  });

  test('a fringe covers the forehead from side to side, of hair from behind the hairline, too', () => {
    const { points } = grown().grow({ length: 0.42, comb: 0.85, parting: 0.5, curl: 0 });
    const columns = new Array(12).fill(0);
    let lowest = Infinity;
    for (let n = 0; n < points.length; n += 3 * POINTS) {
      const [x, y, z] = points.subarray(n + 3 * (POINTS - 1), n + 3 * POINTS);
      const rootHeight = points[n + 1];
      if (Math.abs(x) >= 36 || z < 0 || y > HAIRLINE - 2 || rootHeight < HAIRLINE + 3) continue;
      columns[Math.floor((x + 36) / 6)]++;
      lowest = Math.min(lowest, y);
    }
    // A ribbon is 1.6 mm wide: that many lie in three layers and more.
    assert.ok(Math.min(...columns) >= 12, `${columns} strands end before the forehead`);
    // It is cut 9 mm over the brows, 4 mm up or down, to a step (5 mm) and to a fiftieth of a strand (3 mm).
    assert.ok(lowest > BROW + 9 - 4 - 5 - 3, `it hangs to ${lowest}`);
  });

  test('goes where its root is on a part that goes, and otherwise stays as it was', () => {
    const hair = grown();
    const { points } = hair.grow(STYLES[0]);
    const whole = { share: 1, gone: [0, 0, 0, 0] };
    const all = standingOf(hair.strands, hair, whole);
    assert.deepEqual([...all], Array.from({ length: hair.strands }, (_, n) => n));
    const left = standingOf(hair.strands, hair, { ...whole, gone: [0, 0, 0, 0.6] });
    const rootX = (/** @type {number} */ n) => points[3 * POINTS * n];
    // A row of the egg is 4 mm.
    assert.ok([...left].every((n) => rootX(n) < 4));
    assert.ok([...all].every((n) => rootX(n) > -4 || left.includes(n)));
    const thin = standingOf(hair.strands, hair, { ...whole, share: 0.3 });
    assert.ok(thin.length > 0.1 * hair.strands && thin.length < 0.3 * hair.strands && thin.every((n, i) => n === i));
  });

  test('goes along with the head: shifts are linear in it, and nothing at rest', () => {
    const hair = grown();
    const { points, anchors } = hair.grow(STYLES[2]);
    const many = ANCHORS * hair.locks;
    const at = (/** @type {Float32Array} */ positions) => {
      const into = new Float32Array(4 * many);
      shiftsOf(anchors, positions, into);
      return into;
    };
    assert.ok(at(head.rest).every((value) => Math.abs(value) < 1e-4));
    const moved = at(head.rest.map((value, i) => value + [3, -2, 1][i % 3]));
    for (let n = 0; n < many; n++) for (let k = 0; k < 3; k++) assert.ok(Math.abs(moved[4 * n + k] - [3, -2, 1][k]) < 1e-3);
    const wider = at(head.rest.map((value, i) => (i % 3 === 0 ? 1.1 * value : value)));
    const twice = at(head.rest.map((value, i) => (i % 3 === 0 ? 1.2 * value : value)));
    for (let i = 0; i < wider.length; i++) assert.ok(Math.abs(twice[i] - 2 * wider[i]) < 1e-3);

    // Hair that grows on top lies on a wider head's sides, which go 15 mm out, where its roots do not.
    let sunk = 0;
    for (let i = 0; i < points.length / 3; i++) {
      const place = ((i % POINTS) / POINTS) * (ANCHORS - 1);
      const [before, after] = [0, 1].map((next) => 4 * ((Math.floor(place) + next) * hair.locks + hair.lockOf[Math.floor(i / POINTS)]));
      const [x, y, z] = [0, 1, 2].map((k) => points[3 * i + k] + twice[before + k] + (twice[after + k] - twice[before + k]) * (place % 1));
      if (Math.hypot(x / (1.2 * WIDE), y / TALL, z / DEEP) < 0.97) sunk++;
    }
    // Between two anchors it goes straight: over 75 mm of a head's curve that is 6 mm at most, of what the head is wider by a seventh.
    assert.ok(sunk < 0.03 * (points.length / 3), `${sunk} of ${points.length / 3} points are in the head`);
  });

  test('does not grow where there is no scalp, or none of the landmarks it goes by', () => {
    const bald = scalpGround(head.scalp.map(() => -1), head.landmarks, hull);
    assert.ok(bald);
    assert.equal(growOn(head.rest, head.normals, head.triangles, hull, bald, head.parts), null);
    assert.equal(scalpGround(head.scalp, new Map(), hull), null);
    assert.equal(beardGround(head.scalp, new Map()), null);
    assert.equal(createHull(head.rest, head.triangles, new Map()), null);
    for (const long of [hairLength, beardLength]) {
      assert.equal(long({ length: 0 }), 0);
      for (let length = 0.1; length < 1; length += 0.1) assert.ok(long({ length }) > long({ length: length - 0.1 }));
    }
  });
});
