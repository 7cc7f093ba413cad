// The Node example, run as a person would who has installed the package beside it.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { cp, mkdir, mkdtemp, readFile, rm, symlink, writeFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

const here = (path) => fileURLToPath(new URL(`../../${path}`, import.meta.url));
const { PNG } = createRequire(here('www/package.json'))('pngjs');

test('a contact sheet of six people', async () => {
  const folder = await mkdtemp(join(tmpdir(), 'phiz-'));
  try {
    await cp(here('www/examples/contact-sheet/contact-sheet.mjs'), join(folder, 'contact-sheet.mjs'));
    // As `npm init` leaves it.
    await writeFile(join(folder, 'package.json'), '{ "type": "commonjs" }');
    await mkdir(join(folder, 'node_modules'));
    await symlink(here('pkg'), join(folder, 'node_modules/phiz'));
    await symlink(here('www/node_modules/pngjs'), join(folder, 'node_modules/pngjs'));
    const run = (...rest) => spawnSync(process.execPath, ['contact-sheet.mjs', ...rest], { cwd: folder, encoding: 'utf8' });
    const { status, stdout, stderr } = run(here('www/public/model.phiz'), 'sheet.png', '3', '2', '7');
    assert.equal(status, 0, stderr);
    assert.match(run(here('www/public/model.phiz'), 'sheet.png', 'x', '2').stderr, /^usage: /, 'what is no number is told');
    for (const [model, sheet] of [['nowhere.phiz', 'sheet.png'], ['contact-sheet.mjs', 'sheet.png'], [here('www/public/model.phiz'), 'nowhere/sheet.png']]) {
      const failed = run(model, sheet, '1', '1');
      assert.equal(failed.status, 1);
      assert.match(failed.stderr, /^(ENOENT.*nowhere|not a usable phiz blob).*\n$/, 'one line');
    }
    const codes = stdout.trim().split('\n').map((line) => line.split('\t')[1]);
    assert.equal(new Set(codes).size, 6, 'six people, each with a code');

    const sheet = PNG.sync.read(await readFile(join(folder, 'sheet.png')));
    assert.deepEqual([sheet.width, sheet.height], [660, 440]);
    const square = (i) => {
      const rows = [];
      for (let y = 0; y < 220; y++) {
        const at = 4 * ((Math.floor(i / 3) * 220 + y) * 660 + (i % 3) * 220);
        rows.push(sheet.data.subarray(at, at + 880));
      }
      return Buffer.concat(rows);
    };
    for (let i = 0; i < 6; i++) {
      const pixels = square(i);
      let drawn = 0;
      for (let at = 0; at < pixels.length; at += 4) if (pixels[at] !== 0xee || pixels[at + 2] !== 0xee) drawn += 1;
      const part = drawn / (220 * 220);
      assert.ok(part > 0.25 && part < 0.85, `person ${i} fills ${part} of the square`);
      assert.equal(pixels[0], 0xee, 'the corner is empty');
      if (i > 0) assert.ok(!pixels.equals(square(i - 1)), 'somebody else');
    }
    const usage = run();
    assert.equal(usage.status, 2);
    assert.match(usage.stderr, /^usage: /);
  } finally {
    await rm(folder, { recursive: true });
  }
});
