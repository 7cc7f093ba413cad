// Where people stand on a control. A percentile says how many have less, but not how much less:
// from the 50th to the 60th a nose hardly changes, from the 95th to the 99th it does. So a slider
// is laid out by the size of the change, from -3 to +3 standard deviations, and the population's
// density stands behind it.

/**
 * @typedef {{
 *   place: (percentile: number) => number,
 *   percentile: (place: number) => number,
 *   density: number[],
 * }} Distribution
 * `place` goes from 0 (the lower limit) to 1 (the upper), linear in the change of shape; `density`
 * is the share of people around equally spaced places, the highest 1.
 */

const STEPS = 50;
const BARS = 61;
/** The width of the density's smoothing: 0.3 of the six standard deviations' 6. */
const BANDWIDTH = 0.05;

/**
 * @param {readonly number[]} from increasing @param {readonly number[]} to @param {number} value
 */
function interpolate(from, to, value) {
  let high = from.findIndex((entry) => entry >= value);
  if (high < 0) high = from.length - 1;
  if (high === 0) return to[0];
  const span = from[high] - from[high - 1];
  const t = span > 0 ? Math.min(1, (value - from[high - 1]) / span) : 1;
  return to[high - 1] + t * (to[high] - to[high - 1]);
}

/** @param {readonly number[]} percentiles @param {readonly number[]} places */
function smoothDensity(percentiles, places) {
  const density = Array.from({ length: BARS }, (_, bar) => {
    const at = bar / (BARS - 1);
    let sum = 0;
    for (let i = 1; i < places.length; i++) {
      const mass = percentiles[i] - percentiles[i - 1];
      // The tails' steps are long: spread their people over them.
      for (const t of [1 / 6, 1 / 2, 5 / 6]) {
        const away = (places[i - 1] + t * (places[i] - places[i - 1]) - at) / BANDWIDTH;
        sum += (mass / 3) * Math.exp(-0.5 * away * away);
      }
    }
    return sum;
  });
  const highest = Math.max(...density);
  return density.map((value) => value / highest);
}

/**
 * Reads the distributions out of the model by asking a face of its own.
 * @param {import('phiz').FaceModel} model
 * @returns {(control: string) => Distribution}
 */
export function createDistributions(model) {
  const probe = model.face();
  /** @type {Map<string, Distribution>} */
  const known = new Map();
  return (control) => {
    const found = known.get(control);
    if (found) return found;
    const median = probe.coefficients;
    /** @param {number} percentile */
    const at = (percentile) => {
      probe.set(control, percentile);
      return probe.coefficients;
    };
    const low = at(0);
    const direction = at(1).map((value, i) => value - low[i]);
    const length = direction.reduce((sum, value) => sum + value * value, 0);
    const percentiles = [0, 0.01];
    for (let i = 1; i < STEPS; i++) percentiles.push(i / STEPS);
    percentiles.push(0.99, 1);
    const places = percentiles.map((percentile) => {
      const coefficients = at(percentile);
      let along = 0;
      for (let i = 0; i < direction.length; i++) along += (coefficients[i] - low[i]) * direction[i];
      return along / length;
    });
    probe.coefficients = median;
    const made = {
      place: (/** @type {number} */ percentile) => interpolate(percentiles, places, percentile),
      percentile: (/** @type {number} */ place) => interpolate(places, percentiles, place),
      density: smoothDensity(percentiles, places),
    };
    known.set(control, made);
    return made;
  };
}
