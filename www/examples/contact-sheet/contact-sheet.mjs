#!/usr/bin/env node
// Random people of a model on one sheet, drawn without any graphics card:
//
//     npm install --install-links path/to/pkg pngjs    (the package that ./build.sh build leaves)
//     node contact-sheet.mjs model.phiz sheet.png [columns rows seed]
import { readFile, writeFile } from 'node:fs/promises';
import { load } from 'phiz';
import { PNG } from 'pngjs';

const SIZE = 220;
/** Pixels a millimetre. */
const SCALE = 0.78;
const LIGHT = [-0.4, 0.45, 0.8];

const [file, output, columns = '6', rows = '4', seed = '1'] = process.argv.slice(2);
const [across, down, first] = [columns, rows, seed].map(Number);
if (!file || !output || !(across >= 1 && down >= 1 && first >= 0 && [across, down, first].every(Number.isInteger))) {
  console.error('usage: node contact-sheet.mjs model.phiz sheet.png [columns rows seed]');
  process.exit(2);
}
process.on('uncaughtException', ({ message }) => {
  console.error(message);
  process.exit(1);
});
const model = await load(await readFile(file));
const sheet = new PNG({ width: across * SIZE, height: down * SIZE });
sheet.data.fill(0xee);

const face = model.face();
for (let i = 0; i < across * down; i++) {
  face.reset();
  face.randomize({ seed: first + i });
  draw(face, (i % across) * SIZE, Math.floor(i / across) * SIZE);
  console.log(`${i + 1}\t${face.code}`);
}
model.free();
await writeFile(output, PNG.sync.write(sheet));

/** A face from the front into a square of the sheet: triangles, a depth buffer, one light. */
function draw({ positions, normals }, left, top) {
  const depth = new Float32Array(SIZE * SIZE).fill(-Infinity);
  const { triangles, uvVertices, colours } = model;
  // Three quarters of a profile says more of a face than its front.
  const [cos, sin] = [Math.cos(0.5), Math.sin(0.5)];
  const screen = (v) => {
    const [x, y, z] = positions.subarray(3 * v, 3 * v + 3);
    return [SIZE / 2 + SCALE * (x * cos + z * sin) + 28, SIZE / 2 - SCALE * y, z * cos - x * sin];
  };
  for (let t = 0; t < triangles.length; t += 3) {
    const v = [0, 1, 2].map((k) => uvVertices[triangles[t + k]]);
    const [a, b, c] = v.map(screen);
    const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if (area >= 0) continue; // It faces away: rows go down.
    const shades = v.map((vertex) => {
      const [nx, ny, nz] = normals.subarray(3 * vertex, 3 * vertex + 3);
      const turned = [nx * cos + nz * sin, ny, nz * cos - nx * sin];
      const facing = turned[0] * LIGHT[0] + turned[1] * LIGHT[1] + turned[2] * LIGHT[2];
      return 0.35 + 0.72 * Math.max(0, facing);
    });
    const [x0, x1] = [Math.min(a[0], b[0], c[0]), Math.max(a[0], b[0], c[0])].map(Math.round);
    const [y0, y1] = [Math.min(a[1], b[1], c[1]), Math.max(a[1], b[1], c[1])].map(Math.round);
    for (let y = Math.max(0, y0); y <= Math.min(SIZE - 1, y1); y++) {
      for (let x = Math.max(0, x0); x <= Math.min(SIZE - 1, x1); x++) {
        const wb = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
        const wc = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
        const wa = 1 - wb - wc;
        if (wa < 0 || wb < 0 || wc < 0) continue;
        const z = wa * a[2] + wb * b[2] + wc * c[2];
        if (z <= depth[y * SIZE + x]) continue;
        depth[y * SIZE + x] = z;
        const shade = wa * shades[0] + wb * shades[1] + wc * shades[2];
        const at = 4 * ((top + y) * sheet.width + left + x);
        for (let k = 0; k < 3; k++) {
          const colour = wa * colours[3 * v[0] + k] + wb * colours[3 * v[1] + k] + wc * colours[3 * v[2] + k];
          sheet.data[at + k] = Math.min(255, colour * shade);
        }
      }
    }
  }
}
