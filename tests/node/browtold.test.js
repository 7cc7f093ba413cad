// Which form brows have, told from the albedo that a photo shows around them.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { load } from '../../pkg/index.js';
import { chance } from '../../www/src/chance.js';
import { browLine, heightOf, movedBrow, movesOf, unmovedBrow } from '../../www/src/hair/browform.js';
import { browLines, growBrows } from '../../www/src/hair/browline.js';
import { BROW_FORM } from '../../www/src/head/colouring.js';
import { atRest } from '../../www/src/head/head.js';
import { createBrowTeller } from '../../www/src/photo/browtold.js';

describe('the form of brows from a photo', async () => {
  const model = await load(await readFile(new URL('../../www/public/model.phiz', import.meta.url)));
  const rest = atRest(model, model.face());
  const line = browLine(rest.landmarks);
  const teller = createBrowTeller(rest);
  const count = teller.places.corners.length / 3;
  /** Where each place is on the head, mm. */
  const at = Array.from({ length: count }, (_, n) =>
    [0, 1].map((k) => [0, 1, 2].reduce((sum, i) => sum + teller.places.shares[3 * n + i] * rest.positions[3 * teller.places.corners[3 * n + i] + k], 0)),
  );
  /**
   * Skin with brows of a form, hair by hair: each darkens what is within a mm or so.
   * @param {Record<string, number>} form @param {number} seed @param {{ skin?: number, strength?: number, seen?: (x: number) => boolean }} [of]
   */
  function photo(form, seed, { skin = 0.4, strength = 1, seen = () => true } = {}) {
    const random = chance(seed);
    const [breadth, arch, slant, apart, raise] = BROW_FORM.map((name) => form[name] ?? 0.5);
    const moves = movesOf({ breadth, arch, slant, apart, raise }, line);
    const hairs = [];
    growBrows(browLines(rest.landmarks), 500, random, ({ x, y, dx, dy }) => {
      const [left, low] = movedBrow(line, moves, x, y);
      for (const s of [0.2, 0.5, 0.8]) hairs.push([left + s * dx, low + s * dy * 0.8]);
    });
    const out = new Float32Array(4 * count);
    const dense = at.map(([x, y]) => hairs.reduce((sum, [a, b]) => sum + Math.exp(-((x - a) ** 2 + (y - b) ** 2) / 2), 0));
    const most = Math.max(...dense);
    at.forEach(([x, y], n) => {
      // Skin gets darker towards the eye, and no two places have the same.
      const own = skin * Math.exp((-strength * dense[n]) / most + 0.006 * y + 0.05 * (random() - 0.5));
      out.set([own * 1.3, own, own * 0.7, seen(x) ? 1 : 0], 4 * n);
    });
    return out;
  }

  test('a place goes back to where the form took it from', () => {
    const random = chance(5);
    for (let i = 0; i < 200; i++) {
      const [breadth, arch, slant, apart, raise] = [random(), random(), random(), random(), random()];
      const moves = movesOf({ breadth, arch, slant, apart, raise }, line);
      const [x, y] = [(random() < 0.5 ? -1 : 1) * (line.outer - line.length * random()), heightOf(line, 0.5) + 10 * (random() - 0.5)];
      const [w, off] = unmovedBrow(line, moves, ...movedBrow(line, moves, x, y));
      const own = (line.outer - Math.abs(x)) / line.length;
      assert.ok(Math.abs(w - own) < 1e-9 && Math.abs(off - (y - heightOf(line, own))) < 1e-9, `${w} ${off}`);
    }
  });

  test('brows of any form are told, on fair and on deep skin, and from one side', () => {
    const random = chance(11);
    /** @type {Record<string, number[]>} */
    const off = Object.fromEntries(BROW_FORM.map((name) => [name, []]));
    for (let i = 0; i < 30; i++) {
      const form = Object.fromEntries(BROW_FORM.map((name) => [name, 0.15 + 0.7 * random()]));
      const told = teller.told(photo(form, 100 + i, { skin: i % 2 ? 0.5 : 0.06, strength: 0.5 + 0.6 * random(), seen: i % 3 ? () => true : (x) => x > 0 }));
      for (const name of BROW_FORM) off[name].push(told[name] - form[name]);
    }
    // Who tells nothing is 0.2 off.
    for (const [name, all] of Object.entries(off)) {
      const rms = Math.sqrt(all.reduce((sum, value) => sum + value ** 2, 0) / all.length);
      assert.ok(rms < 0.12, `${name} is off by ${rms}`);
    }
  });

  test('nothing is told of bare skin, of brows as fair as it, or of what is not seen', () => {
    assert.deepEqual(teller.told(photo({}, 1, { strength: 0 })), {});
    assert.deepEqual(teller.told(photo({}, 2, { strength: -0.5 })), {});
    assert.deepEqual(teller.told(photo({}, 3, { seen: (x) => x > 55 })), {});
    assert.deepEqual(teller.told(photo({}, 4, { seen: () => false })), {});
    // A fringe to the eyes: dark above, and no brow.
    const fringe = photo({}, 5, { strength: 0 });
    at.forEach(([, y], n) => y > heightOf(line, 0.5) - 3 && fringe.fill(0.05, 4 * n, 4 * n + 3));
    assert.deepEqual(teller.told(fringe), {});
  });
});
