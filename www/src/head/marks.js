// Marks of the skin, which sit at a place of it: moles, scars, birthmarks. A colouring holds them as one string, which links have as their
// fourth part: it is compared, kept and copied as a number is.

/** What a link keeps of a kind is its place here: append only. */
export const KINDS = /** @type {const} */ (['mole', 'scar', 'birthmark']);
/** As many has a face at most: a shader looks at each of them for each pixel. */
export const MOST = 12;

/**
 * How large each kind is, mm on a head of the model's own size: across a mole and a birthmark, and how wide a scar is. A byte counts steps.
 * @type {Readonly<Record<Kind, { least: number, most: number, step: number }>>}
 */
export const SIZES = {
  mole: { least: 1, most: 15, step: 0.1 },
  scar: { least: 0.5, most: 8, step: 0.1 },
  birthmark: { least: 5, most: 100, step: 0.5 },
};

/** How each kind is when it is put on. @type {Readonly<Record<Kind, Look>>} */
export const FIRST = {
  mole: { size: 4, tone: 0.6, form: 0.4, strength: 1 },
  scar: { size: 2.5, tone: 0.6, form: 0.65, strength: 1 },
  birthmark: { size: 30, tone: 0.85, form: 0.2, strength: 0.8 },
};

/** @typedef {typeof KINDS[number]} Kind */
/**
 * A place on the skin, which goes with it: a triangle of the mesh, counted without those of eyeballs, and how much of its second and of its
 * third corner is there, of 255.
 * @typedef {{ readonly triangle: number, readonly b: number, readonly c: number }} Place
 */
/**
 * `size` in mm; the others from 0 to 1. `tone` is from the skin's own to brown (mole), from paler to red (scar), from brown to the red of wine
 * (birthmark); `form` is from flat to raised (mole), from sunken to raised with 0.5 between (scar), and which outline it has (birthmark);
 * `strength` is how much of it is to be seen.
 * @typedef {{ readonly size: number, readonly tone: number, readonly form: number, readonly strength: number }} Look
 */
/** A scar goes from a place to another. @typedef {{ readonly kind: Kind, readonly at: Place, readonly to?: Place } & Look} Mark */

/** What is after a mark's kind and its length: two bytes of a triangle and two of the place on it, its look, and the end of a scar. */
const LENGTH = 8;
const PLACE = 4;

const percent = (/** @type {number} */ value) => Math.round(100 * Math.min(1, Math.max(0, value)));
/** @param {Place} place */
const bytesOf = ({ triangle, b, c }) => [triangle >> 8, triangle & 255, b, c];

/** @param {Mark} mark @returns {number[]} */
function bytesOfMark({ kind, at, to, size, tone, form, strength }) {
  const { least, most, step } = SIZES[kind];
  const look = [Math.round(Math.min(most, Math.max(least, size)) / step), percent(tone), percent(form), percent(strength)];
  const bytes = [...bytesOf(at), ...look, ...(to ? bytesOf(to) : [])];
  return [KINDS.indexOf(kind), bytes.length, ...bytes];
}

/** @param {readonly Mark[]} marks @returns {string} empty of none */
export const encodeMarks = (marks) => btoa(String.fromCharCode(...marks.flatMap(bytesOfMark))).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');

/**
 * @param {string} code
 * @returns {Mark[]} without kinds that a newer version of this page may have
 * @throws when it is no such code
 */
export function decodeMarks(code) {
  const bytes = Uint8Array.from(atob(code.replaceAll('-', '+').replaceAll('_', '/')), (byte) => byte.charCodeAt(0));
  /** @type {Mark[]} */
  const marks = [];
  for (let at = 0; at < bytes.length; ) {
    const [kind, length] = [KINDS[bytes[at]], bytes[at + 1]];
    const own = bytes.subarray(at + 2, at + 2 + length);
    at += 2 + length;
    if (!(at <= bytes.length)) throw new Error('it is cut short');
    if (kind) marks.push(markOf(kind, own));
  }
  if (marks.length > MOST) throw new Error('it has too many marks');
  return marks;
}

/** @param {Kind} kind @param {Uint8Array} bytes @returns {Mark} */
function markOf(kind, bytes) {
  if (bytes.length < LENGTH + (kind === 'scar' ? PLACE : 0)) throw new Error('a mark is cut short');
  const { least, most, step } = SIZES[kind];
  const placeAt = (/** @type {number} */ o) => {
    const place = { triangle: 256 * bytes[o] + bytes[o + 1], b: bytes[o + 2], c: bytes[o + 3] };
    if (place.b + place.c > 255) throw new Error('a mark is beside its triangle');
    return place;
  };
  const size = Number((step * bytes[PLACE]).toFixed(1));
  const [tone, form, strength] = Array.from(bytes.subarray(PLACE + 1, LENGTH), (value) => value / 100);
  if (size < least || size > most) throw new Error('a mark has a size of no mark');
  if (Math.max(tone, form, strength) > 1) throw new Error('it has more than all of something');
  return { kind, at: placeAt(0), ...(kind === 'scar' && { to: placeAt(LENGTH) }), size, tone, form, strength };
}

/** The marks of a colouring. @param {{ readonly marks?: string }} colouring */
export const marksOf = ({ marks }) => (marks ? decodeMarks(marks) : []);

/** What was kept, if it is a code of marks, as `encodeMarks` writes it; '' otherwise. @param {unknown} kept */
export function readMarks(kept) {
  if (typeof kept !== 'string') return '';
  try {
    return encodeMarks(decodeMarks(kept));
  } catch {
    return '';
  }
}

/** Of two marks that differ in nothing else. @param {Mark} mark */
const regardless = (mark) => encodeMarks([{ ...mark, strength: 0 }]);

/**
 * The marks of a mixture of faces. Each fades as its face counts less, so that on the way from one to another none comes or goes at once; what
 * several have stays. Of too many the strongest are left.
 * @param {readonly (readonly [marks: string | undefined, amount: number])[]} parts the amounts sum to 1
 * @returns {string}
 */
export function mixedMarks(parts) {
  /** @type {Map<string, Mark>} */
  const all = new Map();
  for (const [marks, amount] of parts) {
    for (const mark of marksOf({ marks })) {
      const key = regardless(mark);
      all.set(key, { ...mark, strength: (all.get(key)?.strength ?? 0) + amount * mark.strength });
    }
  }
  const seen = [...all.values()].filter(({ strength }) => percent(strength) > 0);
  const least = seen.map(({ strength }) => strength).sort((a, b) => b - a)[MOST - 1] ?? 0;
  return encodeMarks(seen.filter(({ strength }) => strength >= least).slice(0, MOST));
}

/**
 * The vertices of the triangles that places are counted by, three each.
 * @param {import('phiz').FaceModel} model
 */
export function skinTriangles({ parts, triangles, uvVertices }) {
  const onSkin = parts.filter(({ name }) => !/eyeball/.test(name)).flatMap(({ first, count }) => [...triangles.subarray(3 * first, 3 * (first + count))]);
  return Uint32Array.from(onSkin, (corner) => uvVertices[corner]);
}

/**
 * Finds where marks are in a mirror.
 * @param {Uint32Array} triangles of the skin, three vertices each
 * @param {ArrayLike<number>} mirror the counterpart of each vertex
 * @returns {(marks: readonly Mark[]) => Mark[]}
 */
export function mirrorMarks(triangles, mirror) {
  const keyOf = (/** @type {number[]} */ vertices) => [...vertices].sort((a, b) => a - b).join();
  const cornersOf = (/** @type {number} */ t) => [...triangles.subarray(3 * t, 3 * t + 3)];
  /** @type {Map<string, number>} */
  const byCorners = new Map();
  for (let t = 0; 3 * t < triangles.length; t++) byCorners.set(keyOf(cornersOf(t)), t);
  /** @param {Place} place @returns {Place} */
  function image({ triangle, b, c }) {
    const images = cornersOf(triangle).map((v) => mirror[v]);
    const other = byCorners.get(keyOf(images));
    // One of another mesh stays where it is: nowhere.
    if (images.length < 3 || other === undefined) return { triangle, b, c };
    const weights = [255 - b - c, b, c];
    const [, second, third] = cornersOf(other).map((v) => weights[images.indexOf(v)]);
    return { triangle: other, b: second, c: third };
  }
  return (marks) => marks.map((mark) => ({ ...mark, at: image(mark.at), ...(mark.to && { to: image(mark.to) }) }));
}
