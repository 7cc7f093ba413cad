import { distributionOf } from './distribution.js';

// Lengths that the model has no control for, such as the face's height. A sample of random faces tells how people
// differ in them, and any of them can be set by the most probable change of the face.

/**
 * So many tell a mean to a twentieth of a standard deviation and that to 3.5 %: in the middle two percentiles. Of
 * 4000 faces no such length is skewed by more than 0.1, so a normal distribution stands for all.
 */
const FACES = 400;
/**
 * What those of the whole face leave as it is: in people all of them go with the size of the face, and a long face would be a broad one.
 * A narrow face has a narrow jaw all the same.
 */
const KEPT = ['face height', 'face width'];
const KEPT_BY_HEIGHT = ['face width', 'jaw width', 'tragion width'];
/**
 * And those of a feature: what would go with them most. People with thin lips have more between their ears; the face that leaves that as
 * it is is hardly less probable, by 3.9 standard deviations in place of 3.3 for lips of the fifth percentile. Each costs a drag a sixth of
 * a millisecond.
 * @type {Readonly<Record<string, readonly string[]>>}
 */
const KEPT_BESIDE = {
  'forehead height': ['face height', 'tragion width', 'forehead width', 'mouth vertical position'],
  'brow distance': ['face width', 'tragion width', 'forehead width', 'inner eye distance'],
  'left eye height': ['face height', 'face width', 'tragion width', 'jaw width', 'eyes length'],
  'right eye height': ['face height', 'face width', 'tragion width', 'jaw width', 'eyes length'],
  'lip height': ['face height', 'tragion width', 'jaw width', 'nose length', 'mouth vertical position'],
  'upper lip height': ['face height', 'tragion width', 'nose width', 'mouth width', 'mouth protrusion'],
  'chin height': ['face width', 'tragion width', 'inner eye distance', 'mouth vertical position'],
};

/** What a length leaves as it is. @param {string} measure */
const keptBy = (measure) => KEPT_BESIDE[measure] ?? (measure === 'face height' ? KEPT_BY_HEIGHT : KEPT);

/** Limits, in standard deviations, and how many steps the table has between them. */
const REACH = 3;
const STEPS = 60;

const PLACES = Array.from({ length: STEPS + 1 }, (_, i) => i / STEPS);
/** The percentiles there, if all people are within the limits. */
const PERCENTILES = (() => {
  const sums = [0];
  const density = (/** @type {number} */ at) => Math.exp(-0.5 * (REACH * (2 * at - 1)) ** 2);
  for (let i = 1; i <= STEPS; i++) sums.push(sums[i - 1] + density(PLACES[i - 1]) + density(PLACES[i]));
  return sums.map((sum) => sum / sums[STEPS]);
})();

/**
 * Gives a face a length by the most probable change that leaves what it should, and what is held.
 * @param {import('phiz').Face} face @param {string} measure @param {number} mm
 */
function setLength(face, measure, mm) {
  try {
    setKeeping(keptBy(measure), face, measure, mm);
  } catch (error) {
    if (!KEPT_BESIDE[measure]) throw error;
    // Some faces, one in hundreds, do not have it with all of that.
    setKeeping(KEPT, face, measure, mm);
  }
}

/** @param {readonly string[]} names what stays @param {import('phiz').Face} face @param {string} measure @param {number} mm */
function setKeeping(names, face, measure, mm) {
  const known = face.model.measures.map(({ name }) => name);
  const kept = names.filter((name) => name !== measure && known.includes(name) && !face.lockedMeasures.includes(name));
  for (const name of kept) face.lockMeasure(name);
  try {
    face.setMeasure(measure, mm);
  } finally {
    for (const name of kept) face.unlockMeasure(name);
  }
}

/**
 * The lengths that no control sets.
 * @param {import('phiz').FaceModel} model
 */
export function createLengths(model) {
  const measures = model.measures.filter(({ name }) => !model.controls.some(({ measure }) => measure === name));
  /** A face takes half a millisecond. @param {() => Promise<void>} pause */
  async function sample(pause) {
    const face = model.face();
    const median = measures.map(({ name }) => face.measure(name));
    const sums = measures.map(() => [0, 0]);
    for (let seed = 1; seed <= FACES; seed++) {
      await pause();
      // Also of what a random face keeps: the blending distance.
      face.reset();
      face.randomize({ seed });
      measures.forEach(({ name }, i) => {
        const away = face.measure(name) - median[i];
        sums[i][0] += away;
        sums[i][1] += away * away;
      });
    }
    face.free();
    return new Map(
      measures.map(({ name }, i) => {
        const mean = sums[i][0] / FACES;
        const deviation = Math.sqrt(sums[i][1] / FACES - mean * mean);
        const low = median[i] + mean - REACH * deviation;
        const span = 2 * REACH * deviation;
        const distribution = distributionOf({
          low,
          span,
          percentiles: PERCENTILES,
          places: PLACES,
          start: 0,
          read: (face) => face.measure(name),
          write: (face, mm) => setLength(face, name, mm),
        });
        return [name, { ...distribution, start: distribution.value((median[i] - low) / span) }];
      }),
    );
  }

  return {
    measures,
    /** How people differ in them. */
    distributions: sample,
    set: setLength,
  };
}
