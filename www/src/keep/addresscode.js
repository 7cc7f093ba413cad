import { COLOURS, readColouring, valueIn } from '../head/colouring.js';
import { decodeMarks } from '../head/marks.js';

// What the page's address has after the #: a face's code and, after tildes, its expression, its colours and the marks of its skin. Of
// the first two it has for each that is not at rest its place in a list and its value in per cent, a byte each, as
// base64url; of marks what `marks.js` writes. Colours and marks are one code, which has a tilde where there are marks.

/** @param {readonly string[]} names @param {(name: string) => number | undefined} value 0 to 1, of what is kept */
function encode(names, value) {
  const bytes = names.flatMap((name, i) => {
    const percent = value(name);
    return percent === undefined ? [] : [i, Math.round(100 * percent)];
  });
  return btoa(String.fromCharCode(...bytes)).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');
}

/**
 * @param {readonly string[]} names @param {string} code
 * @returns {Record<string, number>} without what a newer version of this page may have beside them
 * @throws when it is no such code
 */
function decode(names, code) {
  const bytes = atob(code.replaceAll('-', '+').replaceAll('_', '/'));
  if (bytes.length % 2) throw new Error('it is cut short');
  /** @type {Record<string, number>} */
  const values = {};
  for (let at = 0; at < bytes.length; at += 2) {
    const [i, percent] = [bytes.charCodeAt(at), bytes.charCodeAt(at + 1)];
    if (percent > 100) throw new Error('it has more than all of something');
    if (i < names.length) values[names[i]] = percent / 100;
  }
  return values;
}

/** @param {readonly string[]} names @param {Record<string, number>} expression @returns {string} empty at rest */
export const encodeExpression = (names, expression) => encode(names, (name) => (expression[name] >= 0.005 ? expression[name] : undefined));

/** @param {readonly string[]} names @param {string} code @throws when it is no expression */
export const decodeExpression = (names, code) => decode(names, code);

/** @param {import('../head/colouring.js').Colouring} colouring @returns {string} empty at rest */
export function encodeColouring(colouring) {
  const colours = encode(COLOURS, (name) => (name in colouring ? valueIn(colouring, name) : undefined));
  return colouring.marks ? `${colours}~${colouring.marks}` : colours;
}

/** @param {string} code @throws when it is no colouring */
export function decodeColouring(code) {
  const [colours, marks = ''] = code.split('~');
  decodeMarks(marks);
  return readColouring({ ...decode(COLOURS, colours), marks });
}

/** What a sentence has behind a link, which some programs take for a part of it. */
const BEHIND = /(?:[.,:;!?'")\]>]|%(?:22|3e|c2%bb|e2%80%9[9d]))+$/i;

/** @param {string} hash of which some programs write tildes as others write spaces */
export function splitHash(hash) {
  const [code, expression = '', ...looks] = hash.replace(/^#/, '').replace(BEHIND, '').replaceAll(/%7e/gi, '~').split('~');
  return { code, expression, colouring: looks.slice(0, 2).join('~').replace(/~$/, '') };
}

/** @param {{ code: string, expression: string, colouring: string }} parts encoded */
export const joinHash = ({ code, expression, colouring }) => [code, expression, colouring].join('~').replace(/~+$/, '');
