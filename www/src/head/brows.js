import { CanvasTexture } from 'three';
import { chance } from '../chance.js';
import { points, smoothstep } from '../groundwork/paint.js';
import { sharpen } from '../rendering/textures.js';

/**
 * Both brows, hair by hair, along the five points of each: in red how much of the skin hairs cover, in green as much of how grey
 * brows are when these hairs turn.
 *
 * @param {import('../groundwork/paint.js').Points} at landmarks of the face at rest, mm
 * @returns {{ map: CanvasTexture, frame: [number, number, number, number] }}
 */
export function paintBrows(at) {
  const brows = [points(at, 17, 21).reverse(), points(at, 22, 26)];
  const all = brows.flat();
  const left = Math.min(...all.map((p) => p[0])) - 9;
  const right = Math.max(...all.map((p) => p[0])) + 9;
  const low = Math.min(...all.map((p) => p[1])) - 12;
  const width = right - left;
  const tall = width / 4;
  const canvas = document.createElement('canvas');
  canvas.width = 2048;
  canvas.height = 512;
  const draw = canvas.getContext('2d');
  if (!draw) throw new Error('this browser gives no 2D canvas');
  draw.fillStyle = '#000';
  draw.fillRect(0, 0, canvas.width, canvas.height);
  const scale = canvas.width / width;
  draw.setTransform(scale, 0, 0, -scale, -left * scale, canvas.height + low * scale);
  draw.lineCap = 'round';
  const random = chance(29);
  for (const brow of brows) {
    const side = Math.sign(brow[4][0] - brow[0][0]);
    const along = (/** @type {number} */ t) => {
      const s = Math.min(3.999, t * 4);
      const i = Math.floor(s);
      const [a, b] = [brow[i], brow[i + 1]];
      return [a[0] + (b[0] - a[0]) * (s - i), a[1] + (b[1] - a[1]) * (s - i)];
    };
    for (let n = 0; n < 720; n++) {
      const t = random();
      const across = (random() + random()) / 2 - 0.5;
      // A brow begins soft, is fullest at a quarter and runs out in a tail.
      const half = 4.3 * Math.min(1, 0.6 + 2 * t) * (1 - 0.8 * smoothstep(0.35, 1, t));
      // As many would be one stroke where it is narrow.
      if (random() > 0.12 + 0.2 * half) continue;
      const [cx, cy] = along(t);
      const x = cx + (random() - 0.5) * 1.2 - side * 1.5 * (1 - t);
      const y = cy + across * 2 * half - 1.2;
      // Hairs stand up at the inner end and lie down towards the temple; the upper ones point
      // down a little, the lower ones up.
      const [ax, ay] = along(Math.max(0, t - 0.1));
      const [bx, by] = along(Math.min(1, t + 0.1));
      const course = Math.atan2(by - ay, Math.abs(bx - ax));
      const rise =
        course + 1.2 * (1 - smoothstep(0, 0.5, t)) + 0.12 - 0.7 * across + (random() - 0.5) * 0.35;
      const length = (3.2 + 3.2 * random()) * (1 - 0.38 * t);
      const dx = side * Math.cos(rise) * length;
      const dy = Math.sin(rise) * length;
      draw.globalAlpha = (0.2 + 0.46 * random()) * Math.min(1, 0.3 + 3 * t) * (1 - 0.5 * smoothstep(0.7, 1, t));
      draw.strokeStyle = `rgb(255 ${255 * (0.2 + 0.75 * random())} 0)`;
      draw.lineWidth = 0.13 + 0.15 * random();
      draw.beginPath();
      draw.moveTo(x, y);
      draw.quadraticCurveTo(x + dx * 0.55, y + dy * 0.75, x + dx, y + dy * 0.72);
      draw.stroke();
    }
  }
  const map = new CanvasTexture(canvas);
  sharpen(map, 8);
  return { map, frame: [left, low, width, tall] };
}
