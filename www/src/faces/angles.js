// The angles of the profile that surgeons and anthropometrists go by, from soft-tissue landmarks, as they are seen from the side:
// Farkas, "Anthropometry of the head and face" (1994), and Legan and Burstone, "Soft tissue cephalometric analysis" (1980).

/** A point from the side: forwards and up, mm. @typedef {readonly [z: number, y: number]} Point */
/** What a point is of: vertices and their weights. @typedef {readonly (readonly [vertex: number, weight: number])[]} Stencil */

const NASION = 'ibug_27';
const PRONASALE = 'ibug_30';
const SUBNASALE = 'ibug_33';
const LABRALE_SUPERIUS = 'ibug_51';
const LABRALE_INFERIUS = 'ibug_57';
/** No landmark of the model's: see `columellaOf`. */
const COLUMELLA = 'columella';

/**
 * Each by name: the ends and, between them, where it is measured; or two lines, as four ends. What each is says the page's text.
 * @type {Readonly<Record<string, readonly string[]>>}
 */
const ANGLES = {
  'nasofrontal angle': ['glabella', NASION, PRONASALE],
  'nasofacial angle': ['glabella', 'pogonion', NASION, PRONASALE],
  'nasomental angle': [NASION, PRONASALE, 'pogonion'],
  'nasolabial angle': [COLUMELLA, SUBNASALE, LABRALE_SUPERIUS],
  'mentolabial angle': [LABRALE_INFERIUS, 'supramentale', 'pogonion'],
  'facial convexity': ['glabella', SUBNASALE, 'pogonion'],
};

/** A vertex is in the middle of a symmetric head when it is so near to it, mm: positions are f32 of some hundred mm. */
const MIDDLE = 1e-3;

/** @param {Stencil} stencil @param {ArrayLike<number>} positions @returns {Point} */
function placeOf(stencil, positions) {
  let [y, z] = [0, 0];
  for (const [vertex, weight] of stencil) {
    y += weight * positions[3 * vertex + 1];
    z += weight * positions[3 * vertex + 2];
  }
  return [z, y];
}

/**
 * The point of the columella by which its slope is told: in the middle of the way from subnasale to the tip of the nose, along the profile.
 * @param {ArrayLike<number>} positions of a face whose sides are alike, mm
 * @param {Point} subnasale @param {Point} tip
 * @returns {Stencil | null} null where the mesh has no line of vertices down the middle
 */
function columellaOf(positions, [back, low], [, high]) {
  /** @type {number[]} */
  const line = [];
  for (let v = 0; 3 * v < positions.length; v++) {
    const [x, y, z] = [positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]];
    if (Math.abs(x) < MIDDLE && y >= low && y <= high && z >= back) line.push(v);
  }
  line.sort((a, b) => positions[3 * a + 1] - positions[3 * b + 1]);
  if (line.length < 3) return null;
  const lengths = line.map((v, i) => (i > 0 ? Math.hypot(...[1, 2].map((axis) => positions[3 * v + axis] - positions[3 * line[i - 1] + axis])) : 0));
  const half = lengths.reduce((sum, length) => sum + length) / 2;
  let gone = 0;
  return [[line[lengths.findIndex((length) => (gone += length) >= half)], 1]];
}

/** @param {Point} from @param {Point} to @returns {Point} */
const way = (from, to) => [to[0] - from[0], to[1] - from[1]];
/** Between two directions, degrees. @param {Point} a @param {Point} b */
const between = ([az, ay], [bz, by]) => (Math.atan2(Math.abs(az * by - ay * bz), az * bz + ay * by) * 180) / Math.PI;

/**
 * Those that a model has the landmarks for.
 * @param {readonly { name: string, stencil: Stencil }[]} landmarks
 * @param {ArrayLike<number>} median the median face's positions, mm
 */
export function createAngles(landmarks, median) {
  const stencils = new Map(landmarks.map(({ name, stencil }) => [name, stencil]));
  const [subnasale, tip] = [SUBNASALE, PRONASALE].map((name) => stencils.get(name));
  const columella = subnasale && tip && columellaOf(median, placeOf(subnasale, median), placeOf(tip, median));
  if (columella) stencils.set(COLUMELLA, columella);
  const known = Object.entries(ANGLES).flatMap(([name, points]) => {
    const of = points.flatMap((point) => {
      const stencil = stencils.get(point);
      return stencil ? [stencil] : [];
    });
    return of.length === points.length ? [{ name, of }] : [];
  });
  return {
    names: known.map(({ name }) => name),
    /** @param {ArrayLike<number>} positions of a face at rest, mm @returns {number[]} degrees, 0 to 180, in the order of the names */
    of: (positions) =>
      known.map(({ of }) => {
        const [a, b, c, d] = of.map((stencil) => placeOf(stencil, positions));
        return d ? between(way(a, b), way(c, d)) : between(way(b, a), way(b, c));
      }),
  };
}
