// Writes a face in every format into a folder, for the readers in tests/export.rs:
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
