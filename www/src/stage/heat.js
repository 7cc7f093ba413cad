// How far two faces are apart, as colours.

/** Viridis at equal steps (Smith, van der Walt 2015): even to the eye, and safe for the colour blind. */
const STOPS = [
  [68, 1, 84],
  [71, 44, 122],
  [59, 81, 139],
  [44, 113, 142],
  [33, 144, 141],
  [39, 173, 129],
  [92, 200, 99],
  [170, 220, 50],
  [253, 231, 37],
].map((colour) => colour.map((byte) => byte / 255));

/** Where the scale may end, mm. */
const ENDS = [0.5, 1, 2, 3, 4, 6, 8, 10, 15, 20, 30];

/** The scale as a CSS gradient, from no distance up to the end. */
export const gradient = `linear-gradient(to top, ${STOPS.map(
  (colour) => `rgb(${colour.map((c) => Math.round(255 * c)).join(' ')})`,
).join(', ')})`;

/**
 * @param {Float32Array} positions @param {Float32Array} reference both mm, three a vertex
 * @returns {Float32Array} the distance of each vertex, mm
 */
export function distances(positions, reference) {
  const away = new Float32Array(positions.length / 3);
  // With every event of a drag: Math.hypot takes many times as long.
  for (let i = 0; i < away.length; i++) {
    const o = 3 * i;
    const x = positions[o] - reference[o];
    const y = positions[o + 1] - reference[o + 1];
    const z = positions[o + 2] - reference[o + 2];
    away[i] = Math.sqrt(x * x + y * y + z * z);
  }
  return away;
}

/**
 * The first end that all but one in a hundred stay under.
 * @param {Float32Array} away mm
 */
export function scaleEnd(away) {
  const under = Math.floor(0.99 * (away.length - 1)) + 1;
  const counts = new Uint32Array(ENDS.length);
  for (let i = 0; i < away.length; i++) {
    let at = 0;
    while (at < ENDS.length && away[i] > ENDS[at]) at++;
    if (at < ENDS.length) counts[at]++;
  }
  let sum = 0;
  return ENDS.find((_, at) => (sum += counts[at]) >= under) ?? ENDS[ENDS.length - 1];
}

/**
 * @param {Float32Array} away mm @param {number} end of the scale, mm
 * @param {Float32Array} out sRGB in 0 to 1, three a vertex
 */
export function heatColours(away, end, out) {
  for (let i = 0; i < away.length; i++) {
    const at = Math.min(1, away[i] / end) * (STOPS.length - 1);
    const low = Math.min(STOPS.length - 2, Math.floor(at));
    const [from, to] = [STOPS[low], STOPS[low + 1]];
    for (let k = 0; k < 3; k++) out[3 * i + k] = from[k] + (at - low) * (to[k] - from[k]);
  }
}
