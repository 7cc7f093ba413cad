import { CanvasTexture } from 'three';
import { chance } from '../chance.js';
import { smoothstep } from '../groundwork/paint.js';
import { sharpen } from '../rendering/textures.js';
import { browLines, growBrows } from '../hair/browline.js';

/**
 * Both brows, hair by hair, along the five points of each: in red how much of the skin hairs cover, in green as much of how grey
 * brows are when these hairs turn.
 *
 * @param {import('../groundwork/paint.js').Points} at landmarks of the face at rest, mm
 * @returns {{ map: CanvasTexture, frame: [number, number, number, number] }}
 */
export function paintBrows(at) {
  const brows = browLines(at);
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
  growBrows(brows, 720, random, ({ x, y, dx, dy, t }) => {
    draw.globalAlpha = (0.2 + 0.46 * random()) * Math.min(1, 0.3 + 3 * t) * (1 - 0.5 * smoothstep(0.7, 1, t));
    draw.strokeStyle = `rgb(255 ${255 * (0.2 + 0.75 * random())} 0)`;
    draw.lineWidth = 0.13 + 0.15 * random();
    draw.beginPath();
    draw.moveTo(x, y);
    draw.quadraticCurveTo(x + dx * 0.55, y + dy * 0.75, x + dx, y + dy * 0.72);
    draw.stroke();
  });
  const map = new CanvasTexture(canvas);
  sharpen(map, 8);
  return { map, frame: [left, low, width, tall] };
}
