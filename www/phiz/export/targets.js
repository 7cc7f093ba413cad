import { needFace } from './mesh.js';

/**
 * What an expression does to a face at weight 1.
 *
 * @typedef {object} ExpressionTarget
 * @property {string} name the expression's
 * @property {Float32Array} positions displacement of each vertex, mm
 * @property {Float32Array} normals change of each normal
 */

/**
 * What one control does to a face, as morph targets have it: weight 1 is one standard deviation.
 *
 * @typedef {object} MorphTarget
 * @property {string} name the control's
 * @property {string} group the feature it belongs to
 * @property {readonly (readonly [number, number])[]} direction `[coefficient, change in sigmas]`
 * @property {Float32Array} positions displacement of each vertex, mm
 * @property {Float32Array} normals change of each normal, to first order
 */

// One standard deviation of a normal distribution either side of its median, as percentiles.
const BELOW = 0.158_655_25;
const ABOVE = 1 - BELOW;

/** Coefficients are not beyond so many sigmas. */
const MOST = 255;

/**
 * The change of coefficients that a control stands for. A mode is one coefficient, and a standard
 * deviation of it is 1. Any other control is moved over the middle 68 % of the population, which
 * is two standard deviations of what it measures where that is normal.
 *
 * @param {import('phiz').Face} median a face of its own, with nothing locked
 * @param {import('phiz').Control} control
 * @returns {[number, number][]}
 */
function directionOf(median, control) {
  if (control.unit !== 'percentile') {
    throw new Error(`the control "${control.name}" is in ${control.unit}, and an export knows percentiles only`);
  }
  /** @param {number} percentile */
  const at = (percentile) => {
    median.reset();
    median.set(control.name, percentile);
    return median.coefficients;
  };
  const [low, high] = [at(BELOW), at(ABOVE)];
  /** @type {[number, number][]} */
  const direction = [];
  high.forEach((value, i) => {
    if (value !== low[i]) direction.push([i, (value - low[i]) / 2]);
  });
  if (direction.length === 1) direction[0][1] = Math.sign(direction[0][1]);
  return direction;
}

/** A share of what is between two. @param {Float32Array} a @param {Float32Array} b @param {number} share */
function difference(a, b, share) {
  const out = new Float32Array(a.length);
  for (let i = 0; i < out.length; i++) out[i] = share * (a[i] - b[i]);
  return out;
}

/** A copy of a face, without its expression. @param {import('phiz').Face} face */
export function atRest(face) {
  needFace(face);
  const rest = face.clone();
  rest.expression = {};
  return rest;
}

/**
 * A target for each expression that the model has loaded, on this face at rest.
 * @param {import('phiz').Face} face
 * @returns {ExpressionTarget[]}
 */
export function expressionTargets(face) {
  const probe = atRest(face);
  try {
    const rest = { positions: probe.positions.slice(), normals: probe.normals.slice() };
    return face.model.expressions.map((name) => {
      probe.expression = { [name]: 1 };
      /** @param {'positions' | 'normals'} key */
      const change = (key) => difference(probe[key], rest[key], 1);
      return { name, positions: change('positions'), normals: change('normals') };
    });
  } finally {
    probe.free();
  }
}

/**
 * A morph target for each control, measured on the face through the package itself. Vertices are
 * linear in the coefficients, so the face plus weighted targets is the face with its coefficients
 * moved by as much.
 *
 * @param {import('phiz').Face} face
 * @returns {MorphTarget[]}
 */
export function morphTargets(face) {
  const probe = atRest(face);
  // What is held here is not held in the file, whose sliders do what they do by themselves.
  for (const region of probe.locked) probe.unlock(region);
  for (const measure of probe.lockedMeasures) probe.unlockMeasure(measure);
  const median = face.model.face();
  try {
    const base = face.coefficients;
    return face.controls.map((control) => {
      const direction = directionOf(median, control);
      /** How much of it there is room for, where a face is at the very end of what coefficients may be. @param {number} sign */
      const room = (sign) => Math.min(1, ...direction.map(([i, change]) => (MOST - Math.sign(sign * change) * base[i]) / Math.abs(change)));
      /** @param {number} share */
      const moved = (share) => {
        const coefficients = base.slice();
        for (const [i, change] of direction) coefficients[i] = Math.min(MOST, Math.max(-MOST, coefficients[i] + share * change));
        probe.coefficients = coefficients;
        return { positions: probe.positions.slice(), normals: probe.normals.slice() };
      };
      const shares = [room(1), -room(-1)];
      const [plus, minus] = shares.map(moved);
      /** @param {'positions' | 'normals'} key */
      const half = (key) => difference(plus[key], minus[key], 1 / (shares[0] - shares[1]));
      return {
        name: control.name,
        group: control.group,
        direction,
        positions: half('positions'),
        normals: half('normals'),
      };
    });
  } finally {
    median.free();
    probe.free();
  }
}
