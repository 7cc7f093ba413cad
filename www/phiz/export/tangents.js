/**
 * The way in which the first texture coordinate grows on the surface, for normal maps (E. Lengyel, "Computing Tangent
 * Space Basis Vectors for an Arbitrary Mesh", 2001): unit vectors across the normals, and on which side of both the
 * second one grows, 1 or -1.
 *
 * @param {Float32Array} positions three a vertex @param {Float32Array} normals three a vertex
 * @param {Uint32Array} corners the vertex of each corner
 * @param {Float32Array} uvs two a corner, from the lower left
 * @param {Uint32Array} triangles three corners a triangle
 * @returns {Float32Array} four a corner
 */
export function tangentsOf(positions, normals, corners, uvs, triangles) {
  const count = corners.length;
  const along = new Float64Array(3 * count);
  const up = new Float64Array(3 * count);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = triangles.subarray(t, t + 3);
    const [u1, v1] = [uvs[2 * b] - uvs[2 * a], uvs[2 * b + 1] - uvs[2 * a + 1]];
    const [u2, v2] = [uvs[2 * c] - uvs[2 * a], uvs[2 * c + 1] - uvs[2 * a + 1]];
    // Twice the area on the picture; larger triangles count for more.
    const turn = Math.sign(u1 * v2 - u2 * v1);
    for (let k = 0; k < 3; k++) {
      const from = positions[3 * corners[a] + k];
      const [d1, d2] = [positions[3 * corners[b] + k] - from, positions[3 * corners[c] + k] - from];
      for (const corner of [a, b, c]) {
        along[3 * corner + k] += turn * (d1 * v2 - d2 * v1);
        up[3 * corner + k] += turn * (d2 * u1 - d1 * u2);
      }
    }
  }
  const out = new Float32Array(4 * count);
  for (let i = 0; i < count; i++) {
    const n = normals.subarray(3 * corners[i], 3 * corners[i] + 3);
    const way = along.subarray(3 * i, 3 * i + 3);
    const dot = (/** @type {ArrayLike<number>} */ a, /** @type {ArrayLike<number>} */ b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let across = [0, 1, 2].map((k) => way[k] - dot(way, n) * n[k]);
    if (!(Math.hypot(...across) > 1e-9 * Math.hypot(...way))) {
      // On a point of the picture there is no way: any one across the normal is as good.
      const axis = [0, 0, 0];
      axis[Math.abs(n[0]) < 0.6 ? 0 : 1] = 1;
      across = [0, 1, 2].map((k) => axis[k] - dot(axis, n) * n[k]);
    }
    const length = Math.hypot(...across);
    const [x, y, z] = across.map((value) => value / length);
    out.set([x, y, z], 4 * i);
    const side = [n[1] * z - n[2] * y, n[2] * x - n[0] * z, n[0] * y - n[1] * x];
    out[4 * i + 3] = dot(side, up.subarray(3 * i, 3 * i + 3)) < 0 ? -1 : 1;
  }
  return out;
}
