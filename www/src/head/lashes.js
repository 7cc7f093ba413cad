import { BufferAttribute, BufferGeometry, Color, DoubleSide, DynamicDrawUsage, Mesh, ShaderMaterial, Vector3 } from 'three';
import { backdropUniforms } from '../rendering/backdrop.js';
import { chance } from '../chance.js';

// A lash is thinner than a pixel from where a face is usually seen. It is drawn at least a pixel
// wide and so much fainter instead, or it would break up into dots.
const VERTEX = /* glsl */ `
  attribute vec3 along;
  attribute vec2 edge; // side, half the width in mm
  uniform vec2 backdropSize;
  uniform float thick;
  varying float vFaint;
  void main() {
    vec4 at = modelViewMatrix * vec4(position, 1.0);
    vec2 way = (modelViewMatrix * vec4(along, 0.0)).xy;
    vec2 across = normalize(vec2(-way.y, way.x) + 1e-6);
    float pixel = -2.0 * at.z / (projectionMatrix[1][1] * backdropSize.y);
    float width = max(thick * edge.y, 0.62 * pixel);
    vFaint = thick * edge.y / width;
    at.xy += across * edge.x * width;
    gl_Position = projectionMatrix * at;
  }
`;
const FRAGMENT = /* glsl */ `
  uniform vec3 colour;
  varying float vFaint;
  void main() { gl_FragColor = vec4(colour, 0.92 * vFaint); }
`;

const SEGMENTS = 4;
/** Half of a lash's width on its way from root (0) to tip (1), mm. */
const thickness = (/** @type {number} */ t) => 0.075 * (1 - 0.8 * t);
/** Around a lash that is a body. */
const SIDES = 3;
/** The points of its way at which a body has that many corners; it has one more at its tip. */
const RINGS = [0, 2, 3];
/** How much shorter and thinner men's lashes are, and how much thinner they are with the years. */
const MANLY = { short: 0.32, thin: 0.35 };
const OLD = 0.35;

/**
 * The shortest way along edges from each vertex to the next.
 * @param {Uint32Array} triangles @param {Float32Array} positions @param {number[]} stops
 */
function edgePath(triangles, positions, stops) {
  /** @type {Map<number, Set<number>>} */
  const near = new Map();
  const [x, y, z] = [0, 1, 2].map((k) => positions[3 * stops[0] + k]);
  for (let t = 0; t < triangles.length; t += 3) {
    const o = 3 * triangles[t];
    // A lid is no longer than this (mm); the rest of the head need not be searched.
    if (Math.hypot(positions[o] - x, positions[o + 1] - y, positions[o + 2] - z) > 60) continue;
    for (let k = 0; k < 3; k++) {
      const [a, b] = [triangles[t + k], triangles[t + ((k + 1) % 3)]];
      if (!near.has(a)) near.set(a, new Set());
      if (!near.has(b)) near.set(b, new Set());
      near.get(a)?.add(b);
      near.get(b)?.add(a);
    }
  }
  const length = (/** @type {number} */ a, /** @type {number} */ b) =>
    Math.hypot(
      positions[3 * a] - positions[3 * b],
      positions[3 * a + 1] - positions[3 * b + 1],
      positions[3 * a + 2] - positions[3 * b + 2],
    );
  const path = [stops[0]];
  for (let s = 1; s < stops.length; s++) {
    const [from, to] = [stops[s - 1], stops[s]];
    const distance = new Map([[from, 0]]);
    const before = new Map();
    const open = new Set([from]);
    while (open.size) {
      let here = -1;
      for (const v of open) if (here < 0 || (distance.get(v) ?? 0) < (distance.get(here) ?? 0)) here = v;
      if (here === to) break;
      open.delete(here);
      for (const next of near.get(here) ?? []) {
        const d = (distance.get(here) ?? 0) + length(here, next);
        if (d < (distance.get(next) ?? Infinity)) {
          distance.set(next, d);
          before.set(next, here);
          open.add(next);
        }
      }
    }
    const leg = [];
    for (let v = to; v !== from && v !== undefined; v = before.get(v)) leg.push(v);
    path.push(...leg.reverse());
  }
  return path;
}

/**
 * Eyelashes: thin tapering ribbons rooted on the edges of the lids.
 *
 * @param {Uint32Array} triangles vertices of the skin
 * @param {Float32Array} rest
 * @param {(name: string) => number} vertexOf the vertex nearest a landmark
 */
export function createLashes(triangles, rest, vertexOf) {
  const name = (/** @type {number} */ i) => vertexOf(`ibug_${i}`);
  const lids = [
    { path: [36, 37, 38, 39], length: 6.6, count: 120, rise: 1, outer: 0 },
    { path: [36, 41, 40, 39], length: 2.8, count: 50, rise: -0.6, outer: 0 },
    { path: [42, 43, 44, 45], length: 6.6, count: 120, rise: 1, outer: 1 },
    { path: [42, 47, 46, 45], length: 2.8, count: 50, rise: -0.6, outer: 1 },
  ].map((lid) => ({ ...lid, path: edgePath(triangles, rest, lid.path.map(name)) }));

  const random = chance(5);
  const lashes = lids.flatMap((lid) =>
    Array.from({ length: lid.count }, (_, i) => ({
      lid,
      at: 0.05 + (0.92 * (i + 2.2 * (random() - 0.5))) / lid.count,
      length: lid.length * (0.5 + 0.6 * random()),
      lean: (random() - 0.5) * 0.9,
      curl: 0.75 + 0.4 * random(),
    })),
  );
  const perLash = 2 * (SEGMENTS + 1);
  const array = new Float32Array(lashes.length * perLash * 3);
  const index = [];
  for (let n = 0; n < lashes.length; n++) {
    for (let s = 0; s < SEGMENTS; s++) {
      const o = n * perLash + 2 * s;
      index.push(o, o + 1, o + 2, o + 1, o + 3, o + 2);
    }
  }
  const geometry = new BufferGeometry();
  const position = new BufferAttribute(array, 3).setUsage(DynamicDrawUsage);
  geometry.setIndex(index);
  geometry.setAttribute('position', position);
  const course = new Float32Array(array.length);
  const along = new BufferAttribute(course, 3).setUsage(DynamicDrawUsage);
  geometry.setAttribute('along', along);
  const edges = new Float32Array(lashes.length * perLash * 2);
  for (let i = 0; i < edges.length / 2; i++) {
    const t = Math.floor((i % perLash) / 2) / SEGMENTS;
    edges.set([i % 2 ? 1 : -1, thickness(t)], 2 * i);
  }
  geometry.setAttribute('edge', new BufferAttribute(edges, 2));
  const colour = { value: new Color() };
  const thick = { value: 1 };
  let manly = 0;
  let years = 0;
  const suited = () => (thick.value = (1 - MANLY.thin * manly) * (1 - OLD * years));
  const mesh = new Mesh(
    geometry,
    new ShaderMaterial({
      uniforms: { backdropSize: backdropUniforms.backdropSize, colour, thick },
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      side: DoubleSide,
      transparent: true,
      depthWrite: false,
      toneMapped: false,
    }),
  );
  mesh.frustumCulled = false;
  mesh.name = 'lashes';
  mesh.raycast = () => {};

  // What is the same on every face: the edge of the lid that it stands on, how far along that, how long it is.
  const rooted = lashes.map(({ lid, at, length, lean, curl }) => {
    const where = at * (lid.path.length - 1);
    const i = Math.min(lid.path.length - 2, Math.floor(where));
    // Longest at the outer third, short at the inner corner.
    const outward = lid.outer === 1 ? at : 1 - at;
    const reach = length * (0.45 + 0.75 * outward * (1 - 0.55 * outward) * 1.6);
    return { from: 3 * lid.path[i], to: 3 * lid.path[i + 1], part: where - i, lid, lean, curl, reach };
  });
  /** The way of a lash: where its root comes from, and its points from there to its tip. */
  const way = new Float64Array(3 * (SEGMENTS + 2));
  /**
   * Follows a lash from its root to its tip. All are traced with every event of a drag: it is plain numbers.
   * @param {typeof rooted[number]} lash @param {ArrayLike<number>} positions @param {Vector3[]} eyes centres, the subject's right first
   */
  function trace({ from, to, part, lid, lean, curl, reach: longest }, positions, eyes) {
    const reach = (1 - MANLY.short * manly) * longest;
    const rootX = positions[from] + part * (positions[to] - positions[from]);
    const rootY = positions[from + 1] + part * (positions[to + 1] - positions[from + 1]);
    const rootZ = positions[from + 2] + part * (positions[to + 2] - positions[from + 2]);
    const { x, y, z } = eyes[lid.outer];
    const [ox, oy, oz] = [rootX - x, rootY - y, rootZ - z];
    const far = Math.sqrt(ox * ox + oy * oy + oz * oz);
    // Lashes fan out: sideways with their place on the lid, always forward.
    let wayX = (ox / far) * 1.25 + lean * 0.5;
    let wayY = lid.rise * 0.12;
    let wayZ = Math.max(0.75, oz / far);
    const size = Math.sqrt(wayX * wayX + wayY * wayY + wayZ * wayZ);
    wayX /= size;
    wayY /= size;
    wayZ /= size;
    way[0] = rootX - wayX;
    way[1] = rootY - wayY;
    way[2] = rootZ - wayZ;
    for (let s = 0; s <= SEGMENTS; s++) {
      const t = s / SEGMENTS;
      const out = reach * (t - 0.22 * t * t);
      way[3 * s + 3] = rootX + wayX * out;
      way[3 * s + 4] = rootY + wayY * reach * t + lid.rise * reach * (0.42 * curl * t * t - 0.3 * t * (1 - t));
      way[3 * s + 5] = rootZ + wayZ * out;
    }
  }
  /** @param {ArrayLike<number>} positions @param {Vector3[]} eyes centres, the subject's right first */
  function update(positions, eyes) {
    let o = 0;
    for (const lash of rooted) {
      trace(lash, positions, eyes);
      for (let i = 3; i < way.length; i += 3, o += 6) {
        array[o] = array[o + 3] = way[i];
        array[o + 1] = array[o + 4] = way[i + 1];
        array[o + 2] = array[o + 5] = way[i + 2];
        course[o] = course[o + 3] = way[i] - way[i - 3];
        course[o + 1] = course[o + 4] = way[i + 1] - way[i - 2];
        course[o + 2] = course[o + 5] = way[i + 2] - way[i - 1];
      }
    }
    position.needsUpdate = along.needsUpdate = true;
  }
  const each = RINGS.length * SIDES + 1;
  /**
   * The corners of lashes that are bodies, for each slider and expression of a file: plain numbers.
   * @param {ArrayLike<number>} positions @param {Vector3[]} eyes centres, the subject's right first
   */
  function bodiesAt(positions, eyes) {
    const points = new Float32Array(lashes.length * each * 3);
    let o = 0;
    for (const lash of rooted) {
      trace(lash, positions, eyes);
      for (let s = 0; s <= SEGMENTS; s++) {
        const isTip = s === SEGMENTS;
        if (!isTip && !RINGS.includes(s)) continue;
        const [x, y, z] = way.subarray(3 * s + 3, 3 * s + 6);
        const [dx, dy, dz] = [x - way[3 * s], y - way[3 * s + 1], z - way[3 * s + 2]];
        // Across the lash and sideways, and across both.
        const flat = Math.hypot(dy, dz);
        const [ay, az] = [-dz / flat, dy / flat];
        const long = Math.hypot(flat, dx);
        const [ux, uy, uz] = [(ay * dz - az * dy) / long, (az * dx) / long, (-ay * dx) / long];
        for (let side = 0; side < (isTip ? 1 : SIDES); side++, o += 3) {
          const angle = (2 * Math.PI * side) / SIDES;
          const wide = isTip ? 0 : thick.value * thickness(s / SEGMENTS);
          const [cos, sin] = [wide * Math.cos(angle), wide * Math.sin(angle)];
          points[o] = x + sin * ux;
          points[o + 1] = y + cos * ay + sin * uy;
          points[o + 2] = z + cos * az + sin * uz;
        }
      }
    }
    return points;
  }
  /**
   * The same lashes as bodies, which are seen from every side, on any face of the model.
   * @param {ArrayLike<number>} positions @param {Vector3[]} eyes centres, the subject's right first
   */
  function bodies(positions, eyes) {
    const points = bodiesAt(positions, eyes);
    const normals = new Float32Array(points.length);
    const triangles = [];
    const [middle, point] = [new Vector3(), new Vector3()];
    for (let first = 0; first < lashes.length * each; first += each) {
      for (let ring = first; ring + 1 < first + each; ring += SIDES) {
        middle.set(0, 0, 0);
        for (let side = 0; side < SIDES; side++) middle.addScaledVector(point.fromArray(points, 3 * (ring + side)), 1 / SIDES);
        const isLast = ring + SIDES + 1 === first + each;
        for (let side = 0; side < SIDES; side++) {
          point.fromArray(points, 3 * (ring + side)).sub(middle).normalize().toArray(normals, 3 * (ring + side));
          const [a, b] = [ring + side, ring + ((side + 1) % SIDES)];
          if (isLast) triangles.push(a, ring + SIDES, b);
          else triangles.push(a, a + SIDES, b, b, a + SIDES, b + SIDES);
        }
      }
      const tip = 3 * (first + each - 1);
      point.fromArray(points, tip).sub(middle).normalize().toArray(normals, tip);
    }
    return { positions: points, normals, triangles: Uint32Array.from(triangles) };
  }
  return {
    mesh,
    /** What they stand on. */
    vertices: lids.flatMap((lid) => lid.path),
    update,
    bodies,
    bodiesAt,
    /** As the screen shows it, sRGB. */
    get colour() {
      return colour.value;
    },
    /** Those of a man as far as he is one, from 0 to 1. @param {number} now @returns {boolean} whether they are others than before */
    suit(now) {
      if (now === manly) return false;
      manly = now;
      suited();
      return true;
    },
    /** @param {ReturnType<typeof import('./pigments.js').pigments>} colours */
    paint({ lashes, lines }) {
      colour.value.copy(lashes);
      years = lines;
      suited();
    },
  };
}
