import { points, smoothstep } from '../groundwork/paint.js';
import { clamp, norm } from './hull.js';

// Which part of a beard hair is, and how long hair on the head lasts as its line recedes.

// The upper edge of what stays for good, of the hair at the sides and the back: as the hairline, degrees around an upright
// axis, and heights of which 0 is the tragion's and 1 the trichion's.
const WREATH = [[0, 0.2], [50, 0.2], [58, 0.34], [68, 0.58], [84, 0.76], [100, 0.8], [125, 0.74], [150, 0.6], [180, 0.5]];
/** When all is gone that goes, of the slider. */
const LAST = 0.93;
/** How far hair has receded at the end of the slider: what stays is whole then, as all is at its beginning. */
export const RECEDED = 0.83;
/** How far inside of its line hair is, in what it recedes by: the line is soft. */
export const SOFT = 11;
/** From when on hair goes, so that all is whole before, and by when, so that none is left; in what it recedes by. */
const FIRST_GOES = 1.02 / SOFT;
const LAST_GOES = RECEDED - 0.8 / SOFT;

/**
 * Four numbers a vertex, 0 to 255: how far it is of the moustache, of the beard on the chin, of that on cheeks and throat; and how
 * far hair on the head has to recede until its line is there, 255 where it stays.
 * @param {Float32Array} rest 3 a vertex, mm
 * @param {import('../groundwork/paint.js').Points} at landmarks
 * @returns {Uint8Array<ArrayBuffer>} of a head without the landmarks that it goes by, all beard is on the cheeks and all hair stays
 */
export function partsOf(rest, at) {
  const parts = new Uint8Array((4 * rest.length) / 3);
  for (let i = 2; i < parts.length; i++) if (i & 2) parts[i] = 255;
  const lips = points(at, 48, 59);
  const [trichion, tragion, chin] = ['trichion', 'tragion left', 'ibug_08'].map((name) => at.get(name));
  if (!trichion || !tragion || !chin || lips.length < 12) return parts;
  const tall = trichion[1] - tragion[1];
  const middle = [tragion[1] + 0.42 * tall, tragion[2] + 0.11 * tall];
  /** Of a vertex over the ears, mm over the head: from the front, around a line through both. @param {number} y @param {number} z */
  const back = (y, z) => tall * Math.atan2(y - middle[0], z - middle[1]);
  const front = back(trichion[1], trichion[2]);
  /** How high hair is that stays. @param {number} angle degrees */
  const wreath = (angle) => {
    const next = Math.max(1, WREATH.findIndex(([at]) => at >= angle));
    const [[from, low], [to, high]] = [WREATH[next - 1], WREATH[next]];
    return tragion[1] + tall * (low + ((high - low) * (angle - from)) / (to - from));
  };
  /** The crown, where hair goes from within. */
  const crown = [Math.cos(2.25), Math.sin(2.25)];
  const half = (lips[6][0] - lips[0][0]) / 2;
  const corners = (lips[0][1] + lips[6][1]) / 2;
  for (let v = 0; v < rest.length / 3; v++) {
    const [x, y, z] = [rest[3 * v], rest[3 * v + 1], rest[3 * v + 2]];
    const aside = Math.abs(x);
    if (y > tragion[1]) {
      const behind = back(y, z) - front;
      // Above the temples first, and the middle of the forehead after them.
      const temple = smoothstep(0.1, 0.45, aside / tall);
      const receding = 0.36 - 0.26 * temple + ((0.54 + 0.22 * temple) * Math.max(-16, behind)) / (110 + 10 * temple);
      const far = norm(x, y - middle[0], z - middle[1]);
      const off = tall * Math.acos(clamp(((y - middle[0]) * crown[1] + (z - middle[1]) * crown[0]) / far, -1, 1));
      const thinning = 0.36 + (0.5 * off) / 70;
      const goes = Math.min(LAST, -0.05 * Math.log(Math.exp(-receding / 0.05) + Math.exp(-thinning / 0.05)));
      const above = y - wreath((180 / Math.PI) * Math.atan2(aside, z - middle[1]));
      // Each place has a time of its own: those that go at the same one would be a stain meanwhile.
      const lasts = FIRST_GOES + ((LAST_GOES - FIRST_GOES) / LAST) * Math.max(0, goes);
      parts[4 * v + 3] = Math.round(255 * (1 + (lasts - 1) * smoothstep(-14, 22, above)));
    }
    const moustache = smoothstep(corners - 3, corners + 3, y) * (1 - smoothstep(half, half + 6, aside));
    const onChin = (1 - smoothstep(corners - 3, corners + 3, y)) * (1 - smoothstep(half + 3, half + 12, aside)) * smoothstep(chin[2] - 24, chin[2] - 10, z);
    parts[4 * v] = Math.round(255 * moustache);
    // Halfway between the two both are rounded up.
    parts[4 * v + 1] = Math.min(255 - parts[4 * v], Math.round(255 * onChin));
    parts[4 * v + 2] = 255 - parts[4 * v] - parts[4 * v + 1];
  }
  return parts;
}
