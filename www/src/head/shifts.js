/**
 * What expressions add to some vertices. Expressions are carried by each face in its own proportions; what
 * is measured here, once, on the median face, is near enough for what the page draws beside the model.
 * @param {import('phiz').FaceModel} model with its expressions
 * @param {number[]} vertices
 * @returns {(expression: Record<string, number>) => Float32Array} 3 a vertex, mm
 */
export function measureShifts(model, vertices) {
  const face = model.face();
  const at = () => {
    const { positions } = face;
    return Float32Array.from({ length: 3 * vertices.length }, (_, i) => positions[3 * vertices[Math.floor(i / 3)] + (i % 3)]);
  };
  const rest = at();
  /** @type {Map<string, Float32Array>} */
  const shifts = new Map();
  for (const name of model.expressions) {
    face.expression = { [name]: 1 };
    const shift = at().map((value, i) => value - rest[i]);
    if (shift.some((value) => value !== 0)) shifts.set(name, shift);
  }
  face.free();
  return (expression) => {
    const sum = new Float32Array(3 * vertices.length);
    for (const [name, weight] of Object.entries(expression)) {
      const shift = shifts.get(name);
      if (shift) for (let i = 0; i < sum.length; i++) sum[i] += weight * shift[i];
    }
    return sum;
  };
}
