// How much of the sky each vertex sees: ambient occlusion, cosine weighted, by drawing the head
// into a depth buffer from many sides. Nostrils, eye sockets, ears and lips get their depth from
// this. It is computed once, on the median face: a slider changes it less than the eye can see.

/** Each with its opposite, which sees the same lines from the other end. */
const DIRECTIONS = 32;
const SIZE = 224;

/**
 * @param {Float32Array} positions 3 a vertex, mm
 * @param {Float32Array} normals 3 a vertex
 * @param {Uint32Array} triangles 3 vertices a triangle
 * @returns {Float32Array} 1 (open) to 0 (closed) a vertex
 */
export function ambientOcclusion(positions, normals, triangles) {
  const count = positions.length / 3;
  const seen = new Float32Array(count);
  const possible = new Float32Array(count);
  const flat = new Float32Array(positions.length);
  const before = new Float32Array(SIZE * SIZE);
  const behind = new Float32Array(SIZE * SIZE);
  let reach = 0;
  const centre = [0, 0, 0];
  for (let i = 0; i < positions.length; i++) centre[i % 3] += positions[i] / count;
  for (let i = 0; i < positions.length; i += 3) {
    reach = Math.max(
      reach,
      Math.hypot(
        positions[i] - centre[0],
        positions[i + 1] - centre[1],
        positions[i + 2] - centre[2],
      ),
    );
  }
  const scale = (SIZE - 4) / (2 * reach);

  for (let k = 0; k < DIRECTIONS; k++) {
    // Points of a Fibonacci spiral are spread evenly over the half sphere.
    const z = 1 - (k + 0.5) / DIRECTIONS;
    const radius = Math.sqrt(1 - z * z);
    const turn = k * 2.399963229728653;
    const d = [radius * Math.cos(turn), radius * Math.sin(turn), z];
    const a = Math.abs(d[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0];
    const u = normalised(cross(a, d));
    const v = cross(d, u);
    for (let i = 0; i < flat.length; i += 3) {
      const x = positions[i] - centre[0];
      const y = positions[i + 1] - centre[1];
      const w = positions[i + 2] - centre[2];
      flat[i] = (x * u[0] + y * u[1] + w * u[2]) * scale + SIZE / 2;
      flat[i + 1] = (x * v[0] + y * v[1] + w * v[2]) * scale + SIZE / 2;
      flat[i + 2] = x * d[0] + y * d[1] + w * d[2];
    }
    before.fill(-Infinity);
    behind.fill(-Infinity);
    for (let t = 0; t < triangles.length; t += 3) {
      fill(before, behind, flat, 3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]);
    }
    for (let i = 0; i < count; i++) {
      const o = 3 * i;
      const along = normals[o] * d[0] + normals[o + 1] * d[1] + normals[o + 2] * d[2];
      const cosine = Math.abs(along);
      if (cosine <= 0.05) continue;
      possible[i] += cosine;
      // Step off the surface by a pixel and a half, so that it does not hide itself.
      const off = 1.5 / scale;
      const x = flat[o] + off * scale * dot3(normals, o, u);
      const y = flat[o + 1] + off * scale * dot3(normals, o, v);
      const depth = along > 0 ? before : behind;
      const here = (along > 0 ? flat[o + 2] : -flat[o + 2]) + off * cosine;
      const pixel = (y | 0) * SIZE + (x | 0);
      if (depth[pixel] <= here + 0.6 / scale) seen[i] += cosine;
    }
  }
  for (let i = 0; i < count; i++) seen[i] = possible[i] > 0 ? seen[i] / possible[i] : 0;
  return smoothed(seen, triangles, 2);
}

/**
 * Averages a value with its neighbours'.
 * @param {Float32Array} values
 * @param {Uint32Array} triangles
 * @param {number} rounds
 */
export function smoothed(values, triangles, rounds) {
  let from = values;
  for (let round = 0; round < rounds; round++) {
    const sum = new Float32Array(from.length);
    const weight = new Float32Array(from.length);
    for (let t = 0; t < triangles.length; t += 3) {
      const a = triangles[t];
      const b = triangles[t + 1];
      const c = triangles[t + 2];
      const mean = (from[a] + from[b] + from[c]) / 3;
      sum[a] += mean;
      sum[b] += mean;
      sum[c] += mean;
      weight[a]++;
      weight[b]++;
      weight[c]++;
    }
    from = sum.map((total, i) => (weight[i] > 0 ? total / weight[i] : from[i]));
  }
  return from;
}

/** @param {Float32Array} array @param {number} o @param {number[]} v */
function dot3(array, o, v) {
  return array[o] * v[0] + array[o + 1] * v[1] + array[o + 2] * v[2];
}

/** @param {number[]} a @param {number[]} b */
function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** @param {number[]} v */
function normalised(v) {
  const length = Math.hypot(v[0], v[1], v[2]);
  return v.map((c) => c / length);
}

/**
 * Draws one triangle into the depth buffer of the side that it faces; larger is nearer. What faces away
 * has something before it.
 * @param {Float32Array} before @param {Float32Array} behind
 * @param {Float32Array} p
 * @param {number} a @param {number} b @param {number} c
 */
function fill(before, behind, p, a, b, c) {
  const ax = p[a], ay = p[a + 1], bx = p[b], by = p[b + 1], cx = p[c], cy = p[c + 1];
  const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  if (area === 0) return;
  const depth = area > 0 ? before : behind;
  const side = area > 0 ? 1 : -1;
  // Only the pixels whose middles may be inside.
  const x0 = Math.max(0, Math.ceil((ax < bx ? (ax < cx ? ax : cx) : bx < cx ? bx : cx) - 0.5));
  const x1 = Math.min(SIZE - 1, Math.floor((ax > bx ? (ax > cx ? ax : cx) : bx > cx ? bx : cx) - 0.5));
  const y0 = Math.max(0, Math.ceil((ay < by ? (ay < cy ? ay : cy) : by < cy ? by : cy) - 0.5));
  const y1 = Math.min(SIZE - 1, Math.floor((ay > by ? (ay > cy ? ay : cy) : by > cy ? by : cy) - 0.5));
  if (x0 > x1 || y0 > y1) return;
  // Weights of the corners, which change by as much from each pixel to the next.
  const ua = (by - cy) / area;
  const ub = (cy - ay) / area;
  const px = x0 + 0.5;
  const za = side * p[a + 2], zb = side * p[b + 2], zc = side * p[c + 2];
  for (let y = y0; y <= y1; y++) {
    const py = y + 0.5;
    let wa = ((bx - px) * (cy - py) - (by - py) * (cx - px)) / area;
    let wb = ((cx - px) * (ay - py) - (cy - py) * (ax - px)) / area;
    for (let o = y * SIZE + x0; o <= y * SIZE + x1; o++) {
      const wc = 1 - wa - wb;
      if (wa >= 0 && wb >= 0 && wc >= 0) {
        const z = wa * za + wb * zb + wc * zc;
        if (z > depth[o]) depth[o] = z;
      }
      wa += ua;
      wb += ub;
    }
  }
}
