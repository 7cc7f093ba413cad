// Where the page lets hair and beard grow, on the heads of the committed models.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { load } from '../../pkg/index.js';
import { Color } from '../../www/node_modules/three/build/three.module.js';
import { chance } from '../../www/src/chance.js';
import { browLine, movedBrow, movesOf, UNMOVED_GLSL } from '../../www/src/hair/browform.js';
import { browHair } from '../../www/src/hair/browhair.js';
import { browLines } from '../../www/src/hair/browline.js';
import { growth } from '../../www/src/hair/growth.js';
import { hairLength } from '../../www/src/hair/length.js';
import { partsOf, RECEDED, SOFT } from '../../www/src/hair/parts.js';
import { standingOf } from '../../www/src/hair/standing.js';
import { POINTS } from '../../www/src/hair/strands.js';
import { pigments } from '../../www/src/head/pigments.js';
import { SKIN_GLSL } from '../../www/src/head/skin.js';
import { someone } from '../../www/src/head/someone.js';
import { decodeColouring, encodeColouring } from '../../www/src/keep/addresscode.js';

const OWN_BROWS = { length: 1, curl: 0, breadth: 0.5, arch: 0.5, slant: 0.5, apart: 0.5, raise: 0.5 };

for (const name of ['model', 'synthetic']) {
  describe(`hair of ${name}.phiz`, async () => {
    const model = await load(await readFile(new URL(`../../www/public/${name}.phiz`, import.meta.url)));
    const face = model.face();
    const rest = face.positions.slice();
    const corners = model.uvVertices;
    const of = (/** @type {Float32Array} */ values, /** @type {string} */ landmark) => {
      const { stencil } = model.landmarks.find((one) => one.name === landmark);
      return stencil.reduce((sum, [vertex, weight]) => sum + weight * values[vertex], 0);
    };
    const landmarks = new Map(
      model.landmarks.map((landmark) => [landmark.name, [0, 1, 2].map((k) => landmark.stencil.reduce((sum, [v, w]) => sum + w * rest[3 * v + k], 0))]),
    );
    const hollow = model.parts
      .filter((part) => /cavit/.test(part.name))
      .flatMap(({ first, count }) => [...model.triangles.subarray(3 * first, 3 * (first + count))].map((corner) => corners[corner]));
    const triangles = model.triangles.map((corner) => corners[corner]);
    const { scalp, beard } = growth(rest, landmarks, hollow, triangles);

    test('grows on the crown and the chin, and not on the face between, the ears or the nape', () => {
      // A quarter of the margin is 5 mm.
      for (const [values, there, bare] of [
        [scalp, ['vertex'], ['metopion', 'glabella', 'ibug_17', 'ibug_26', 'pogonion', 'ibug_30', 'tragion left', 'tragion right']],
        [beard, ['pogonion', 'supramentale', 'gonion left', 'gonion right'], ['vertex', 'metopion', 'ibug_30', 'ibug_36', 'ibug_45', 'cheek left', 'cheek right']],
      ]) {
        for (const landmark of there) assert.ok(of(values, landmark) > 0.25, `${landmark}: ${of(values, landmark)}`);
        for (const landmark of bare) assert.ok(of(values, landmark) < -0.25, `${landmark}: ${of(values, landmark)}`);
      }
      for (const part of ['lower helix', 'intertragic notch', 'subaurale', 'postaurale']) {
        for (const side of ['left', 'right']) {
          for (const values of [scalp, beard]) assert.ok(of(values, `${part} ${side}`) < 0, `${part} ${side}: ${of(values, `${part} ${side}`)}`);
        }
      }
      // There are no bald spots above and behind the ears.
      const [, top] = landmarks.get('superaurale left');
      const [, , before] = landmarks.get('tragion left');
      for (let v = 0; v < model.vertexCount; v++) {
        if (rest[3 * v + 1] > top + 5 && rest[3 * v + 2] < before) assert.ok(scalp[v] > 0.5, `${rest.slice(3 * v, 3 * v + 3)}: ${scalp[v]}`);
      }
      // The hairline's midpoint is on it.
      assert.ok(Math.abs(of(scalp, 'trichion')) < 0.15, `trichion: ${of(scalp, 'trichion')}`);
    });

    test('is as wide on one side as on the other', () => {
      let most = 0;
      model.mirror.forEach((other, v) => {
        most = Math.max(most, Math.abs(scalp[v] - scalp[other]), Math.abs(beard[v] - beard[other]));
      });
      // Heads are symmetric but for some tenths of a millimetre, of 20; around ears that counts five times.
      assert.ok(most < 0.08, `${most}`);
    });

    const parts = partsOf(rest, landmarks);
    const part = (/** @type {number} */ k) => Float32Array.from({ length: model.vertexCount }, (_, v) => parts[4 * v + k] / 255);

    test('hair recedes above the temples first, then on the crown, and stays at the sides and the back', () => {
      const lasts = part(3);
      // At the slider's beginning and at its end, what is there is whole.
      assert.ok(SOFT * lasts.reduce((least, value) => Math.min(least, value)) >= 1 && SOFT * (1 - RECEDED) >= 1);
      assert.ok(SKIN_GLSL.GROWN.PLACED.includes(`${SOFT.toFixed(1)} * (parts.w - gone.w)`));
      assert.equal(pigments(new Color(), { hairline: 1 }).gone[3], RECEDED);
      const [, front, far] = landmarks.get('trichion');
      const [, top] = landmarks.get('superaurale left');
      const [, , ear] = landmarks.get('tragion left');
      const [, high] = landmarks.get('vertex');
      // Of what grows on the head, by where it is.
      const mean = (/** @type {(x: number, y: number, z: number) => boolean} */ where) => {
        const found = [...lasts].filter((_, v) => scalp[v] > 0.3 && where(Math.abs(rest[3 * v]), rest[3 * v + 1], rest[3 * v + 2]));
        assert.ok(found.length > 5);
        return found.reduce((sum, value) => sum + value, 0) / found.length;
      };
      const temples = mean((x, y, z) => x > 35 && x < 50 && y > front - 15 && z > far - 45);
      const forelock = mean((x, y, z) => x < 8 && z > far - 30);
      const crown = mean((x, y, z) => x < 10 && y > front && z < ear - 55);
      const between = mean((x, y, z) => x < 10 && y > high - 10 && z > ear - 5);
      assert.ok(temples < forelock - 0.1 && forelock < between && crown < between, `temples ${temples}, forelock ${forelock}, crown ${crown}, between ${between}`);
      assert.ok(between < RECEDED - 0.05, `${between}`);
      assert.ok(mean((x, y) => y < top + 5) > 0.99);
    });

    test('hair recedes over the temples as a line does: not much of it is thin at once', () => {
      const lasts = part(3);
      const [, , far] = landmarks.get('trichion');
      const temples = [...scalp.keys()].filter((v) => scalp[v] > 0.3 && Math.abs(rest[3 * v]) > 30 && rest[3 * v + 2] > far - 60);
      let most = 0;
      for (let gone = 0; gone < RECEDED; gone += 0.01) {
        // As the skin's shader has it.
        const thin = temples.filter((v) => Math.abs(SOFT * (lasts[v] - gone) - 0.1) < 0.35);
        most = Math.max(most, thin.length / temples.length);
      }
      // The line is two centimetres wide, of six.
      assert.ok(most < 0.35, `${most} of the hair`);
    });

    test('a beard is of a moustache, a chin and cheeks, as wide on one side as on the other', () => {
      const [moustache, chin, cheeks] = [0, 1, 2].map(part);
      for (const [values, there, none] of [
        [moustache, ['ibug_33', 'ibug_51'], ['pogonion', 'gonion left', 'ibug_57']],
        [chin, ['pogonion', 'supramentale'], ['ibug_51', 'gonion left', 'gonion right']],
        [cheeks, ['gonion left', 'gonion right', 'ibug_04'], ['pogonion', 'ibug_51']],
      ]) {
        for (const landmark of there) assert.ok(of(values, landmark) > 0.95, `${landmark}: ${of(values, landmark)}`);
        for (const landmark of none) assert.ok(of(values, landmark) < 0.05, `${landmark}: ${of(values, landmark)}`);
      }
      assert.ok(moustache.every((value, v) => Math.abs(value + chin[v] + cheeks[v] - 1) < 1e-6));
      model.mirror.forEach((other, v) => {
        for (let k = 0; k < 4; k++) assert.ok(Math.abs(parts[4 * v + k] - parts[4 * other + k]) < 20, `part ${k} at ${rest.slice(3 * v, 3 * v + 3)}`);
      });
    });

    test('a man of seventy may have lost some, and a young woman has not', () => {
      const lost = (/** @type {number} */ sex, /** @type {number} */ age) =>
        Array.from({ length: 40 }, (_, seed) => {
          face.randomize({ seed, attributes: { sex, age } });
          return someone(face, seed).hairline ?? 0;
        }).filter((value) => value > 0.2).length;
      const men = lost(1, 70);
      assert.ok(men >= 5 && men < 40, `${men} of 40`);
      assert.equal(lost(0, 25), 0);
    });

    test('brows grow where the model is painted with them, between its landmarks and the lids', () => {
      const dark = (/** @type {number} */ v) => 255 - Math.max(...model.colours.subarray(3 * v, 3 * v + 3));
      const skin = dark(model.landmarks.find((one) => one.name === 'metopion').stencil[0][0]);
      for (const [side, line] of browLines(landmarks).entries()) {
        // What is painted as dark as a brow, above this eye: where its middle is, weighted by how dark it is.
        const lids = landmarks.get(side ? 'ibug_44' : 'ibug_38')[1];
        for (const [x, y, z] of line.slice(1, 4)) {
          let [sum, all] = [0, 0];
          for (let v = 0; v < model.vertexCount; v++) {
            const [px, py, pz] = rest.subarray(3 * v, 3 * v + 3);
            if (Math.abs(px - x) > 4 || py < lids + 6 || py > lids + 40 || Math.abs(pz - z) > 10) continue;
            const weight = Math.max(0, dark(v) - skin - 25);
            sum += weight * py;
            all += weight;
          }
          assert.ok(all > 0, `nothing is painted at ${x}`);
          // Triangles are 3 mm large there.
          assert.ok(Math.abs(sum / all - y) < 2, `painted at ${sum / all}, grown at ${y}`);
          assert.ok(y > lids + 8, `${y}, lids at ${lids}`);
        }
        const points = [...line.keys()].map((i) => landmarks.get(`ibug_${side ? 22 + i : 21 - i}`)[1] - line[i][1]);
        assert.ok(points.every((below) => below > 4 && below < 10), `${points} mm below`);
      }
    });

    test('brows take a form: broad, arched, raised, joined, by the slider’s mm, and every hair stays on the skin', () => {
      const brows = browHair({ positions: rest, normals: face.normals.slice(), triangles, landmarks });
      assert.ok(brows);
      const rootsOf = (/** @type {Partial<typeof OWN_BROWS>} */ form) => {
        const { points, anchors } = brows.grow({ ...OWN_BROWS, ...form });
        assert.ok(points.every(Number.isFinite));
        return Array.from({ length: brows.strands }, (_, n) => {
          const root = [...points.subarray(3 * POINTS * n, 3 * POINTS * n + 3)];
          // It begins 0.1 mm in the skin, and is bound to it there.
          const apart = Math.hypot(...root.map((value, k) => anchors.places[3 * n + k] - value));
          assert.ok(apart < 1, `${JSON.stringify(form)}: a root at ${root} is bound ${apart} mm beside`);
          return root;
        });
      };
      const own = rootsOf({});
      /** @param {number[][]} roots @param {(t: number) => boolean} where of those that are there in the own form, from the inner end on */
      const heights = (roots, where) => {
        const inner = Math.min(...own.map(([x]) => Math.abs(x)));
        const outer = Math.max(...own.map(([x]) => Math.abs(x)));
        const some = roots.filter((_, n) => where((Math.abs(own[n][0]) - inner) / (outer - inner)));
        assert.ok(some.length > 20);
        return some.reduce((sum, [, y]) => sum + y, 0) / some.length;
      };
      const [all, ends, outerEnd, innerEnd] = [() => true, (/** @type {number} */ t) => t < 0.1 || t > 0.95, (/** @type {number} */ t) => t > 0.9, (/** @type {number} */ t) => t < 0.1];
      const [high, low] = [rootsOf({ raise: 1 }), rootsOf({ raise: 0 })];
      // A hair begins 0.1 mm in the skin, which leans otherwise there.
      assert.ok(Math.abs(heights(high, all) - heights(low, all) - 10) < 0.1, `all of it goes ${heights(high, all) - heights(low, all)} mm, not 10`);
      const [arched, straight] = [rootsOf({ arch: 1 }), rootsOf({ arch: 0 })].map((roots) => heights(roots, (t) => Math.abs(t - 0.62) < 0.1) - heights(roots, ends));
      assert.ok(arched > straight + 8, `the middle is ${arched} and ${straight} mm over the ends`);
      const [rising, drooping] = [rootsOf({ slant: 1 }), rootsOf({ slant: 0 })].map((roots) => heights(roots, outerEnd) - heights(roots, innerEnd));
      assert.ok(rising > drooping + 15, `outer ends are ${rising} and ${drooping} mm over inner ones`);
      // Across the middle of a brow, where its line is level, as far as its own is and is not.
      const extent = (/** @type {number[][]} */ roots) => {
        const ys = roots.filter((_, n) => own[n][0] > 20 && own[n][0] < 26).map(([, y]) => y).sort((a, b) => a - b);
        return ys[Math.floor(0.95 * ys.length)] - ys[Math.floor(0.05 * ys.length)];
      };
      const [broad, narrow] = [rootsOf({ breadth: 1 }), rootsOf({ breadth: 0 })].map((roots) => extent(roots) / extent(own));
      assert.ok(broad > 1.6 && broad < 1.8 && narrow < 0.5, `${broad} and ${narrow} of their own breadth`);
      const nearest = (/** @type {number[][]} */ roots) => Math.min(...roots.map(([x]) => Math.abs(x)));
      assert.ok(nearest(own) > 5 && nearest(rootsOf({ apart: 0 })) < 2 && nearest(rootsOf({ apart: 1 })) > nearest(own) + 5);
      for (const [n, [x]] of rootsOf({ apart: 0 }).entries()) assert.ok(x * own[n][0] >= 0 || Math.abs(x) < 2, 'a hair is on the other brow');
    });

    test('what the shader takes back of a form is what is put on', () => {
      const line = browLine(landmarks);
      assert.ok(line);
      // Its text, in JavaScript.
      const body = UNMOVED_GLSL.slice(UNMOVED_GLSL.indexOf('{') + 1, UNMOVED_GLSL.lastIndexOf('}')).replaceAll('float ', 'const ');
      const unmoved = new Function('at', 'browSpan', 'browLine', 'browMoves', 'browSlant', `const { abs, max, sqrt } = Math; const vec2 = (x, y) => [x, y];${body}`);
      const [x, y, z, w] = line.heights;
      const random = chance(4);
      for (let n = 0; n < 2000; n++) {
        const form = { breadth: random(), arch: random(), slant: random(), apart: random(), raise: random() };
        const moves = movesOf(form, line);
        const at = [(random() < 0.5 ? -1 : 1) * (line.outer - line.length * (1.15 * random() - 0.1)), line.heights[0] + 30 * random() - 15];
        const [left, low] = movedBrow(line, moves, at[0], at[1]);
        // What would be on the other side is seen by nobody.
        if (left * at[0] <= 0) continue;
        const back = unmoved({ x: left, y: low }, { x: line.outer, y: line.length }, { x, y, z, w }, { x: moves.apart, y: moves.broad, z: moves.raise, w: moves.arch }, moves.slant);
        assert.ok(Math.hypot(back[0] - at[0], back[1] - at[1]) < 1e-6, `${at} came back as ${back} from ${JSON.stringify(form)}`);
      }
      for (const place of [[30, 40], [-12, 35]]) {
        const there = movedBrow(line, movesOf(OWN_BROWS, line), place[0], place[1]);
        assert.ok(Math.hypot(there[0] - place[0], there[1] - place[1]) < 1e-9, 'their own form moves them');
      }
    });

    test('brows are of hairs along their line that lie close to the skin, as many on each side, and thin ones are the middle of them', () => {
      const brows = browHair({ positions: rest, normals: face.normals.slice(), triangles, landmarks });
      assert.ok(brows);
      const { points, anchors } = brows.grow(OWN_BROWS);
      const line = Array.from({ length: 10 }, (_, i) => landmarks.get(`ibug_${17 + i}`));
      let left = 0;
      for (let n = 0; n < brows.strands; n++) {
        const [x, y] = points.subarray(3 * POINTS * n);
        if (x > 0) left++;
        // Half of a brow's height is 4.3 mm, and between its points are up to 15 mm.
        assert.ok(line.some((at) => Math.hypot(at[0] - x, at[1] - y) < 4.3 + 7.5 + 2), `a root at ${x}, ${y}`);
        // A hair begins 0.1 mm in the skin, and is bound to it there.
        const off = Math.hypot(...[0, 1, 2].map((k) => points[3 * POINTS * n + k] - anchors.places[3 * n + k]));
        assert.ok(off < 0.4, `a root is ${off} mm off the skin`);
        const tip = 3 * (POINTS * (n + 1) - 1);
        const long = Math.hypot(...[0, 1, 2].map((k) => points[tip + k] - points[3 * POINTS * n + k]));
        // They are up to 6.4 mm long seen from the front, and a brow's end turns away by half.
        assert.ok(long > 1 && long < 11, `a hair of ${long} mm`);
      }
      assert.ok(Math.abs(left - brows.strands / 2) < 0.1 * brows.strands, `${left} of ${brows.strands}`);
      const height = (/** @type {Iterable<number>} */ which) => {
        const lasts = Array.from(which, (n) => brows.parts[4 * n + 3]);
        return lasts.reduce((sum, value) => sum + value, 0) / lasts.length;
      };
      const thin = standingOf(brows.strands, brows, { share: 1, gone: [0, 0, 0, 0.6] });
      assert.ok(thin.length > 100 && height(thin) > height(new Uint16Array(brows.strands).keys()) + 10);
    });

    test('a head without the landmarks has neither', () => {
      landmarks.delete('trichion');
      const none = growth(rest, landmarks, hollow, triangles);
      assert.ok([...none.scalp, ...none.beard].every((value) => value === -1));
      assert.ok(partsOf(rest, landmarks).every((value, i) => value === (i % 4 < 2 ? 0 : 255)));
    });
  });
}

describe('how dense hair is', () => {
  const of = (/** @type {import('../../www/src/head/colouring.js').Colouring} */ colouring) => pigments(new Color(0.6, 0.4, 0.3), colouring);

  test('hair of any length is thinned, to none', () => {
    for (const length of [0, 0.1, 0.36, 1]) {
      for (const much of [0, 0.05, 0.35, 1]) {
        const { dense, standing } = of({ crop: much, thin: 1 - much, length, beard: much, beardThin: 1 - much, beardLength: length });
        assert.ok(Math.abs(dense[0] - much) < 1e-9 && Math.abs(dense[1] - much) < 1e-9, `${dense} for ${much}`);
        assert.ok(Math.abs(standing[0] - much) < 1e-9 && Math.abs(standing[1] - Math.min(1, much / 0.8)) < 1e-9, `${standing} for ${much}`);
      }
    }
    let before = 0;
    for (const share of [0, 0.05, 0.12, 0.35, 0.6, 1]) {
      const standing = standingOf(6000, { parts: new Uint8Array(4 * 6000).fill(255) }, { share, gone: [0, 0, 0, 0] });
      assert.ok(share === 0 ? standing.length === 0 : standing.length > before);
      before = standing.length;
    }
    assert.equal(before, 6000);
  });

  test('the shortest hair is dense, and what is painted of it lies below its tips', () => {
    for (const length of [0.03, 0.05, 0.1]) {
      const { dense, lift } = of({ length });
      assert.equal(dense[0], 1);
      assert.ok(lift < 0.4 * hairLength({ length }), `${lift} mm of ${hairLength({ length })}`);
    }
    assert.equal(of({ crop: 0.5 }).lift, 1.75);
  });

  test('a link made before there was thin hair is as dense as it was', () => {
    // Of a crop of 0.3 and a length of 0.36; of a beard of 0.35 and a length of 0.1.
    const { dense, standing } = of(decodeColouring('CB4JIwokEAo'));
    assert.deepEqual([dense, standing], [[1, 0.8 * 0.8], [1, 1]]);
    assert.equal(encodeColouring({ crop: 0.3, beard: 0.35, length: 0.36, beardLength: 0.1 }), 'CB4JIwokEAo');
    // And nothing of it has receded or is shaved.
    assert.deepEqual(of(decodeColouring('CB4JIwokEAo')).gone, [0, 0, 0, 0]);
    const man = { crop: 0.5, thin: 0.5, hairline: 0.6, beard: 0.8, beardLength: 0.2, beardThin: 0.2, moustache: 0.9, chinBeard: 0, cheekBeard: 0 };
    assert.deepEqual(decodeColouring(encodeColouring(man)), man);
  });
});
