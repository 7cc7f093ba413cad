// Writes a face in every format into a folder, and as a GLB with an appearance, for the readers in
// tests/offline/export.rs:
//
//     node tests/node/write-exports.js MODEL.phiz CODE DIR
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';

import { toGlb, toObj, toPly } from '../../pkg/export/index.js';
import { load } from '../../pkg/index.js';

const [model, code, folder] = process.argv.slice(2);
const face = (await load(await readFile(model))).fromCode(code);
for (const [ending, write] of Object.entries({ obj: toObj, ply: toPly, glb: toGlb })) {
  await writeFile(join(folder, `face.${ending}`), write(face));
}

/** One black pixel. */
const PIXEL = 'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNgAAAAAgABSK+kcQAAAABJRU5ErkJggg==';
const colour = { mimeType: 'image/png', bytes: Buffer.from(PIXEL, 'base64') };
const corner = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0);
const parts = [{ name: 'part', positions: corner, normals: corner.map((_, i) => (i % 3 === 2 ? 1 : 0)), colours: corner, triangles: Uint32Array.of(0, 1, 2), roughness: 1, targets: {} }];
const appearance = { skin: { colour, normal: colour, surface: colour }, eyes: { colour, reach: 1.9 }, parts };
await writeFile(join(folder, 'dressed.glb'), toGlb(face, { appearance }));
