// Where people stand on a control. A percentile says how many have less, but not how much less:
// from the 50th to the 60th a nose hardly changes, from the 95th to the 99th it does. So a slider
// is laid out by the size of the change, from -3 to +3 standard deviations, and the population's
// density stands behind it.

// Beyond the limits nobody stands, and there are no percentiles: there a value is its place.

/**
 * @typedef {{
 *   place: (value: number) => number,
 *   value: (place: number) => number,
 *   density: number[],
 *   start: number,
 *   of: (face: import('phiz').Face) => number,
 *   reach: (face: import('phiz').Face, value: number) => void,
 *   reading: (value: number) => number,
 * }} Distribution
 * A value is a percentile, or beyond the limits a place. `place` goes from 0 (the lower limit) to 1
 * (the upper), linear in the change of shape; `density` is the share of people around equally spaced
 * places, the highest 1. `start` is where the median face stands,
 * `of` where a face does, `reach` takes it to a value, also beyond the limits; `reading` is what is read there, of a
 * length mm.
 */

/** The limits are at three standard deviations either side. @param {number} place */
export const sigmas = (place) => 6 * place - 3;
/** @param {number} deviations */
export const placeOfSigmas = (deviations) => (deviations + 3) / 6;
/** How far sliders go, as values. */
export const PEOPLE = /** @type {const} */ ([0, 1]);
/** Six standard deviations either side. */
export const BEYOND = /** @type {const} */ ([-0.5, 1.5]);
/** @param {number} value */
export const isBeyond = (value) => value < PEOPLE[0] || value > PEOPLE[1];

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

/** A face that was set to a limit stands on it, give or take what a length is off by. */
const NEARLY = 0.002;

/**
 * @param {{
 *   low: number, span: number, percentiles: readonly number[], places: readonly number[], start: number,
 *   read: (face: import('phiz').Face) => number, write: (face: import('phiz').Face, reading: number) => void,
 *   rank?: (face: import('phiz').Face) => number,
 * }} known what is read at the lower limit, and how much more at the upper; where percentiles are; how a face is read
 *   and set; `rank` is its percentile where somebody knows better than the table
 * @returns {Distribution}
 */
export function distributionOf({ low, span, percentiles, places, start, read, write, rank }) {
  const place = (/** @type {number} */ value) => (isBeyond(value) ? value : interpolate(percentiles, places, value));
  const valueAt = (/** @type {number} */ at) => (isBeyond(at) ? at : interpolate(places, percentiles, at));
  const reading = (/** @type {number} */ value) => low + place(value) * span;
  return {
    place,
    value: valueAt,
    density: smoothDensity(percentiles, places),
    start,
    of(face) {
      const at = (read(face) - low) / span;
      if (at < -NEARLY || at > 1 + NEARLY) return at;
      return rank ? rank(face) : valueAt(Math.min(1, Math.max(0, at)));
    },
    reach: (face, value) => write(face, reading(value)),
    reading,
  };
}

/**
 * Reads the distributions out of the model by asking a face of its own.
 * @param {import('phiz').FaceModel} model
 * @returns {(control: import('phiz').Control) => Distribution}
 */
export function createDistributions(model) {
  const probe = model.face();
  /** @type {Map<string, Distribution>} */
  const known = new Map();

  /**
   * What a control reads, as a number that is linear in the change of shape, and how to set it to any
   * such number: a length in mm, or how far along its direction the coefficients are.
   * @param {import('phiz').Control} control
   */
  function readingOf({ name, measure }) {
    if (measure) {
      return {
        read: (/** @type {import('phiz').Face} */ face) => face.measure(measure),
        write: (/** @type {import('phiz').Face} */ face, /** @type {number} */ mm) => face.setMeasure(measure, mm),
      };
    }
    probe.set(name, 0);
    const low = probe.coefficients;
    probe.set(name, 1);
    const direction = probe.coefficients.map((value, i) => value - low[i]);
    const length = direction.reduce((sum, value) => sum + value * value, 0);
    /** @param {import('phiz').Face} face */
    const read = ({ coefficients }) => direction.reduce((sum, way, i) => sum + (coefficients[i] - low[i]) * way, 0) / length;
    return {
      read,
      write(/** @type {import('phiz').Face} */ face, /** @type {number} */ along) {
        const more = along - read(face);
        face.coefficients = face.coefficients.map((value, i) => value + more * direction[i]);
      },
    };
  }

  return (control) => {
    const found = known.get(control.name);
    if (found) return found;
    const median = probe.coefficients;
    const start = probe.get(control.name);
    const { read, write } = readingOf(control);
    /** @param {number} percentile */
    const at = (percentile) => {
      probe.set(control.name, percentile);
      return read(probe);
    };
    const low = at(0);
    const span = at(1) - low;
    const percentiles = [0, 0.01];
    for (let i = 1; i < STEPS; i++) percentiles.push(i / STEPS);
    percentiles.push(0.99, 1);
    const places = percentiles.map((percentile) => (at(percentile) - low) / span);
    probe.coefficients = median;
    const made = distributionOf({ low, span, percentiles, places, start, read, write, rank: (face) => face.get(control.name) });
    // Between two of the table the model itself knows better.
    const { reading } = made;
    made.reading = (value) => {
      if (isBeyond(value)) return reading(value);
      try {
        return at(value);
      } finally {
        probe.coefficients = median;
      }
    };
    known.set(control.name, made);
    return made;
  };
}
