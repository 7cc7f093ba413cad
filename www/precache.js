// The last step of the build: the service worker learns which files the page is made of.
//
//     node precache.js [dist]
import { createHash } from 'node:crypto';
import { readFile, readdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = (/** @type {string} */ path) => fileURLToPath(new URL(path, import.meta.url));
const dist = process.argv[2] ?? here('dist');

/** Not part of the page: pages of their own, what is asked for rarely, and this. */
const APART = /^(designer|examples)\/|^synthetic\.phiz$|^service-worker\.js$|^assets\/(crowd|three|examples)-/;
/** What photos take, three times as much as all the rest: kept by those who open one. */
const LATER = /^(face_mesh|selfie_segmentation)-|^astronaut\.jpg$|^assets\/(room|photo|photo_bg|worker|faces\.worker)-/;

/** @type {Record<string, string>} */
const files = {};
/** @type {Record<string, string>} */
const later = {};
for (const entry of (await readdir(dist, { recursive: true, withFileTypes: true })).filter((e) => e.isFile())) {
  const path = join(entry.parentPath, entry.name);
  const name = path.slice(join(dist, '/').length).replaceAll('\\', '/');
  if (APART.test(name)) continue;
  const digest = createHash('sha256').update(await readFile(path)).digest('hex');
  (LATER.test(name) ? later : files)[name === 'index.html' ? './' : name] = digest;
}
let source = await readFile(here('worker/service-worker.js'), 'utf8');
for (const [place, names] of /** @type {const} */ ([['/* precache */ {}', files], ['/* later */ {}', later]])) {
  if (!source.includes(place)) throw new Error('worker/service-worker.js has no place for the files');
  source = source.replace(place, JSON.stringify(Object.fromEntries(Object.entries(names).sort()), null, 2));
}
await writeFile(join(dist, 'service-worker.js'), source);
