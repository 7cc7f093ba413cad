// What a make-up artist would put on the generic head, as maps over the front of the face at
// rest: x and y in millimetres. The maps follow the vertices they were painted on, so they need
// no seams and stay in place when the face changes shape.

/** Of texels a side: nothing on them is sharper than a millimetre. */
const SIZE = 256;

/** @typedef {Map<string, [number, number, number]>} Points */

/**
 * @param {Points} at
 * @param {number} first @param {number} last
 */
export function points(at, first, last) {
  const list = [];
  for (let i = first; i <= last; i++) {
    const p = at.get(`ibug_${String(i).padStart(2, '0')}`);
    if (p) list.push(p);
  }
  return list;
}

/** @param {number} low @param {number} high @param {number} x */
export function smoothstep(low, high, x) {
  const t = Math.min(1, Math.max(0, (x - low) / (high - low)));
  return t * t * (3 - 2 * t);
}

/**
 * A point on a smooth way from `b` to `c` (Catmull-Rom), which comes from `a` and goes on to `d`.
 * @param {readonly number[]} a @param {readonly number[]} b @param {readonly number[]} c @param {readonly number[]} d
 * @param {number} t 0 to 1
 */
export function between([ax, ay], [bx, by], [cx, cy], [dx, dy], t) {
  const mix = (/** @type {number} */ p, /** @type {number} */ q, /** @type {number} */ r, /** @type {number} */ s) =>
    0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t * t + (3 * q - p - 3 * r + s) * t ** 3);
  return [mix(ax, bx, cx, dx), mix(ay, by, cy, dy)];
}

/**
 * A closed curve through points, as a polygon.
 * @param {[number, number, number][]} through
 */
function closedCurve(through) {
  const polygon = [];
  const n = through.length;
  for (let i = 0; i < n; i++) {
    const [a, b, c, d] = [-1, 0, 1, 2].map((k) => through[(i + k + n) % n]);
    for (let s = 0; s < 6; s++) polygon.push(between(a, b, c, d, s / 6));
  }
  return polygon;
}

/**
 * Signed distance to a polygon, negative inside.
 * @param {number[][]} polygon @param {number} x @param {number} y
 */
export function distanceTo(polygon, x, y) {
  let nearest = Infinity;
  let inside = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i++) {
    const [ax, ay] = polygon[j];
    const [bx, by] = polygon[i];
    const ex = bx - ax;
    const ey = by - ay;
    const t = Math.min(1, Math.max(0, ((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey || 1)));
    nearest = Math.min(nearest, (x - ax - ex * t) ** 2 + (y - ay - ey * t) ** 2);
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) inside = !inside;
  }
  return (inside ? -1 : 1) * Math.sqrt(nearest);
}

/**
 * Signed distances to a polygon on a grid; 99 where they are surely larger than `reach`.
 * @param {number[][]} polygon @param {number[]} xs @param {number[]} ys @param {number} reach
 */
function distances(polygon, xs, ys, reach) {
  const found = new Float32Array(xs.length * ys.length).fill(99);
  const [left, right, low, high] = [0, 1].flatMap((k) => {
    const all = polygon.map((p) => p[k]);
    return [Math.min(...all) - reach, Math.max(...all) + reach];
  });
  for (const [j, y] of ys.entries()) {
    if (y < low || y > high) continue;
    for (const [i, x] of xs.entries()) {
      if (x >= left && x <= right) found[j * xs.length + i] = distanceTo(polygon, x, y);
    }
  }
  return found;
}

/**
 * Red: lips. Green: blood under the skin (cheeks, nose, lids, chin). Blue: where the skin is
 * thin and smooth (lids). Alpha: roots of a beard and of hair, faint.
 *
 * @param {Points} at landmarks of the face at rest, mm
 * @returns {{ map: import('../rendering/textures.js').Pixels, frame: [number, number, number, number] }} `frame` is
 *   the lower left corner and the size of the map, mm
 */
export function paintFace(at) {
  const mouth = points(at, 48, 59);
  const lips = closedCurve(mouth);
  const eyes = [points(at, 36, 41), points(at, 42, 47)];
  const centres = eyes.map((eye) => [
    eye.reduce((sum, p) => sum + p[0], 0) / eye.length,
    eye.reduce((sum, p) => sum + p[1], 0) / eye.length,
  ]);
  const outlines = eyes.map(closedCurve);
  const [tip] = points(at, 30, 30);
  const wings = [...points(at, 31, 31), ...points(at, 35, 35)];
  const [chin] = points(at, 8, 8);
  const jaw = points(at, 2, 14);
  const apart = centres[1][0] - centres[0][0];
  const span = Math.abs(mouth[6][0] - mouth[0][0]);
  const frame = /** @type {[number, number, number, number]} */ ([
    -80, chin[1] - 25, 160, 160,
  ]);
  const pixels = new Uint8Array(SIZE * SIZE * 4);
  const [xs, ys] = [0, 1].map((k) => Array.from({ length: SIZE }, (_, i) => frame[k] + ((i + 0.5) / SIZE) * frame[2 + k]));

  const blood = new Float32Array(SIZE * SIZE);
  /**
   * A patch of blood, a Gaussian across times a Gaussian along.
   * @param {number} strength @param {number} cx @param {number} cy @param {number} rx @param {number} ry
   */
  const patch = (strength, cx, cy, rx, ry) => {
    const [across, along] = [xs.map((x) => Math.exp(-(((x - cx) / rx) ** 2))), ys.map((y) => Math.exp(-(((y - cy) / ry) ** 2)))];
    for (let j = 0; j < SIZE; j++) {
      const row = strength * along[j];
      if (row < 1e-4) continue;
      for (let i = 0; i < SIZE; i++) blood[j * SIZE + i] += row * across[i];
    }
  };
  patch(0.85, tip[0], tip[1] - 1, 11, 9);
  for (const wing of wings) patch(0.55, wing[0], wing[1] + 4, 8, 7);
  for (const [cx, cy] of centres) {
    patch(0.62, cx * 1.32, cy - 0.55 * apart, 19, 15);
    patch(0.3, cx, cy - 0.16 * apart, 15, 6);
    // The caruncle and the inner corners.
    patch(0.5, cx * 0.52, cy - 2, 4.5, 4);
  }
  patch(0.35, chin[0], chin[1] + 12, 16, 9);

  // Beyond these distances (mm) nothing depends on them any more.
  const fromLips = distances(lips, xs, ys, 9);
  const fromLids = distances(outlines[0], xs, ys, 11);
  distances(outlines[1], xs, ys, 11).forEach((d, o) => {
    if (d < fromLids[o]) fromLids[o] = d;
  });
  const jawAt = xs.map((x) => jawHeight(jaw, x));
  for (let j = 0; j < SIZE; j++) {
    for (let i = 0; i < SIZE; i++) {
      const [x, y] = [xs[i], ys[j]];
      const at = j * SIZE + i;
      const [lip, lid] = [fromLips[at], fromLids[at]];
      const flush = blood[at] + 0.75 * (1 - smoothstep(0, 2.4, lid)) + 0.3 * (1 - smoothstep(0, 7, lip));
      const near = Math.abs(x) < span && Math.abs(y - mouth[0][1]) < span;
      const beard =
        near || y < mouth[0][1] + 18
          ? smoothstep(2, 9, Math.abs(lip)) *
            smoothstep(mouth[0][1] + 26, mouth[0][1] + 4, y + 0.25 * Math.abs(x)) *
            (1 - smoothstep(-2, 14, y - jawAt[i] - 42))
          : 0;
      const o = 4 * at;
      pixels[o] = 255 * (1 - smoothstep(-1.5, 1.1, lip));
      pixels[o + 1] = 255 * Math.min(1, flush);
      pixels[o + 2] = 255 * (1 - smoothstep(3, 11, lid));
      pixels[o + 3] = 255 * Math.min(1, Math.max(0, beard));
    }
  }
  return { map: { size: SIZE, rgba: pixels }, frame };
}

/** @param {[number, number, number][]} jaw @param {number} x */
function jawHeight(jaw, x) {
  let nearest = jaw[0];
  for (const p of jaw) if (Math.abs(p[0] - x) < Math.abs(nearest[0] - x)) nearest = p;
  return nearest[1];
}
