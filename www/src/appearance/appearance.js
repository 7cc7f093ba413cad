// How the head looks on the page, for files that other programs open: the skin's and the eyes' pictures, and lashes
// and teeth as meshes.

import { Color, Matrix3, Vector3 } from 'three';
import { expressionTargets, toGlb } from 'phiz/export';
import { weighted } from '../head.js';
import { text } from '../text.js';
import { EYE_REACH, eyeMap, skinMaps } from './maps.js';

/** What goes less far with an expression stays where it is, mm. */
const STILL = 0.15;

/** The lips' inner line from corner to corner, above and below. */
const ABOVE = ['ibug_60', 'ibug_61', 'ibug_62', 'ibug_63', 'ibug_64'];
const BELOW = ['ibug_60', 'ibug_67', 'ibug_66', 'ibug_65', 'ibug_64'];
/** How far the shadow goes on above and below them, and how far behind it lies, mm. */
const OVER = 1.2;
const UNDER = 0.5;
const BEHIND = 1.5;
/** Linear. */
const SHADOW = [0.02, 0.006, 0.005];
/** Its columns between two points of a line. */
const COLUMNS = 4;

/**
 * A face as a GLB that looks like the page.
 * @param {import('three').WebGLRenderer} renderer
 * @param {ReturnType<typeof import('../head.js').createHead>} head
 * @param {import('phiz').Face} face as it is now: it may become another while pictures are made
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 * @throws where nothing can be drawn, or kept of what was
 */
export async function glbAsShown(renderer, head, face) {
  if (renderer.getContext().isContextLost()) throw new Error(text.noCard);
  const asked = face.clone();
  try {
    const parts = beside(head, asked);
    const skin = await skinMaps(renderer, head);
    const eyes = { colour: await eyeMap(renderer, head), reach: EYE_REACH };
    return toGlb(asked, { appearance: { skin, eyes, parts } });
  } finally {
    asked.free();
  }
}

/**
 * What is drawn that the model does not have.
 * @param {ReturnType<typeof import('../head.js').createHead>} head @param {import('phiz').Face} face
 */
function beside(head, face) {
  const targets = expressionTargets(face);
  const rest = face.clone();
  rest.expression = {};
  const positions = rest.positions.slice();
  rest.free();
  const mouth = head.teeth ? [...teeth(head.teeth, positions, targets), ...lipShadow(face.model, positions, targets)] : [];
  return [...mouth, ...lashes(head, positions, targets)];
}

/**
 * The lashes, which go with the lids.
 * @param {ReturnType<typeof import('../head.js').createHead>} head
 * @param {Float32Array} rest @param {readonly import('phiz/export').ExpressionTarget[]} targets
 * @returns {import('phiz/export').Part[]}
 */
function lashes(head, rest, targets) {
  const { positions, normals, triangles, colour } = head.lashesOn(rest);
  const shade = new Color().copySRGBToLinear(colour).toArray();
  return [
    {
      name: 'lashes',
      positions,
      normals,
      colours: Float32Array.from(positions, (_, i) => shade[i % 3]),
      triangles,
      roughness: 0.6,
      targets: Object.fromEntries(
        targets.flatMap(({ name, positions: moves }) => {
          const change = head.lashesOn(rest.map((value, i) => value + moves[i])).positions.map((value, i) => value - positions[i]);
          return change.some((value) => Math.abs(value) > STILL) ? [[name, change]] : [];
        }),
      ),
    },
  ];
}

/**
 * Both rows in the face at rest, and what of them goes along with expressions.
 * @param {NonNullable<ReturnType<typeof import('../teeth.js').createTeeth>>} teeth
 * @param {Float32Array} rest @param {readonly import('phiz/export').ExpressionTarget[]} targets
 * @returns {import('phiz/export').Part[]}
 */
function teeth(teeth, rest, targets) {
  const { anchors, meshes } = teeth;
  const none = new Float32Array(3 * anchors.length);
  const places = teeth.at(rest, none);
  const moved = targets.map(({ name, positions }) => {
    const shifts = Float32Array.from(none, (_, i) => positions[3 * anchors[Math.floor(i / 3)] + (i % 3)]);
    return { name, places: teeth.at(rest.map((value, i) => value + positions[i]), shifts) };
  });
  const point = new Vector3();
  return meshes.map(({ name, geometry }, row) => {
    /** @param {string} attribute @param {(point: Vector3) => void} change */
    const each = (attribute, change) => {
      const values = geometry.getAttribute(attribute).array;
      const out = new Float32Array(values.length);
      for (let o = 0; o < out.length; o += 3) {
        change(point.fromArray(values, o));
        point.toArray(out, o);
      }
      return out;
    };
    const at = (/** @type {import('three').Matrix4[]} */ there) => each('position', (p) => p.applyMatrix4(there[row]));
    const turn = new Matrix3().getNormalMatrix(places[row]);
    const positions = at(places);
    return {
      name,
      positions,
      normals: each('normal', (n) => n.applyMatrix3(turn).normalize()),
      colours: Float32Array.from(geometry.getAttribute('color').array),
      triangles: Uint32Array.from(geometry.index?.array ?? []),
      roughness: 0.36,
      targets: Object.fromEntries(
        moved.flatMap(({ name: expression, places: there }) => {
          const change = at(there).map((value, i) => value - positions[i]);
          return change.some((value) => Math.abs(value) > STILL) ? [[expression, change]] : [];
        }),
      ),
    };
  });
}

/**
 * What lips at rest leave open is a millimetre, and dark: few programs cast the shadow of a lip on teeth. A dark ribbon
 * behind the line between them goes along with the upper one.
 * @param {import('phiz').FaceModel} model
 * @param {Float32Array} rest @param {readonly import('phiz/export').ExpressionTarget[]} targets
 * @returns {import('phiz/export').Part[]}
 */
function lipShadow(model, rest, targets) {
  if (![...ABOVE, ...BELOW].every((name) => model.landmarks.some((landmark) => landmark.name === name))) return [];
  /** @param {readonly string[]} names @returns {(values: Float32Array) => number[][]} */
  const along = (names) => {
    const stencils = names.map((name) => model.landmarks.find((landmark) => landmark.name === name)?.stencil ?? []);
    return (values) => {
      const points = stencils.map((stencil) => weighted(values, stencil, new Vector3()).toArray());
      return Array.from({ length: COLUMNS * (names.length - 1) + 1 }, (_, i) => {
        const at = Math.min(names.length - 2, Math.floor(i / COLUMNS));
        return points[at].map((from, k) => from + (i / COLUMNS - at) * (points[at + 1][k] - from));
      });
    };
  };
  const [above, below] = [along(ABOVE), along(BELOW)];
  const [top, bottom] = [above(rest), below(rest)];
  const many = top.length;
  const positions = new Float32Array(6 * many);
  top.forEach(([x, y, z], i) => {
    positions.set([x, y + OVER, z - BEHIND], 3 * i);
    positions.set([bottom[i][0], Math.min(y, bottom[i][1]) - UNDER, bottom[i][2] - BEHIND], 3 * (many + i));
  });
  return [
    {
      name: 'lip shadow',
      positions,
      normals: Float32Array.from(positions, (_, i) => (i % 3 === 2 ? 1 : 0)),
      colours: Float32Array.from(positions, (_, i) => SHADOW[i % 3]),
      triangles: Uint32Array.from({ length: many - 1 }, (_, i) => i).reduce(
        (list, i) => Uint32Array.of(...list, i, many + i, i + 1, i + 1, many + i, many + i + 1),
        new Uint32Array(0),
      ),
      roughness: 1,
      targets: Object.fromEntries(
        targets.flatMap(({ name, positions: moves }) => {
          const shift = above(moves).flat();
          const both = Float32Array.of(...shift, ...shift);
          return both.some((value) => Math.abs(value) > STILL) ? [[name, both]] : [];
        }),
      ),
    },
  ];
}
