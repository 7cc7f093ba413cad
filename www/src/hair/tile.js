import { chance } from '../chance.js';
import { TILE } from './crop.js';

// A tile of hair that is cropped to the skin, or a beard that is.

/** Of the tile, pixels. */
const SIZE = 512;
const HAIRS = 2800;

/**
 * A tile of hairs that lie along the second axis. Red: how much of the skin they cover. Green: how light each is.
 * Blue: how far the surface leans along the first axis.
 * @returns {import('../rendering/textures.js').Pixels}
 */
export function paintStrands() {
  // A worker has one kind, and old browsers have the other on the page.
  const canvas = typeof OffscreenCanvas === 'function' ? new OffscreenCanvas(SIZE, SIZE) : Object.assign(document.createElement('canvas'), { width: SIZE, height: SIZE });
  const draw = /** @type {OffscreenCanvasRenderingContext2D | CanvasRenderingContext2D | null} */ (canvas.getContext('2d', { willReadFrequently: true }));
  if (!draw) throw new Error('this browser gives no 2D canvas');
  draw.fillStyle = 'rgb(0 128 128)';
  draw.fillRect(0, 0, SIZE, SIZE);
  const scale = SIZE / TILE;
  draw.lineCap = 'round';
  const random = chance(41);
  for (let n = 0; n < HAIRS; n++) {
    const [x, y] = [random() * TILE, random() * TILE];
    const length = 2.4 + 2.6 * random();
    const lean = 0.9 * (random() + random() - 1);
    const [dx, dy] = [length * Math.sin(lean), length * Math.cos(lean)];
    const bend = 0.5 * (random() - 0.5);
    const width = 0.11 + 0.07 * random();
    const light = Math.round(70 + 150 * random());
    draw.globalAlpha = 0.55 + 0.45 * random();
    // What crosses an edge comes in again at the other one.
    for (const i of [-TILE, 0, TILE]) {
      for (const j of [-TILE, 0, TILE]) {
        if (x + i < -6 || x + i > TILE + 6 || y + j < -6 || y + j > TILE + 6) continue;
        // Both flanks of a hair.
        for (const side of [-1, 1]) {
          draw.setTransform(scale, 0, 0, scale, (x + i + side * 0.25 * width) * scale, (y + j) * scale);
          draw.strokeStyle = `rgb(255 ${light} ${128 + 80 * side})`;
          draw.lineWidth = width * (side < 0 ? 1 : 0.55);
          draw.beginPath();
          draw.moveTo(0, 0);
          draw.quadraticCurveTo(dx * 0.5 + bend, dy * 0.5, dx, dy);
          draw.stroke();
        }
      }
    }
  }
  return { size: SIZE, rgba: draw.getImageData(0, 0, SIZE, SIZE).data };
}
