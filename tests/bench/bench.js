// The report of ./build.sh bench: phiz beside its peers, in Node and in headless Chromium, one after
// the other on this machine. Ratios are what to read: microseconds are this machine's, and this
// moment's.
//
//     node tests/bench/bench.js        (after ./build.sh bench has built what it needs)

import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { cpus } from 'node:os';
import { fileURLToPath } from 'node:url';
import { gunzipSync } from 'node:zlib';

import { load } from '../../pkg/index.js';
import { launch, serve } from '../browser/site.js';
import { budget } from './budget.js';
import { measure } from './contenders.js';
import { firstFace } from './first-face.js';

const ROOT = fileURLToPath(new URL('../..', import.meta.url));
const file = (/** @type {string} */ path) => readFile(new URL(`../../${path}`, import.meta.url));
const say = (/** @type {string} */ what) => process.stderr.write(`  ${what}\n`);

async function inNode() {
  const [packed, head] = await Promise.all([file('www/public/model.phiz'), file('www/public/head.phiz')]);
  const kernels = {};
  for (const build of ['simd', 'scalar']) {
    const glue = await import(`../../target/bench/${build}/bench.js`);
    glue.initSync({ module: await file(`target/bench/${build}/bench_bg.wasm`) });
    kernels[build] = glue.Bench;
  }
  const three = await import('../../www/node_modules/three/build/three.module.js');
  const blob = gunzipSync(packed);
  return measure({ load, three, packed, blob, head, kernels, say });
}

async function inChromium() {
  const site = await serve({ root: () => ROOT.replace(/\/$/, '') });
  const browser = await launch({ measured: true });
  try {
    const page = await browser.newPage();
    page.on('console', (message) => say(message.text()));
    await page.goto(`${site.url}tests/bench/page.html`);
    await page.waitForFunction(() => 'report' in window || 'failure' in window, null, { timeout: 600_000 });
    const { report, failure } = await page.evaluate(() => ({ report: window.report, failure: window.failure }));
    if (failure) throw new Error(failure);
    return { version: browser.version(), ...report };
  } finally {
    await browser.close();
    await site.close();
  }
}

const cell = (/** @type {string} */ text, /** @type {number} */ width) => text.padStart(width);
/**
 * @param {string} title
 * @param {Record<string, { us: number, spread: [number, number] }>} race
 */
function table(title, race) {
  console.log(`\n${title}`);
  const base = race['phiz, simd'].us;
  for (const [name, { us, spread }] of Object.entries(race)) {
    const range = `(${spread.map((x) => x.toFixed(1)).join(' to ')})`;
    console.log(`  ${name.padEnd(31)}${cell(us.toFixed(1), 9)} us ${range.padEnd(24)}${cell((us / base).toFixed(2), 8)} x`);
  }
}

/** Vertices of the small region that the aim for events without a surround speaks of. */
const SMALL = 3000;

/** What an event of such a region would take, between two that have less and more. @param {any} report */
function small({ events, moved }) {
  const names = ['nose, next to no surround', 'mouth, next to no surround'];
  const [from, to] = names.map((name) => moved[name]);
  const at = (/** @type {string} */ who) => {
    const [less, more] = names.map((name) => events[name][who].us);
    return less + ((SMALL - from) / (to - from)) * (more - less);
  };
  const [own, other] = [at('phiz, simd'), at('changed modes in JS, three.js')];
  console.log(`\na region of ${SMALL} vertices, between nose (${from}) and mouth (${to}): ${own.toFixed(1)} us, three.js ${other.toFixed(0)} us, ${(other / own).toFixed(0)} x`);
}

/** @param {string} where @param {any} report */
function print(where, report) {
  console.log(`\n== ${where}: ${report.vertices} vertices, ${report.triangles} triangles, ${report.modes} coefficients`);
  for (const [what, race] of Object.entries(report.events)) table(`${what}: an event, to positions and normals`, race);
  small(report);
  table('normals of all vertices', report.normals);
  table(`sums of all modes, ${(report.modeBytes / 1e6).toFixed(2)} MB of i16`, report.sums);
  console.log('\nloading, ms');
  for (const [what, ms] of Object.entries(report.loadMs)) console.log(`  ${what.padEnd(31)}${cell(ms.toFixed(1), 9)}`);
  for (const [count, { facesPerSecond, bytesPerFace }] of Object.entries(report.crowd)) {
    console.log(`  ${`${count} faces at once`.padEnd(31)}${cell(facesPerSecond.toFixed(0), 9)} faces a second, ${(bytesPerFace / 1e6).toFixed(2)} MB each`);
  }
  console.log(`\npositions are ${report.positionsApartMm.toExponential(1)} mm from those of f32 sums, normals ${report.normalsApart.toExponential(1)} from three.js's`);
}

const { REVISION: three } = await import('../../www/node_modules/three/build/three.module.js');
console.log(`${cpus()[0].model}, Node ${process.version}, three.js r${three}`);
console.log('Medians of rounds in turn (least to most); ratios to phiz with simd.');
say('Node');
const node = await inNode();
print('Node', node);
console.log(`\nover the wire: ${node.wire.model} bytes; as f32, before rounding, in gzip ${node.wire.floatsInGzip}: 1 / ${(node.wire.floatsInGzip / node.wire.model).toFixed(1)}`);
say('Chromium');
const chromium = await inChromium();
print(`Chromium ${chromium.version}`, chromium);

say('the first face');
const first = await firstFace();
const [page, complete, sphere] = [first.page, first.complete, first.sphere].map((times) => times[Math.floor(times.length / 2)]);
console.log(`\nthe page's first face took ${page.toFixed(0)} ms, a sphere of its skin ${sphere.toFixed(0)} ms: ${(page / sphere).toFixed(2)} x; with its skin and light ${complete.toFixed(0)} ms: ${(complete / sphere).toFixed(2)} x`);

say('a slider that is dragged');
const dragged = await budget();
console.log('\nthe main thread while a slider is dragged, a frame: beside drawing (the aim is 2 ms), in nine of ten frames; with what three.js does to draw, beside WebGL; one drawing');
for (const [name, { events, most, ms, draws }] of Object.entries(dragged)) {
  const figures = [events, most, ms].map((figure) => cell(figure.toFixed(2), 7)).join(' ms,');
  console.log(`  ${name.padEnd(34)}${figures} ms, ${draws.toFixed(2)} drawings`);
}

const target = new URL('../../target/', import.meta.url);
await mkdir(target, { recursive: true });
// Made just before, where there is Python.
const made = (/** @type {string} */ path) => file(path).then(JSON.parse, () => null);
const offline = await made('target/bench/offline.json');
const trainer = { sparse: await made('target/peers/sparse.json'), registration: await made('target/peers/registration.json') };
const all = { cpu: cpus()[0].model, nodeVersion: process.version, three, node, chromium, first, dragged, offline, trainer };
await writeFile(new URL('bench.json', target), `${JSON.stringify(all, null, 2)}\n`);
say('target/bench.json');
