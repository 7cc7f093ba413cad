// How the head looks on the page, for files that other programs open: the skin's and the eyes' pictures, and lashes
// and teeth as meshes.

import { Color, Matrix3, Vector3 } from 'three';
import { aroundGaze, expressionTargets, isEyeball, morphTargets, toGlb } from 'phiz/export';
import { weighted } from '../head/head.js';
import { OPEN } from '../head/teeth.js';
import { text } from '../text.js';
import { EYE_REACH, eyeColours, eyeMap, skinColours, skinMaps } from './maps.js';

/** What goes less far than this with an expression, or with a standard deviation of a slider, stays where it is, mm. */
const STILL = { expression: 0.15, slider: 0.1 };
/** The same of teeth, which nobody sees the roots of. */
const STILL_TEETH = { expression: 0.25, slider: 0.2 };
/** The same of glasses, all of which goes along. */
const STILL_GLASSES = { expression: 0, slider: 0.25 };
/** The same of hair, which is large in a file and goes with the whole head, mm. */
const STILL_HAIR = 1;
/** Strands that go less far than this stay while others go, mm. */
const STILL_STRAND = 0.3;

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
 * Makes something of the head in these colours, which it has for just that long: between two pictures it may be given others.
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head @param {import('../head/colouring.js').Colouring} colouring
 * @returns {import('./maps.js').Coloured}
 */
const colouredAs = (head, colouring) => (make) =>
  head.lend(() => {
    const { value } = head.wornStrength;
    // A face between two may be shown, which wears less of a photo.
    head.wornStrength.value = head.wears ? 1 : 0;
    if (head.colouring !== colouring) head.paint(colouring, false);
    head.finish();
    try {
      return make();
    } finally {
      head.wornStrength.value = value;
    }
  });

/**
 * The colours of a face's vertices as they are on the page: skin with what is on it, and eyes.
 * @param {import('three').WebGLRenderer} renderer
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head
 * @param {import('phiz').Face} face
 * @param {{ colouring?: import('../head/colouring.js').Colouring }} [options] the head's unless another is given
 * @returns {Uint8ClampedArray} sRGB, three a vertex
 * @throws where nothing can be drawn
 */
export function coloursAsShown(renderer, head, face, { colouring = head.colouring } = {}) {
  if (renderer.getContext().isContextLost()) throw new Error(text.noCard);
  const coloured = colouredAs(head, colouring);
  const [skin, eye] = [skinColours(renderer, head, coloured), eyeColours(renderer, head, coloured)];
  const { parts, triangles, uvVertices, vertexCount } = face.model;
  const uvs = aroundGaze(face, EYE_REACH);
  const eyes = new Set(parts.filter(isEyeball).flatMap(({ first, count }) => Array.from(triangles.subarray(3 * first, 3 * (first + count)), (corner) => uvVertices[corner])));
  const colours = new Uint8ClampedArray(3 * vertexCount);
  // The first corners are the vertices.
  for (let v = 0; v < vertexCount; v++) colours.set(around(eyes.has(v) ? eye : skin, uvs[2 * v], uvs[2 * v + 1]), 3 * v);
  return colours;
}

/**
 * The mean of nine pixels: one alone may be a pore.
 * @param {{ size: number, rgba: Uint8ClampedArray }} picture @param {number} u @param {number} v
 */
function around({ size, rgba }, u, v) {
  const [x, y] = [u, 1 - v].map((at) => Math.min(size - 2, Math.max(1, Math.floor(at * size))));
  const sum = [0, 0, 0];
  for (const row of [y - 1, y, y + 1]) {
    for (let at = 4 * (row * size + x - 1); at < 4 * (row * size + x + 2); at += 4) for (let k = 0; k < 3; k++) sum[k] += rgba[at + k] / 9;
  }
  return sum;
}

/** As long as browsers take to bring a graphics card back, and somebody waits for it, ms. */
const COMES_BACK = 3000;

/**
 * What is drawn in several goes, between which the card may be lost: once more when it is back.
 * @template T
 * @param {import('three').WebGLRenderer} renderer @param {() => Promise<T>} make @returns {Promise<T>}
 */
async function onceMore({ domElement: canvas, getContext }, make) {
  let isLost = false;
  const lose = () => (isLost = true);
  canvas.addEventListener('webglcontextlost', lose);
  try {
    return await make();
  } catch (error) {
    if (!isLost) throw error;
    if (getContext().isContextLost()) {
      await new Promise((done) => {
        canvas.addEventListener('webglcontextrestored', () => setTimeout(done), { once: true });
        setTimeout(done, COMES_BACK);
      });
    }
    if (getContext().isContextLost()) throw error;
    return await make();
  } finally {
    canvas.removeEventListener('webglcontextlost', lose);
  }
}

/**
 * A face as a GLB that looks like the page.
 * @param {import('three').WebGLRenderer} renderer
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head
 * @param {import('phiz').Face} face as it is now: it may become another while pictures are made
 * @param {{ targets?: boolean, colouring?: import('../head/colouring.js').Colouring }} [options] without targets the face is as
 *   it is now for good, and the file a tenth; it has the head's colouring unless another is given
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 * @throws where nothing can be drawn, or kept of what was
 */
export async function glbAsShown(renderer, head, face, { targets = true, colouring = head.colouring } = {}) {
  if (renderer.getContext().isContextLost()) throw new Error(text.noCard);
  const asked = face.clone();
  const coloured = colouredAs(head, colouring);
  try {
    const fetched = head.equipping(colouring);
    if (fetched) await fetched;
    // They take long, and all of it goes by them.
    const measured = targets ? { controls: morphTargets(asked), expressions: expressionTargets(asked) } : undefined;
    const parts = coloured(() => beside(head, asked, measured));
    const [skin, colour] = await onceMore(renderer, async () => /** @type {const} */ ([await skinMaps(renderer, head, coloured), await eyeMap(renderer, head, coloured)]));
    const eyes = { colour, reach: EYE_REACH };
    return toGlb(asked, { targets, measured, appearance: { skin, eyes, parts } });
  } finally {
    asked.free();
  }
}

/**
 * What is drawn that the model does not have: where it is in any face, as the page places it.
 *
 * @typedef {Omit<import('phiz/export').Part, 'positions' | 'targets'> & {
 *   on: (rest: Float32Array, expression: Float32Array | null) => Float32Array,
 *   slides?: (moves: Float32Array) => Float32Array | null,
 *   still?: typeof STILL,
 * }} Follower
 * `on` takes the face at rest and what an expression adds to it, mm. What goes along with moves of the face in a line has
 * `slides`; null is nothing
 */

/**
 * What is drawn that the model does not have, with what expressions and sliders do to it.
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head @param {import('phiz').Face} face
 * @param {{ controls: import('phiz/export').MorphTarget[], expressions: import('phiz/export').ExpressionTarget[] }} [measured] what it may
 *   become; otherwise it has the expression that it shows
 * @returns {import('phiz/export').Part[]}
 */
function beside(head, face, measured) {
  const still = face.clone();
  still.expression = {};
  const rest = still.positions.slice();
  still.free();
  const followers = [
    ...(head.teeth ? [...teeth(head.teeth, rest), ...lipShadow(face.model)] : []),
    lashes(head, rest),
    ...head.tresses.flatMap((tresses) => hair(tresses, rest)),
    ...glasses(head, rest),
  ];
  if (!measured) {
    const shown = Object.keys(face.expression).length > 0 ? face.positions.map((value, i) => value - rest[i]) : null;
    return followers.map(({ on, slides, still: _, ...part }) => {
      const positions = on(rest, slides ? null : shown);
      const slid = shown && slides?.(shown);
      return { ...part, positions: slid ? positions.map((value, i) => value + slid[i]) : positions, targets: {} };
    });
  }
  const { controls: sliders, expressions } = measured;
  const parts = followers.map(({ on, slides, still = STILL, ...part }) => {
    /** @type {Record<string, Float32Array>} */
    const targets = {};
    return { on, slides, still, part: { ...part, positions: on(rest, null), targets } };
  });
  for (const { slides, part } of parts) {
    for (const { name, positions: moves } of slides ? [...sliders, ...expressions] : []) {
      const change = slides?.(moves);
      if (change) part.targets[name] = change;
    }
  }
  const placed = parts.filter(({ slides }) => !slides);
  /** @param {Float32Array} to @param {Float32Array} from @param {number} share @param {number} least */
  const between = (to, from, share, least) => {
    const change = new Float32Array(to.length);
    let most = 0;
    for (let i = 0; i < change.length; i++) {
      change[i] = share * (to[i] - from[i]);
      most = Math.max(most, Math.abs(change[i]));
    }
    return most > least ? change : null;
  };
  // Where things are is not linear in the face; half of both ways is the slope.
  for (const { name, positions: moves } of sliders) {
    const [there, back] = [1, -1].map((way) => together(rest, moves, way));
    for (const { on, still, part } of placed) {
      const change = between(on(there, null), on(back, null), 0.5, still.slider);
      if (change) part.targets[name] = change;
    }
  }
  for (const { name, positions: moves } of expressions) {
    for (const { on, still, part } of placed) {
      const change = between(on(rest, moves), part.positions, 1, still.expression);
      if (change) part.targets[name] = change;
    }
  }
  return parts.map(({ part }) => part);
}

/** @param {Float32Array} rest @param {Float32Array | null} moves @param {number} [share] of them */
function together(rest, moves, share = 1) {
  if (!moves) return rest;
  const out = new Float32Array(rest.length);
  for (let i = 0; i < out.length; i++) out[i] = rest[i] + share * moves[i];
  return out;
}

/**
 * The lashes, which go with the lids.
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head @param {Float32Array} rest
 * @returns {Follower}
 */
function lashes(head, rest) {
  const { normals, triangles, colour } = head.lashesOn(rest);
  const shade = new Color().copySRGBToLinear(colour).toArray();
  return {
    name: 'lashes',
    normals,
    colours: Float32Array.from(normals, (_, i) => shade[i % 3]),
    triangles,
    roughness: 0.6,
    on: (face, expression) => head.lashesAt(together(face, expression)),
  };
}

/** Whether a strand whose move this is stays. @param {Float32Array} moves @param {number} o where the move begins */
const isStill = (moves, o) => moves[o] ** 2 + moves[o + 1] ** 2 + moves[o + 2] ** 2 < STILL_STRAND ** 2;

/**
 * Hair that is longer than a crop, which goes as its roots do.
 * @param {ReturnType<typeof import('../head/head.js').createHead>['tresses'][number]} tresses @param {Float32Array} rest
 * @returns {Follower[]}
 */
function hair(tresses, rest) {
  const body = tresses.bodies(rest);
  if (!body) return [];
  const { positions, ...look } = body;
  return [
    {
      name: tresses.name,
      ...look,
      roughness: 0.45,
      on: () => positions,
      slides(moves) {
        // To ask costs more than to see that nothing of the head goes so far.
        if (moves.every((value) => Math.abs(value) <= STILL_HAIR)) return null;
        const carried = tresses.carried(moves, STILL_HAIR);
        return carried && carried.map((value, i) => (isStill(carried, i - (i % 3)) ? 0 : value));
      },
    },
  ];
}

/**
 * Glasses, which stay where they are on nose and ears whatever the face does with its mouth.
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head @param {Float32Array} rest
 * @returns {Follower[]}
 */
function glasses(head, rest) {
  const first = head.glassesOn(rest);
  if (!first) return [];
  // All their parts are placed at once.
  let last = { face: rest, placed: first };
  const on = (/** @type {Float32Array} */ face) => {
    if (last.face !== face) last = { face, placed: head.glassesOn(face) ?? first };
    return last.placed;
  };
  return head.glasses.map(({ kind, ...look }) => ({
    ...look,
    normals: first[kind].normals,
    still: STILL_GLASSES,
    on: (face) => on(face)[kind].positions,
  }));
}

/**
 * Both rows: the upper one stands still in an expression, the lower one goes with the jaw.
 * @param {NonNullable<ReturnType<typeof import('../head/teeth.js').createTeeth>>} teeth @param {Float32Array} rest
 * @returns {Follower[]}
 */
function teeth(teeth, rest) {
  const { anchors, meshes } = teeth;
  const none = new Float32Array(3 * anchors.length);
  /** @param {Float32Array} face @param {Float32Array | null} expression */
  const places = (face, expression) => {
    const shifts = expression ? none.map((_, i) => expression[3 * anchors[Math.floor(i / 3)] + (i % 3)]) : none;
    return teeth.at(together(face, expression), shifts);
  };
  const upright = places(rest, null);
  const point = new Vector3();
  return meshes.map(({ name, geometry }, row) => {
    const turn = new Matrix3().getNormalMatrix(upright[row]);
    const normals = Float32Array.from(geometry.getAttribute('normal').array);
    for (let o = 0; o < normals.length; o += 3) {
      point.fromArray(normals, o).applyMatrix3(turn).normalize().toArray(normals, o);
    }
    const corners = geometry.getAttribute('position').array;
    return {
      name,
      normals,
      colours: Float32Array.from(geometry.getAttribute('color').array),
      triangles: Uint32Array.from(geometry.index?.array ?? []),
      roughness: 0.36,
      still: STILL_TEETH,
      on(face, expression) {
        const [xx, xy, xz, , yx, yy, yz, , zx, zy, zz, , ox, oy, oz] = places(face, expression)[row].elements;
        const out = new Float32Array(corners.length);
        // For every slider and expression: numbers, not vectors.
        for (let o = 0; o < out.length; o += 3) {
          const [x, y, z] = [corners[o], corners[o + 1], corners[o + 2]];
          out[o] = xx * x + yx * y + zx * z + ox;
          out[o + 1] = xy * x + yy * y + zy * z + oy;
          out[o + 2] = xz * x + yz * y + zz * z + oz;
        }
        return out;
      },
    };
  });
}

/**
 * What lips at rest leave open is a millimetre, and dark: few programs cast the shadow of a lip on teeth. A dark ribbon
 * behind the line between them goes along with the upper one.
 * @param {import('phiz').FaceModel} model
 * @returns {Follower[]}
 */
function lipShadow(model) {
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
  const parted = (/** @type {number} */ gap) => Math.min(1, Math.max(0, (gap - OPEN[0]) / (OPEN[1] - OPEN[0])));
  const many = COLUMNS * (ABOVE.length - 1) + 1;
  return [
    {
      name: 'lip shadow',
      normals: Float32Array.from({ length: 6 * many }, (_, i) => (i % 3 === 2 ? 1 : 0)),
      colours: Float32Array.from({ length: 6 * many }, (_, i) => SHADOW[i % 3]),
      triangles: Uint32Array.from(
        Array.from({ length: many - 1 }, (_, i) => [i, many + i, i + 1, i + 1, many + i, many + i + 1]).flat(),
      ),
      roughness: 1,
      on(face, expression) {
        const bottom = below(face);
        const [rise, fall] = expression ? [above(expression), below(expression)] : [null, null];
        const rows = above(face).map(([x, y, z], i) => {
          const low = [bottom[i][0], Math.min(y, bottom[i][1]) - UNDER, bottom[i][2] - BEHIND];
          const column = [[x, y + OVER, z - BEHIND], low];
          if (!rise || !fall) return column;
          // Where lips part more than at rest it draws back behind the upper one: an open mouth has no curtain.
          const gap = [x, y, z].map((value, k) => value - bottom[i][k]);
          const before = parted(Math.hypot(...gap));
          const after = parted(Math.hypot(...gap.map((value, k) => value + rise[i][k] - fall[i][k])));
          if (after > before) low[1] += ((after - before) / (1 - before)) * (y + OVER - low[1]);
          return column.map((point) => point.map((value, k) => value + rise[i][k]));
        });
        return Float32Array.from([0, 1].flatMap((row) => rows.flatMap((column) => column[row])));
      },
    },
  ];
}
