import { Mesh, BufferAttribute, BufferGeometry, MeshBasicMaterial, Scene, Vector3 } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';

/** CSS px: the line, and the light one behind it that parts it from whatever it lies on. */
const WIDTH = 1.8;
const AROUND = 3.8;
const PAPER = 0xffffff;
/** The line is that much nearer than the skin it lies on, mm: where skin turns away its own depth is known no better. */
const LIFT = 1;
/** Contours shorter than this are of dents that nobody sees, mm. */
const LEAST = 8;

/**
 * The contours of a surface: where it turns away from the eye, between the corners of triangles by their normals (the smooth
 * silhouettes of Hertzmann and Zorin, "Illustrating smooth surfaces", 2000, section 5.1), so that they are no zigzag along edges.
 * @param {{ positions: ArrayLike<number>, normals: ArrayLike<number>, triangles: ArrayLike<number> }} surface mm, three a vertex
 * @param {{ x: number, y: number, z: number }} eye mm
 * @param {number} [least] length of one, mm
 * @returns {number[]} segments, six numbers each
 */
export function contours({ positions, normals, triangles }, { x, y, z }, least = LEAST) {
  const count = positions.length / 3;
  const facing = new Float32Array(count);
  for (let v = 0, o = 0; v < count; v++, o += 3) {
    facing[v] = normals[o] * (x - positions[o]) + normals[o + 1] * (y - positions[o + 1]) + normals[o + 2] * (z - positions[o + 2]);
  }
  // Where edges are crossed: each by its two ends.
  /** @type {Map<number, number>} */
  const known = new Map();
  /** @type {number[]} */
  const places = [];
  /** @type {number[]} */
  const pieces = [];
  /** @param {number} a @param {number} b */
  function crossing(a, b) {
    const edge = a < b ? a * count + b : b * count + a;
    const found = known.get(edge);
    if (found !== undefined) return found;
    const part = facing[a] / (facing[a] - facing[b]);
    for (let axis = 0; axis < 3; axis++) places.push(positions[3 * a + axis] + part * (positions[3 * b + axis] - positions[3 * a + axis]));
    known.set(edge, pieces.length);
    return pieces.push(pieces.length) - 1;
  }
  /** @param {number} i which piece it is of */
  function pieceOf(i) {
    while (pieces[i] !== i) i = pieces[i] = pieces[pieces[i]];
    return i;
  }
  /** @type {number[]} */
  const ends = [];
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [triangles[t], triangles[t + 1], triangles[t + 2]];
    const [atA, atB, atC] = [facing[a] > 0, facing[b] > 0, facing[c] > 0];
    if (atA === atB && atB === atC) continue;
    // The corner that is on a side of its own.
    const [alone, p, q] = atB === atC ? [a, b, c] : atA === atC ? [b, c, a] : [c, a, b];
    const [from, to] = [crossing(alone, p), crossing(alone, q)];
    ends.push(from, to);
    pieces[pieceOf(from)] = pieceOf(to);
  }
  const lengths = new Float64Array(pieces.length);
  for (let i = 0; i < ends.length; i += 2) {
    const [from, to] = [3 * ends[i], 3 * ends[i + 1]];
    lengths[pieceOf(ends[i])] += Math.hypot(places[from] - places[to], places[from + 1] - places[to + 1], places[from + 2] - places[to + 2]);
  }
  return ends.filter((end) => lengths[pieceOf(end)] >= least).flatMap((end) => places.slice(3 * end, 3 * end + 3));
}

/**
 * A head as a line drawing over the stage: what of it its own skin does not hide.
 * @param {import('phiz').FaceModel} model
 * @param {number} lowest what of the neck is lower is not drawn, mm
 * @param {string} ink the line's colour
 */
export function createOutline({ triangles: corners, uvVertices, vertexCount }, lowest, ink) {
  const triangles = corners.map((corner) => uvVertices[corner]);
  const position = new BufferAttribute(new Float32Array(3 * vertexCount), 3);
  const normals = new Float32Array(3 * vertexCount);
  const skin = new BufferGeometry().setAttribute('position', position);
  skin.setIndex(new BufferAttribute(triangles, 1));
  const hides = new Mesh(skin, new MeshBasicMaterial({ colorWrite: false }));
  hides.frustumCulled = false;
  const lines = [
    { color: PAPER, linewidth: AROUND },
    { color: ink, linewidth: WIDTH },
  ].map((look, order) => {
    const line = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ ...look, toneMapped: false }));
    line.frustumCulled = false;
    // The one over the other, wherever they are.
    line.renderOrder = 1 + order;
    line.material.depthWrite = false;
    return line;
  });
  const scene = new Scene().add(hides, ...lines);
  /** Where it was looked at from last; nowhere once the head is another. @type {Vector3 | null} */
  let seenFrom = null;

  /** @param {Vector3} eye */
  function look(eye) {
    if (seenFrom?.equals(eye)) return;
    seenFrom = eye.clone();
    const all = contours({ positions: position.array, normals, triangles }, eye);
    /** @type {number[]} */
    const segments = [];
    const at = new Vector3();
    for (let i = 0; i < all.length; i += 6) {
      if (Math.min(all[i + 1], all[i + 4]) < lowest) continue;
      for (const from of [i, i + 3]) {
        at.fromArray(all, from);
        segments.push(...at.lerp(eye, LIFT / at.distanceTo(eye)));
      }
    }
    for (const line of lines) {
      // It cannot be made longer than it was.
      line.geometry.dispose();
      line.geometry = new LineSegmentsGeometry();
      line.visible = segments.length > 0;
      if (line.visible) line.geometry.setPositions(segments);
    }
  }

  return {
    /** @param {Float32Array} positions mm @param {Float32Array} turned unit normals */
    set(positions, turned) {
      position.copyArray(positions);
      position.needsUpdate = true;
      normals.set(turned);
      seenFrom = null;
    },
    /** Over what was drawn. @param {import('three').WebGLRenderer} renderer @param {import('three').PerspectiveCamera} camera */
    draw(renderer, camera) {
      look(camera.position);
      const { autoClear } = renderer;
      renderer.autoClear = false;
      renderer.clearDepth();
      renderer.render(scene, camera);
      renderer.autoClear = autoClear;
    },
  };
}
