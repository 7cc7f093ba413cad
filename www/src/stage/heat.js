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
const SHADES = Float64Array.from(STOPS.flat());

/** Where the scale may end, mm: after so many steps of a half. */
const ENDS = [0.5, 1, 2, 3, 4, 6, 8, 10, 15, 20, 30];
const STEP = 0.5;

/** The scale as a CSS gradient, from no distance up to the end. */
export const gradient = `linear-gradient(to top, ${STOPS.map(
  (colour) => `rgb(${colour.map((c) => Math.round(255 * c)).join(' ')})`,
).join(', ')})`;

// All of it is done with every event of a drag.

/**
 * @param {Float32Array} positions @param {Float32Array} reference both mm, three a vertex
 * @param {Float32Array} [away] is set
 * @returns {Float32Array} the distance of each vertex, mm
 */
export function distances(positions, reference, away = new Float32Array(positions.length / 3)) {
  // Math.hypot takes five times as long.
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
  const most = ENDS[ENDS.length - 1];
  const beyond = most / STEP + 1;
  const counts = new Uint32Array(beyond + 1);
  for (let i = 0; i < away.length; i++) counts[Math.min(beyond, Math.ceil(away[i] / STEP))]++;
  let left = Math.floor(0.99 * (away.length - 1)) + 1;
  let steps = 0;
  while ((left -= counts[steps]) > 0) steps++;
  return ENDS.find((end) => steps * STEP <= end) ?? most;
}

/**
 * @param {Float32Array} away mm @param {number} end of the scale, mm
 * @param {Float32Array} out sRGB in 0 to 1, three a vertex
 */
export function heatColours(away, end, out) {
  for (let i = 0; i < away.length; i++) {
    const at = Math.min(1, away[i] / end) * (STOPS.length - 1);
    const low = Math.min(STOPS.length - 2, Math.floor(at));
    const part = at - low;
    const from = 3 * low;
    const o = 3 * i;
    out[o] = SHADES[from] + part * (SHADES[from + 3] - SHADES[from]);
    out[o + 1] = SHADES[from + 1] + part * (SHADES[from + 4] - SHADES[from + 1]);
    out[o + 2] = SHADES[from + 2] + part * (SHADES[from + 5] - SHADES[from + 2]);
  }
}
