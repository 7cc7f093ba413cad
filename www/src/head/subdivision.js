/** How far an edge may lie under the curve through its ends and not be split, mm: half of a pixel, where a head fills a screen. */
const OUTLINE = 0.1;
/** Each halves an edge, and leaves a quarter of that distance: crowns have edges of 17 mm, which lie half a millimetre under theirs. */
const ROUNDS = 2;
/** The cosines of the angles between the normals of an edge's ends from which on a crease is no curve, and up to which it is one. */
const CREASE = 0;
const CURVE = 0.5;

/**
 * Puts a point in the middle of the curve between two others, and has it face as the edge does there: the middle of the cubic of a curved
 * PN triangle (Vlachos et al., 2001, section 3.1).
 * @param {Float32Array} p @param {Float32Array} n positions, mm, and unit normals, 3 a point
 * @param {number} to @param {number} i @param {number} j where those of the three points begin
 */
function bend(p, n, to, i, j) {
  const ax = p[i];
  const ay = p[i + 1];
  const az = p[i + 2];
  const bx = p[j];
  const by = p[j + 1];
  const bz = p[j + 2];
  const mx = n[i];
  const my = n[i + 1];
  const mz = n[i + 2];
  const nx = n[j];
  const ny = n[j + 1];
  const nz = n[j + 2];
  const alike = mx * nx + my * ny + mz * nz;
  const round = -0.125 * Math.min(1, Math.max(0, (alike - CREASE) / (CURVE - CREASE)));
  const atA = round * ((bx - ax) * mx + (by - ay) * my + (bz - az) * mz);
  const atB = round * ((ax - bx) * nx + (ay - by) * ny + (az - bz) * nz);
  p[to] = 0.5 * (ax + bx) + atA * mx + atB * nx;
  p[to + 1] = 0.5 * (ay + by) + atA * my + atB * ny;
  p[to + 2] = 0.5 * (az + bz) + atA * mz + atB * nz;
  n[to] = 0.5 * (mx + nx);
  n[to + 1] = 0.5 * (my + ny);
  n[to + 2] = 0.5 * (mz + nz);
}

/**
 * How far a point lies from the middle of two others, mm.
 * @param {Float32Array} p 3 a point @param {number} to @param {number} i @param {number} j where those of the three points begin
 */
const above = (p, to, i, j) => Math.hypot(p[to] - (p[i] + p[j]) / 2, p[to + 1] - (p[i + 1] + p[j + 1]) / 2, p[to + 2] - (p[i + 2] + p[j + 2]) / 2);

/**
 * Splits the edges of a mesh where its outline would show them. What is new is a point in the middle of an edge, on the curve that the
 * normals at its ends tell; what there was stays as it is. Both sides of an edge split it, seams of the texture too.
 *
 * @param {Uint32Array} index triangles of corners
 * @param {Uint32Array} vertices of each corner
 * @param {Float32Array} rest @param {Float32Array} restNormals 3 a vertex
 * @param {ArrayLike<number>} keep not nought for vertices whose edges stay whole
 */
export function subdivide(index, vertices, rest, restNormals, keep) {
  const first = vertices.length;
  // As many as if each edge was split once. More would be a mesh of another kind, which is split as far as there is room.
  const most = 4 * first;
  let corners = first;
  /** The two ends of each new corner, which are corners or new ones before it. */
  const ends = new Uint32Array(2 * (most - first));
  // As far as it has come: places and normals of corners, whose edges stay whole, and which vertices they come from.
  const places = new Float32Array(3 * most);
  const facing = new Float32Array(3 * most);
  const whole = new Uint8Array(most);
  for (let i = 0; i < first; i++) {
    const v = vertices[i];
    whole[i] = keep[v] ? 1 : 0;
    for (let k = 0; k < 3; k++) {
      places[3 * i + k] = rest[3 * v + k];
      facing[3 * i + k] = restNormals[3 * v + k];
    }
  }
  /** Triangles without an edge that is split. @type {number[]} */
  const done = [];
  let open = index;
  for (let round = 0; round < ROUNDS; round++) {
    // The edges from each corner to those with a larger number, linked.
    const from = new Int32Array(corners).fill(-1);
    const next = new Int32Array(open.length);
    const to = new Uint32Array(open.length);
    const middles = new Int32Array(open.length);
    let edges = 0;
    /** The corner in the middle of an edge that is split, or -1. @param {number} one @param {number} other */
    const middle = (one, other) => {
      const [a, b] = one < other ? [one, other] : [other, one];
      let e = from[a];
      while (e >= 0 && to[e] !== b) e = next[e];
      if (e < 0) {
        e = edges++;
        next[e] = from[a];
        from[a] = e;
        to[e] = b;
        middles[e] = -1;
        if (!whole[a] && !whole[b] && corners < most) {
          bend(places, facing, 3 * corners, 3 * a, 3 * b);
          if (above(places, 3 * corners, 3 * a, 3 * b) > OUTLINE) {
            ends.set([a, b], 2 * (corners - first));
            middles[e] = corners++;
          }
        }
      }
      return middles[e];
    };
    /** @type {number[]} */
    const finer = [];
    for (let t = 0; t < open.length; t += 3) {
      let a = open[t];
      let b = open[t + 1];
      let c = open[t + 2];
      let ab = middle(a, b);
      let bc = middle(b, c);
      let ca = middle(c, a);
      const split = Number(ab >= 0) + Number(bc >= 0) + Number(ca >= 0);
      if (split === 0) done.push(a, b, c);
      else if (split === 3) finer.push(a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca);
      else {
        // Turned so that the first edge is the only one that is split, or the last the only one that is not.
        while (split === 1 ? ab < 0 : ca >= 0) [a, b, c, ab, bc, ca] = [b, c, a, bc, ca, ab];
        if (split === 1) finer.push(a, ab, c, ab, b, c);
        else finer.push(ab, b, bc, a, ab, bc, a, bc, c);
      }
    }
    open = Uint32Array.from(finer);
  }
  const count = corners - first;
  const parents = ends.slice(0, 2 * count);
  // The first and the last vertex that each new one comes from: few lie in what is moved.
  const low = new Uint32Array(count);
  const high = new Uint32Array(count);
  for (let m = 0; m < count; m++) {
    const [a, b] = [parents[2 * m], parents[2 * m + 1]];
    low[m] = Math.min(a < first ? vertices[a] : low[a - first], b < first ? vertices[b] : low[b - first]);
    high[m] = Math.max(a < first ? vertices[a] : high[a - first], b < first ? vertices[b] : high[b - first]);
  }
  /** @param {number} corner @returns {number[]} */
  const rootsOf = (corner) => (corner < first ? [vertices[corner]] : [...rootsOf(parents[2 * (corner - first)]), ...rootsOf(parents[2 * (corner - first) + 1])]);
  return {
    index: Uint32Array.from([...done, ...open]),
    /** How many corners there are now. */
    corners,
    /** The vertices that a corner lies on or between. */
    rootsOf,
    /**
     * Fills in what the new corners have of something linear, between what the ends of their edges have.
     * @template {Float32Array | Uint8Array | Int8Array} Values
     * @param {Values} array @param {number} size numbers a corner
     */
    between(array, size) {
      for (let m = 0; m < count; m++) {
        const [to, a, b] = [size * (first + m), size * parents[2 * m], size * parents[2 * m + 1]];
        for (let k = 0; k < size; k++) array[to + k] = (array[a + k] + array[b + k]) / 2;
      }
      return array;
    },
    /**
     * Puts those of the new corners on their curves that come from a range of vertices, and has them face as the edges do.
     * @param {Float32Array} positions @param {Float32Array} normals 3 a corner
     * @param {number} start @param {number} end of the vertices
     */
    curve(positions, normals, start, end) {
      for (let m = 0; m < count; m++) {
        if (low[m] < end && high[m] >= start) bend(positions, normals, 3 * (first + m), 3 * parents[2 * m], 3 * parents[2 * m + 1]);
      }
    },
  };
}
