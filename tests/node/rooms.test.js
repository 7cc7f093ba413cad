// The rooms of the source: who knows whom. Arrows point one way.

import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { test } from 'node:test';

const SOURCE = new URL('../../src/', import.meta.url);

/**
 * The code of a room, which is a file or a folder, without comments and without its tests.
 * @param {URL} folder @param {string} name
 */
function codeOf(folder, name) {
  const at = new URL(name, folder);
  const files = name.endsWith('.rs') ? [at] : readdirSync(at, { recursive: true }).filter((file) => String(file).endsWith('.rs')).map((file) => new URL(`${name}/${file}`, folder));
  return files.map((file) => readFileSync(file, 'utf8').replaceAll(/\/\/.*$/gm, '').replace(/^#\[cfg\(test\)\]\nmod tests \{[^]*$/m, '')).join('\n');
}

/**
 * Which of some rooms each knows, by the path that leads to them or by what they are known for.
 * @param {URL} folder @param {string} path
 * @param {Map<string, string[]>} [famous] names of a room that are said without it
 */
function arrows(folder, path, famous = new Map()) {
  const rooms = readdirSync(folder).filter((name) => !/^(mod|lib|error|bench)\.rs$/.test(name));
  const names = rooms.map((name) => name.replace('.rs', ''));
  return new Map(
    rooms.map((room, i) => {
      const code = codeOf(folder, room);
      const said = [...code.matchAll(new RegExp(`\\b${path}::\\{([^;]*)\\};`, 'g'))].flatMap(([, list]) => list.split(/\W+/));
      const known = names.filter((name, j) => {
        const called = [name, ...(famous.get(name) ?? [])];
        return j !== i && called.some((word) => said.includes(word) || new RegExp(`\\b${path}::${word}\\b`).test(code));
      });
      return [names[i], known];
    }),
  );
}

/** @param {Map<string, string[]>} known */
function circle(known) {
  /** @type {Set<string>} */
  const done = new Set();
  /** @param {string} room @param {string[]} way @returns {string[] | null} */
  function walk(room, way) {
    if (way.includes(room)) return [...way.slice(way.indexOf(room)), room];
    if (done.has(room)) return null;
    for (const next of known.get(room) ?? []) {
      const found = walk(next, [...way, room]);
      if (found) return found;
    }
    done.add(room);
    return null;
  }
  for (const room of known.keys()) {
    const found = walk(room, []);
    if (found) return found.join(' -> ');
  }
  return null;
}

test('a circle is found', () => {
  assert.equal(circle(new Map([['a', ['b']], ['b', ['c']], ['c', ['b']]])), 'b -> c -> b');
  assert.equal(circle(new Map([['a', ['b', 'c']], ['b', ['c']], ['c', []]])), null);
});

test('no two rooms of the core know each other, and none knows fit or wasm', () => {
  const exported = readFileSync(new URL('lib.rs', SOURCE), 'utf8').matchAll(/^pub use (\w+)::\{?([^;}]*)/gm);
  const known = arrows(SOURCE, 'crate', new Map(Array.from(exported, ([, room, list]) => [room, list.split(/\W+/).filter(Boolean)])));
  assert.ok(known.get('expression')?.includes('face'), 'types are found');
  assert.ok(known.get('face')?.includes('model'), 'arrows are found');
  assert.equal(circle(new Map([...known].filter(([room]) => !['fit', 'wasm', 'bin'].includes(room)))), null);
  for (const [room, rooms] of known) {
    if (!['fit', 'bin'].includes(room)) assert.ok(!rooms.includes('fit'), `${room} knows fit`);
    assert.ok(!rooms.includes('wasm'), `${room} knows wasm`);
  }
});

test('no two rooms of the offline half know each other', () => {
  const known = arrows(new URL('fit/', SOURCE), 'crate::fit');
  assert.ok(known.get('register')?.includes('head'), 'arrows are found');
  assert.equal(circle(known), null);
});

test('no two rooms of the page load each other', () => {
  const page = new URL('../../www/src/', import.meta.url);
  const rooms = readdirSync(page, { withFileTypes: true }).filter((entry) => entry.isDirectory()).map(({ name }) => name);
  const known = new Map(
    rooms.map((room) => {
      const files = readdirSync(new URL(room, page)).filter((name) => name.endsWith('.js'));
      const code = files.map((name) => readFileSync(new URL(`${room}/${name}`, page), 'utf8').replaceAll(/\/\*[^]*?\*\//g, '').replaceAll(/^\s*\/\/.*$/gm, '')).join('\n');
      return [room, rooms.filter((other) => new RegExp(`'\\.\\./${other}/`).test(code))];
    }),
  );
  assert.ok(known.get('stage')?.includes('head'), 'arrows are found');
  assert.equal(circle(known), null);
});
