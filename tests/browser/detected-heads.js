// Heads of the model as the page draws them, and where MediaPipe's face mesh sees its points on them: what
// the detector's errors are learned from (detector-bias.js), and what fits of its points are judged by.
//
//     node tests/browser/detected-heads.js COUNT SEED OUT.json [FOLDER]
//
// The built page draws random faces, half of them with an expression, in random colours, hair and poses (yaw to 40
// degrees, pitch to 14, roll to 10). OUT.json has of each the face's code, its expression, the camera as a
// 3 x 4 matrix from mm to px, and the detector's points in px. FOLDER gets the pictures.

import { mkdirSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { chance } from '../../www/src/chance.js';
import { DIST, launch, open, serve, turnHead } from './site.js';

const [count, seed, out, folder] = [Number(process.argv[2]), Number(process.argv[3]), process.argv[4], process.argv[5]];
if (!(count > 0) || !Number.isInteger(seed) || !out) {
  console.error('usage: node tests/browser/detected-heads.js COUNT SEED OUT.json [FOLDER]');
  process.exit(2);
}
if (folder) mkdirSync(folder, { recursive: true });

/**
 * The 3 x 4 matrix, up to a factor, that sends points to where they are seen: the least singular vector of the
 * direct linear transform, by inverse iteration.
 * @param {number[][]} points @param {number[][]} seen
 */
function projection(points, seen) {
  const normal = Array.from({ length: 12 }, () => new Float64Array(12));
  for (const [i, point] of points.entries()) {
    const [x, y, z, w] = [...point.map((value) => value / 100), 1];
    const [u, v] = seen[i].map((value) => value / 300 - 1);
    for (const row of [[x, y, z, w, 0, 0, 0, 0, -u * x, -u * y, -u * z, -u * w], [0, 0, 0, 0, x, y, z, w, -v * x, -v * y, -v * z, -v * w]]) {
      for (let a = 0; a < 12; a++) for (let b = 0; b < 12; b++) normal[a][b] += row[a] * row[b];
    }
  }
  for (let a = 0; a < 12; a++) normal[a][a] += 1e-12;
  let vector = Float64Array.from({ length: 12 }, (_, i) => 1 / (i + 1));
  for (let step = 0; step < 8; step++) {
    const rows = normal.map((row, a) => [...row, vector[a]]);
    for (let a = 0; a < 12; a++) {
      const best = rows.slice(a).reduce((most, row, i) => (Math.abs(row[a]) > Math.abs(rows[most][a]) ? a + i : most), a);
      [rows[a], rows[best]] = [rows[best], rows[a]];
      for (let b = 0; b < 12; b++) {
        if (b === a) continue;
        const factor = rows[b][a] / rows[a][a];
        for (let c = a; c <= 12; c++) rows[b][c] -= factor * rows[a][c];
      }
    }
    const next = rows.map((row, a) => row[12] / row[a]);
    const length = Math.hypot(...next);
    vector = Float64Array.from(next, (value) => value / length);
  }
  // Back from the units in which the equations are well conditioned.
  const [first, second, third] = [0, 4, 8].map((at) => [...vector.subarray(at, at + 4)]);
  const rows = [first.map((value, i) => 300 * (value + third[i])), second.map((value, i) => 300 * (value + third[i])), third];
  return rows.flatMap((row) => row.map((value, i) => (i < 3 ? value / 100 : value)));
}

const site = await serve();
const browser = await launch();
const { page } = await open(browser, site, { sharp: true, drawn: true, viewport: { width: 1000, height: 655 }, colorScheme: 'light' });
await page.locator('.invitation').getByRole('button', { name: 'Close' }).click();
await page.getByRole('tab', { name: 'Expressions' }).click();
await page.getByRole('slider', { name: 'mouthSmile' }).first().waitFor({ timeout: 60_000 });
await page.getByRole('tab', { name: 'Looks' }).click();
await page.locator('#colour-hair').waitFor();
await page.evaluate(() => {
  for (const over of document.querySelectorAll('.hint, .toast, .views, .explain-open')) over.style.visibility = 'hidden';
});
const box = await page.locator('canvas').first().boundingBox();
const seeker = readdirSync(join(DIST, 'assets')).find((name) => name.startsWith('faces.worker'));
const mesh = readdirSync(DIST).find((name) => name.startsWith('face_mesh'));
const other = await browser.newPage();
await other.goto(`${site.url}icon.svg`);
await other.evaluate(
  ([worker, files]) => {
    const seeker = new Worker(worker);
    window.find = (/** @type {string} */ png, /** @type {number} */ roll) =>
      fetch(`data:image/png;base64,${png}`)
        .then((answer) => answer.blob())
        .then(createImageBitmap)
        .then((drawn) => {
          const canvas = new OffscreenCanvas(drawn.width, drawn.height);
          const context = canvas.getContext('2d');
          context.fillStyle = '#dadcdc';
          context.fillRect(0, 0, canvas.width, canvas.height);
          context.translate(canvas.width / 2, canvas.height / 2);
          context.rotate(roll);
          context.drawImage(drawn, -canvas.width / 2, -canvas.height / 2);
          const photo = canvas.transferToImageBitmap();
          return new Promise((done, failed) => {
            seeker.onmessage = ({ data }) => {
              if (data.error) failed(new Error(data.error));
              else if (data.answer) done(data.answer.map((points) => [...points]));
            };
            seeker.postMessage({ folder: files, photo }, [photo]);
          });
        });
  },
  [`${site.url}assets/${seeker}`, `${site.url}${mesh}/`],
);

const heads = [];
let pose = [0, 0];
const RADIAN = Math.PI / 180;
for (let i = 0; i < count; i++) {
  const random = chance(1000 * seed + i);
  const between = (/** @type {number} */ low, /** @type {number} */ high) => low + (high - low) * random();
  const ofBrows = chance(1000 * seed + i + 500_000);
  /** Two brows in three are within a third of the slider around its middle. */
  const aroundHalf = () => (ofBrows() + ofBrows() + ofBrows()) / 3;
  const looks = {
    skin: between(0.03, 0.95), hair: between(0.1, 1), iris: random(), lips: between(0.2, 0.7), blood: between(0.3, 0.7), brows: between(0.3, 0.8),
    crop: random() < 0.3 ? random() : 0, length: random() < 0.75 ? between(0.12, 0.9) : 0, comb: random(), parting: random(), curl: random() ** 2,
    beard: random() < 0.25 ? random() : 0, lines: random() < 0.4 ? random() : 0,
    browBreadth: 0.2 + 0.7 * ofBrows(), browArch: aroundHalf(), browSlant: aroundHalf(), browApart: aroundHalf(), browRaise: aroundHalf(),
  };
  const names = [['mouthSmileLeft', 'mouthSmileRight', 'cheekSquintLeft', 'cheekSquintRight'], ['jawOpen'], ['browInnerUp'], ['mouthUpperUpLeft', 'mouthUpperUpRight', 'mouthSmileLeft', 'mouthSmileRight'], ['browDownLeft', 'browDownRight'], ['eyeBlinkLeft', 'eyeBlinkRight']];
  /** @type {Record<string, number>} */
  const expression = {};
  if (i % 2) {
    for (const set of names) {
      const weight = random() < 0.35 ? Math.round(between(10, set[0] === 'eyeBlinkLeft' ? 35 : set[0] === 'jawOpen' ? 45 : 90)) / 100 : 0;
      for (const name of set) if (weight > 0) expression[name] = weight;
    }
  }
  const turn = [between(-40, 40), between(-14, 14)];
  const roll = between(-10, 10) * RADIAN;
  const { code, positions } = await page.evaluate(
    async ({ seed, looks, expression }) => {
      const { model, face } = window.designer;
      for (const [name, value] of Object.entries(looks)) {
        const slider = document.getElementById(`colour-${name}`);
        if (!slider) continue;
        slider.value = String(value);
        slider.dispatchEvent(new Event('input', { bubbles: true }));
        slider.dispatchEvent(new Event('change', { bubbles: true }));
      }
      const one = model.face();
      one.randomize({ seed, spread: 1 });
      const bytes = model.expressions.flatMap((name, at) => (expression[name] ? [at, Math.round(100 * expression[name])] : []));
      const encoded = btoa(String.fromCharCode(...bytes)).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');
      const colours = location.hash.split('~')[2] ?? '';
      const { code } = one;
      location.hash = [code, encoded, colours].join('~');
      one.free();
      const started = performance.now();
      while (face.code !== code || JSON.stringify(Object.keys(face.expression).sort()) !== JSON.stringify(Object.keys(expression).sort())) {
        if (performance.now() - started > 20_000) throw new Error(`the face did not come: ${JSON.stringify(face.expression)} ${JSON.stringify(expression)}`);
        await new Promise((done) => setTimeout(done, 20));
      }
      const points = model.landmarks.map(({ stencil }) => [0, 1, 2].map((axis) => stencil.reduce((sum, [v, w]) => sum + w * face.positions[3 * v + axis], 0)));
      return { code, positions: points };
    },
    { seed: 100_000 * seed + i, looks, expression },
  );
  await turnHead(page, pose, turn);
  pose = turn;
  const onScreen = await page.evaluate(() => window.designer.model.landmarks.map(({ name }) => window.designer.onScreen(name)));
  const png = await page.locator('canvas').first().screenshot();
  const seen = onScreen.map((at) => [at.x - box.x, at.y - box.y]);
  const [dx, dy] = [box.width / 2, box.height / 2];
  const rolled = seen.map(([u, v]) => [
    dx + Math.cos(roll) * (u - dx) - Math.sin(roll) * (v - dy),
    dy + Math.sin(roll) * (u - dx) + Math.cos(roll) * (v - dy),
  ]);
  const matrix = projection(positions, rolled);
  const worst = Math.max(
    ...positions.map((p, k) => {
      const [u, v, w] = [0, 4, 8].map((at) => matrix[at] * p[0] + matrix[at + 1] * p[1] + matrix[at + 2] * p[2] + matrix[at + 3]);
      return Math.hypot(u / w - rolled[k][0], v / w - rolled[k][1]);
    }),
  );
  if (!(worst < 0.05)) throw new Error(`the camera is off by ${worst} px`);
  const faces = await other.evaluate(([picture, angle]) => window.find(picture, angle), [png.toString('base64'), roll]);
  if (folder) writeFileSync(join(folder, `${i}.png`), png);
  process.stderr.write(`\r${i + 1} of ${count}, ${faces.length} faces   `);
  if (faces.length !== 1) continue;
  const rounded = (/** @type {number[]} */ values, /** @type {number} */ digits) => values.map((value) => Number(value.toPrecision(digits)));
  heads.push({ code, expression, size: [Math.round(box.width), Math.round(box.height)], camera: rounded(matrix, 9), points: rounded(faces[0], 5) });
}
process.stderr.write('\n');
// The detector misses few.
if (heads.length < 0.75 * count) throw new Error(`on ${heads.length} of ${count} heads a face was found`);
writeFileSync(out, `[\n${heads.map((head) => JSON.stringify(head)).join(',\n')}\n]\n`);
await browser.close();
await site.close();
