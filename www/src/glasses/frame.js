import { along, AROUND, empty, plus, rounded, sweep, unit } from './sweep.js';
import { outline, radii } from './outline.js';
import { mix, smooth } from './style.js';

// The front of a pair of glasses, in its own axes: x to the subject's left from the middle of the bridge, y up from the middle of the
// lenses, z ahead from the middle of a lens that is as thin as a sheet; mm.

/** Lenses are parts of spheres of so many mm (a base curve of 4 dioptres), and each is turned back to its temple. */
const CURVE = 135;
const WRAP = (4.5 * Math.PI) / 180;
/** Half of how thick a lens is at its edge, mm. */
const HALF_LENS = 0.9;
/** Between two lenses, when a frame is made: the face may want more or less. */
const BETWEEN = 18;
/** Points of a rim, and how many numbers tell how far a lens goes. */
const RIM = 84;
export const ANGLES = 96;
const LENS_RINGS = 4;
/** How far a rim holds a lens, mm. */
export const GROOVE = 0.45;

/** Of what a part is made: what the rim is of, the metal of what is small, the plastic of what touches the skin. */
export const KINDS = /** @type {const} */ (['main', 'metal', 'plastic']);
/** @typedef {typeof KINDS[number]} Kind */

/** A body of the front: for each corner how far along with the left lens it goes when that goes aside, -1 to 1. @typedef {import('./sweep.js').Body & { shift: number[] }} FrontBody */

/**
 * @typedef {object} Front
 * @property {Record<Kind, FrontBody>} parts
 * @property {FrontBody & { edge: number[] }} lenses `edge` is 1 at their edges and 0 elsewhere
 * @property {number} centre how far aside the middle of the left lens is
 * @property {Float32Array} reach how far rim and lens go from there, by the angle
 * @property {(x: number, y: number) => number} back how far back the front goes at a point from there
 * @property {(x: number, y: number) => number} lensBack the same of the lens
 * @property {{ x: number, y: number, z: number }[]} noseSide the points of the left rim that come near the nose, from there
 * @property {{ y: number, half: number, arch: number, bulge: number, reach: number, back: number }} bridge half of how tall it is, how far it rises
 *   and bulges ahead in its middle, how far aside it goes, and how far back at its ends
 * @property {import('./sweep.js').Point} hinge where the left arm begins
 * @property {{ x: number, y: number, z: number }} nasal where the left pad does
 */

/** How far ahead the sheet of a lens is. @param {number} x from the lens's middle @param {number} y @param {Pick<import('./style.js').Style, 'width'>} style */
export const sheet = (x, y, { width }) => -(x * x + y * y) / (2 * CURVE) - Math.tan(WRAP) * (x + width / 2);

/** The way out of the sheet. @param {number} x @param {number} y @returns {import('./sweep.js').Point} */
const facing = (x, y) => unit([x / CURVE + Math.tan(WRAP), y / CURVE, 1]);

/** How broad the rim is around a lens. @param {number} u @param {number} v of the half box @param {import('./style.js').Style} style */
function breadth(u, v, { rim, half, plastic, form }) {
  // Acetate is broader above and at the temple.
  const shaped = 1 + plastic * (0.16 * v + 0.12 * u * (v > 0 ? 1 : 0.5) - 0.25 * Math.max(0, -u) * (v < 0.3 ? 1 : 0.4) + 0.05 * form);
  const left = 1 - half * smooth(0.3, 0.02, v);
  return Math.max(0.05, rim * shaped * left);
}

/** The mirror image of a body, beside it. @param {FrontBody} body */
function mirror(body) {
  const { positions, normals, triangles, shift } = body;
  const many = positions.length / 3;
  for (let i = 0; i < many; i++) {
    positions.push(-positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
    normals.push(-normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]);
    shift.push(-shift[i]);
  }
  for (let t = 0, end = triangles.length; t < end; t += 3) triangles.push(many + triangles[t], many + triangles[t + 2], many + triangles[t + 1]);
}

/** @param {FrontBody} body @param {FrontBody} other goes to its end */
function append(body, other) {
  const first = body.shift.length;
  body.positions.push(...other.positions);
  body.normals.push(...other.normals);
  body.shift.push(...other.shift);
  body.triangles.push(...other.triangles.map((corner) => first + corner));
}

/**
 * A lens as a solid: front, edge and back.
 * @param {import('./style.js').Style} style @param {ReturnType<typeof outline>} around @param {number} centre
 */
function lens(style, around, centre) {
  const body = { ...empty(), shift: /** @type {number[]} */ ([]), edge: /** @type {number[]} */ ([]) };
  const many = around.length;
  /** @param {number} x @param {number} y @param {number} side @param {import('./sweep.js').Point} normal @param {number} edge */
  const corner = (x, y, side, normal, edge) => {
    const out = facing(x, y);
    const at = plus([centre + x, y, sheet(x, y, style)], out, side * HALF_LENS);
    body.positions.push(...at);
    body.normals.push(...normal);
    body.shift.push(1);
    body.edge.push(edge);
  };
  for (const side of [1, -1]) {
    const first = body.positions.length / 3;
    const normal = (/** @type {number} */ x, /** @type {number} */ y) => /** @type {import('./sweep.js').Point} */ (facing(x, y).map((value) => side * value));
    corner(0, 0, side, normal(0, 0), 0);
    for (let ring = 1; ring <= LENS_RINGS; ring++) {
      for (const { x, y } of around) corner((x * ring) / LENS_RINGS, (y * ring) / LENS_RINGS, side, normal((x * ring) / LENS_RINGS, (y * ring) / LENS_RINGS), 0);
    }
    for (let ring = 0; ring < LENS_RINGS; ring++) {
      for (let i = 0; i < many; i++) {
        const j = (i + 1) % many;
        const [a, b] = ring ? [first + 1 + (ring - 1) * many + i, first + 1 + (ring - 1) * many + j] : [first, first];
        const [c, d] = [first + 1 + ring * many + i, first + 1 + ring * many + j];
        const quad = ring ? [a, c, d, a, d, b] : [a, c, d];
        for (let t = 0; t < quad.length; t += 3) body.triangles.push(...(side > 0 ? [quad[t], quad[t + 1], quad[t + 2]] : [quad[t], quad[t + 2], quad[t + 1]]));
      }
    }
  }
  const first = body.positions.length / 3;
  for (const side of [1, -1]) for (const { x, y, nx, ny } of around) corner(x, y, side, [nx, ny, 0], 1);
  for (let i = 0; i < many; i++) {
    const j = (i + 1) % many;
    body.triangles.push(first + i, first + many + i, first + j, first + j, first + many + i, first + many + j);
  }
  mirror(body);
  body.edge.push(...body.edge);
  return body;
}

/**
 * @param {import('./style.js').Style} style @returns {Front}
 */
export function frontOf(style) {
  const { width, height, plastic, deep, isRimless, rim, bar } = style;
  const square = plastic > 0.5;
  const around = outline(style, RIM);
  const centre = BETWEEN / 2 + width / 2;
  /** @type {Front['parts']} */
  const parts = { main: { ...empty(), shift: [] }, metal: { ...empty(), shift: [] }, plastic: { ...empty(), shift: [] } };
  /** What lies between both lenses. */
  const between = { ...empty(), shift: /** @type {number[]} */ ([]) };
  /** Adds a body that goes along with the left lens. @param {Kind} kind @param {readonly import('./sweep.js').Station[]} way @param {boolean} [closed] */
  const beside = (kind, way, closed) => {
    const part = parts[kind];
    sweep(part, way, closed);
    while (part.shift.length < part.positions.length / 3) part.shift.push(1);
  };
  const widths = around.map(({ x, y }) => breadth((2 * x) / width, (2 * y) / height, style));
  const isThin = widths.map((wide) => plastic > 0.5 && wide < 0.45 * rim);

  // The rim: it holds the lens a little, and lies behind it more than before it.
  const stations = around.map(({ x, y, nx, ny }, i) => {
    const out = facing(x, y);
    const wide = widths[i] / 2;
    const ahead = isThin[i] || wide < 0.2 ? Math.min(0.8, deep / 2) : deep / 2;
    const u = unit(plus([nx, ny, 0], out, -(nx * out[0] + ny * out[1])));
    const middle = plus([centre + x, y, sheet(x, y, style)], u, wide - GROOVE);
    return { at: plus(middle, out, -0.12 * deep), u, v: out, a: wide, b: ahead, square };
  });
  // The way goes counter-clockwise, seen from before: u is out of it, and v ahead, so it is drawn back to front.
  const turned = stations.map((one) => ({ ...one, u: one.v, v: one.u, a: one.b, b: one.a }));
  if (!isRimless) {
    if (isThin.some(Boolean)) {
      // What holds a lens below a brow line is a wire: two bodies that go into each other.
      const upper = turned.filter((_, i) => !isThin[i]);
      const from = isThin.findIndex((thin, i) => !thin && isThin[(i + RIM - 1) % RIM]);
      const ordered = Array.from({ length: upper.length }, (_, n) => turned[(from + n) % RIM]);
      beside('main', rounded(ordered, [1.2, 1.2]));
      const wire = stations.map((one, i) => {
        const half = Math.min(one.a, 0.6);
        const { x, y, nx, ny } = around[i];
        const out = facing(x, y);
        const u = unit(plus([nx, ny, 0], out, -(nx * out[0] + ny * out[1])));
        return { at: plus(plus([centre + x, y, sheet(x, y, style)], u, half - GROOVE), out, -0.1), u: out, v: u, a: 0.85, b: half };
      });
      beside('metal', wire, true);
    } else beside('main', turned, true);
  }

  // Where the bridge and the arm meet the rim.
  const meets = (/** @type {number} */ y, /** @type {number} */ side) => {
    const [found] = around.map((one, i) => ({ ...one, i })).filter(({ x }) => x * side > 0).sort((a, b) => Math.abs(a.y - y) - Math.abs(b.y - y));
    return { x: found.x, y: found.y, wide: widths[found.i] };
  };
  const bridgeHeight = height * mix(0.16, 0.2, plastic) + Math.max(0, -style.sweep) * 0.06 * height;
  const inner = meets(bridgeHeight, -1);
  const edge = centre + inner.x - inner.wide + GROOVE;
  const half = mix(0.75, 1.3 + 0.42 * rim, plastic);
  const [arch, bulge] = [mix(2.2, 1.6, plastic), mix(2, 2.2, plastic)];
  /** @param {number} y at its ends @param {number} rise @param {number} half @param {number} deepness @param {number} from the middle @param {number} at where it ends ahead @param {number} out how far it bulges ahead */
  const across = (y, rise, half, deepness, from, at, out) => {
    const steps = 20;
    const points = Array.from({ length: steps + 1 }, (_, i) => {
      const t = (2 * i) / steps - 1;
      return /** @type {import('./sweep.js').Point} */ ([t * from, y + rise * (1 - t * t), at + out * (1 - t * t)]);
    });
    const flare = (/** @type {number} */ i) => 1 + plastic * 1.1 * Math.abs((2 * i) / steps - 1) ** 2.2;
    sweep(between, along(points, [0, 1, 0], (i) => [deepness / 2, half * flare(i)], square));
    for (const [x] of points) for (let j = 0; j < AROUND; j++) between.shift.push(Math.max(-1, Math.min(1, x / edge)));
  };
  const ends = sheet(inner.x, inner.y, style);
  // Into the rim, or over the edge of a lens without one.
  const into = isRimless ? 2.6 : mix(0.5, 0.6 * inner.wide, plastic);
  const lies = isRimless ? HALF_LENS + 0.5 : -0.12 * deep;
  across(bridgeHeight, arch, half, mix(1.5, 0.74 * deep, plastic), edge + into, ends + lies, bulge);
  const bridge = { y: bridgeHeight, half, arch, bulge, reach: edge + into, back: ends + lies - mix(0.75, 0.37 * deep, plastic) };
  if (bar > 0.02) {
    // Along the brows.
    const high = meets(0.86 * (height / 2), -1);
    const thick = mix(0.35, 0.85, bar);
    across(high.y, 1.2, thick, 2 * thick, centre + high.x + 1.5, sheet(high.x, high.y, style) - 0.1 * deep, 1);
  }

  // The ends that carry the arms: out of the rim and around the corner.
  const outer = meets(height * mix(0.2, 0.27, plastic) + Math.max(0, style.sweep) * 0.16 * height, 1);
  const tall = mix(1.15, 1.7 + 0.42 * rim, plastic);
  const thick = mix(0.7, 1.75, plastic);
  const corner = mix(3.4, 3, plastic);
  const rimEnd = outer.x + outer.wide - GROOVE;
  const z = sheet(outer.x, outer.y, style) + (isRimless ? HALF_LENS + 0.4 : -0.12 * deep);
  const begins = rimEnd - (isRimless ? 3 : mix(0.8, 0.5 * outer.wide, plastic));
  const round = Math.max(thick + 0.4, corner * 0.75);
  const turn = Array.from({ length: 7 }, (_, i) => {
    const angle = (Math.PI / 2) * (i / 6);
    return /** @type {import('./sweep.js').Point} */ ([centre + rimEnd + corner - round + round * Math.sin(angle), outer.y, z - round + round * Math.cos(angle)]);
  });
  const hinge = /** @type {import('./sweep.js').Point} */ ([centre + rimEnd + corner, outer.y, z - round - mix(0.6, 1.4, plastic)]);
  const path = [/** @type {import('./sweep.js').Point} */ ([centre + begins, outer.y, z]), ...turn, hinge];
  beside('main', rounded(along(path, [0, 1, 0], (i) => [thick, i === 0 ? tall * mix(1, 1.15, plastic) : tall], square), [0, Math.min(0.35, thick)]));
  // The hinge, on the inner side.
  const pin = [-1, 1].map((side) => /** @type {import('./sweep.js').Point} */ ([hinge[0] - thick - 0.5, hinge[1] + side * Math.max(1.2, 0.75 * tall), hinge[2]]));
  beside('metal', rounded(along([pin[0], [pin[0][0], hinge[1], hinge[2]], pin[1]], [0, 0, 1], () => [0.95, 0.95]), [0.3, 0.3]));
  if (isRimless) {
    // Screws through the lens.
    for (const [x, y] of [[edge + 1.4 - centre + GROOVE, inner.y], [outer.x - 1.7, outer.y]]) {
      const way = facing(x, y);
      const at = [-1.7, 0, 1.9].map((t) => plus([centre + x, y, sheet(x, y, style)], way, t));
      beside('metal', rounded(along(at, [0, 1, 0], () => [0.95, 0.95]), [0.4, 0.4]));
    }
  }
  for (const kind of KINDS) mirror(parts[kind]);
  append(parts.main, between);

  const backOf = (/** @type {number} */ x, /** @type {number} */ y) => sheet(x, y, style) - 0.12 * deep - (isRimless ? HALF_LENS : deep / 2);
  // What comes near the nose: where the rim ends there, and how far back.
  const noseSide = around.flatMap(({ x, y, nx, ny }, i) => (nx < -0.15 && y < 0.75 * (height / 2) ? [{ x: x + nx * (widths[i] - GROOVE), y: y + ny * (widths[i] - GROOVE), z: backOf(x, y) }] : []));
  const padded = meets(bridgeHeight - mix(0.18, 0.36, plastic) * height, -1);
  const reach = radii(around.map((one, i) => ({ ...one, x: one.x + one.nx * widths[i], y: one.y + one.ny * widths[i] })), ANGLES);
  return {
    parts,
    lenses: lens(style, around, centre),
    centre,
    reach,
    hinge,
    nasal: { x: centre + padded.x, y: padded.y, z: sheet(padded.x, padded.y, style) - mix(0.9, 0.3 * deep, plastic) },
    bridge,
    noseSide,
    back: backOf,
    lensBack: (x, y) => sheet(x, y, style) - HALF_LENS,
  };
}

