import { chance } from '../chance.js';
import { smoothstep } from '../groundwork/paint.js';
import { browLine, movedBrow, movesOf, turnOfBrow } from './browform.js';
import { browLines, growBrows } from './browline.js';
import { reliefAround } from './relief.js';
import { ANCHORS, POINTS } from './strands.js';

// Brows as strands: short hairs that lie close to the skin, each of which goes with the skin at its root.

/** Of each brow, at most. */
const HAIRS = 800;
/** How much longer the hairs of broader brows are: as a power of how much broader. */
const LONGER = 0.4;

/** How brows are, as strands: never longer or shorter. @typedef {import('./strands.js').Curled & import('./browform.js').BrowForm} Brows */

/**
 * @param {import('./plant.js').Skin} skin
 * @returns {import('./strands.js').Hair<Brows> | null} null without the landmarks that it goes by
 */
export function browHair(skin) {
  const form = browLine(skin.landmarks);
  if (!form) return null;
  const random = chance(31);
  /** @type {(import('./browline.js').BrowHair & { relief: ReturnType<typeof reliefAround>, lift: number, broad: number, lasts: number, order: number })[]} */
  const hairs = [];
  for (const line of browLines(skin.landmarks)) {
    const relief = reliefAround(line, skin);
    growBrows([line], HAIRS, random, (hair) => {
      const { x, y, t, across } = hair;
      const [order, lift] = [random(), random()];
      if (!relief.bind(x, y)) return;
      // A brow begins soft, and ends in single hairs.
      const broad = Math.min(1, 0.45 + 2 * t) * (1 - 0.55 * smoothstep(0.5, 1, t)) * (0.55 + 0.45 * random());
      // Those in the middle of a brow are there however thin it is, but for its tail.
      hairs.push({ ...hair, relief, lift, broad, lasts: (1 - 1.5 * Math.abs(across)) * (1 - 0.5 * smoothstep(0.6, 1, t)), order });
    });
  }
  // The first of them are anywhere: where few are drawn, it is they.
  hairs.sort((a, b) => a.order - b.order);
  const count = hairs.length;
  const open = Float32Array.from({ length: count * POINTS }, (_, i) => 0.45 + 0.3 * ((Math.floor(i / POINTS) * 0.7548776662) % 1) + (0.25 * (i % POINTS)) / POINTS);
  const breadth = Float32Array.from(open, (_, i) => hairs[Math.floor(i / POINTS)].broad);

  const grow = (/** @type {Brows} */ style) => {
    const moves = movesOf(style, form);
    const [points, outward] = [new Float32Array(3 * POINTS * count), new Float32Array(3 * POINTS * count)];
    // They are too short to lie on anything but what they grow from.
    const [places, weights] = [0, 1].map(() => new Float32Array(3 * ANCHORS * count));
    const corners = new Uint32Array(3 * ANCHORS * count);
    hairs.forEach(({ x, y, dx, dy, t, relief, lift }, n) => {
      const [left, low] = movedBrow(form, moves, x, y);
      const side = Math.sign(x);
      const turn = turnOfBrow(form, moves, x);
      const longer = moves.broad ** LONGER;
      const [cos, sin] = [longer * Math.cos(turn), longer * Math.sin(turn)];
      const [alongX, alongY] = [cos * dx - side * sin * dy, side * sin * dx + cos * dy];
      for (let s = 0; s < POINTS; s++) {
        const at = s / (POINTS - 1);
        // As they are painted, and a little off the skin from the root on.
        const [px, py] = [left + alongX * (1.1 * at - 0.1 * at * at), low + alongY * (1.5 * at - 0.78 * at * at)];
        const out = relief.out(px, py);
        const off = (0.35 + 0.75 * lift) * (1 - 0.4 * t) * at * (1.9 - 1.1 * at) - 0.1;
        const o = 3 * (n * POINTS + s);
        points.set([px + off * out[0], py + off * out[1], relief.z(px, py) + off * out[2]], o);
        outward.set(out, o);
      }
      const bound = relief.bind(left, low);
      // Beside the head nothing would carry it: it goes nowhere.
      if (!bound) return;
      for (let k = 0; k < ANCHORS; k++) {
        const o = 3 * (k * count + n);
        corners.set(bound.corners, o);
        weights.set(bound.weights, o);
        for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) places[o + i] += bound.weights[j] * skin.positions[3 * bound.corners[j] + i];
      }
    });
    return { points, outward, open, breadth, ends: new Float32Array(count).fill(1), anchors: { places, corners, weights } };
  };
  return {
    strands: count,
    locks: count,
    lockOf: Uint16Array.from(hairs, (_, n) => n),
    // However thin they are, it is the same hairs that stand.
    parts: Uint8Array.from(hairs.flatMap(({ lasts }) => [0, 0, 0, Math.round(255 * lasts)])),
    grow,
  };
}
