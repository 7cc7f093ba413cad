import { Matrix4, Quaternion, Vector3 } from 'three';
import { fitSphere } from './eyes.js';

// The page draws eyes of its own in place of the model's eyeballs, which an expression turns. How far
// is not in the package's interface, and need not be: it is measured, once, on the median face.

/**
 * The axes of an eyeball that two of its points give.
 * @param {Float32Array} positions @param {number[]} vertices of the ball; the first two are the points
 */
function axesOf(positions, vertices) {
  const centre = new Vector3();
  fitSphere(positions, vertices, centre);
  const [ahead, aside] = [0, 1].map((i) => new Vector3().fromArray(positions, 3 * vertices[i]).sub(centre).normalize());
  const up = ahead.clone().cross(aside).normalize();
  return new Matrix4().makeBasis(up.clone().cross(ahead), up, ahead);
}

/**
 * @param {import('phiz').FaceModel} model with its expressions
 * @returns {(expression: Record<string, number>) => Vector3[]} for the subject's right and left eye
 *   an axis times an angle
 */
export function measureTurns(model) {
  const face = model.face();
  const rest = face.positions.slice();
  const balls = ['right eyeball', 'left eyeball'].map((name) => {
    const part = model.parts.find((candidate) => candidate.name === name);
    if (!part) return [];
    const corners = model.triangles.subarray(3 * part.first, 3 * (part.first + part.count));
    const vertices = [...new Set(Array.from(corners, (corner) => model.uvVertices[corner]))];
    const most = (/** @type {number} */ k) => vertices.reduce((best, v) => (rest[3 * v + k] > rest[3 * best + k] ? v : best));
    return [most(2), most(0), ...vertices];
  });
  const before = balls.map((ball) => (ball.length ? axesOf(rest, ball).transpose() : null));
  /** @type {Map<string, Vector3[]>} */
  const turns = new Map();
  for (const name of model.expressions) {
    if (!name.startsWith('eyeLook')) continue;
    face.expression = { [name]: 1 };
    const positions = face.positions.slice();
    const all = balls.map((ball, side) => {
      const from = before[side];
      if (!from) return new Vector3();
      const { x, y, z, w } = new Quaternion().setFromRotationMatrix(axesOf(positions, ball).multiply(from));
      const axis = new Vector3(x, y, z);
      return axis.lengthSq() > 0 ? axis.setLength(2 * Math.atan2(axis.length(), w)) : axis;
    });
    turns.set(name, all);
  }
  face.free();
  return (expression) => {
    const sum = [new Vector3(), new Vector3()];
    for (const [name, weight] of Object.entries(expression)) {
      turns.get(name)?.forEach((turn, side) => sum[side].addScaledVector(turn, weight));
    }
    return sum;
  };
}
