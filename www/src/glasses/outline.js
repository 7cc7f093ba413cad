// The outline of a lens: of the subject's left one, x to the temple and y up, mm, around the middle of the box that holds it.

/** Points of an outline before they are set evenly. */
const DENSE = 360;

/**
 * A point of an outline in half boxes, before it is put in the middle of them.
 * @param {number} angle @param {Pick<import('./style.js').Lens, 'form' | 'sweep'>} style @returns {[number, number]}
 */
function point(angle, { form, sweep }) {
  // From a circle to a rectangle with round corners (Lame's curves).
  const power = 2 / (2 + 4.5 * form ** 1.2);
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const u = Math.sign(cos) * Math.abs(cos) ** power;
  const v = Math.sign(sin) * Math.abs(sin) ** power;
  const [drop, cat] = [Math.max(0, -sweep), Math.max(0, sweep)];
  const [above, below] = [Math.max(0, v), Math.max(0, -v)];
  const nasal = Math.max(0, -u);
  const outer = (u + 1) / 2;
  let [x, y] = [u, v];
  // Below it is narrower, most of all beside the nose, which is broader there.
  x *= 1 - below ** 1.5 * (0.03 + 0.05 * form + 0.05 * drop + 0.1 * cat);
  x += nasal * below * (0.1 + 0.16 * form + 0.32 * drop);
  // A drop hangs down to the temple from a flat brow line.
  y -= drop * (below * (0.1 + 0.12 * u) + above * (0.1 + 0.1 * u + 0.1 * above));
  // The upper outer corner of the upswept rises and goes out.
  y += cat * (above * (0.7 * outer ** 3 - 0.16 * nasal) + below * (0.3 * outer - 0.04));
  x += cat * (0.24 * above * outer ** 2 - 0.1 * below * outer);
  return [x, y];
}

/**
 * An outline in a box of width and height 1.
 * @param {Pick<import('./style.js').Lens, 'form' | 'sweep'>} style @param {number} steps so many points, not evenly
 * @returns {[number, number][]}
 */
export function unsized(style, steps = DENSE) {
  const raw = Array.from({ length: steps }, (_, i) => point((2 * Math.PI * i) / steps, style));
  const [xs, ys] = [0, 1].map((k) => raw.map((one) => one[k]));
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  return raw.map(([x, y]) => [(x - (left + right) / 2) / (right - left), (y - (low + high) / 2) / (high - low)]);
}

/**
 * @param {import('./style.js').Lens} style @param {number} many points
 * @param {readonly [number, number][]} [box] its `unsized`, if that is known
 * @returns {{ x: number, y: number, nx: number, ny: number }[]} evenly along it, counter-clockwise from the temple, with the way out of it
 */
export function outline(style, many, box = unsized(style)) {
  const steps = box.length;
  const dense = box.map(([x, y]) => [x * style.width, y * style.height]);
  const lengths = [0];
  for (let i = 0; i < steps; i++) {
    const [a, b] = [dense[i], dense[(i + 1) % steps]];
    lengths.push(lengths[i] + Math.hypot(b[0] - a[0], b[1] - a[1]));
  }
  let at = 0;
  const even = Array.from({ length: many }, (_, n) => {
    const want = (lengths[steps] * n) / many;
    while (lengths[at + 1] < want) at++;
    const t = (want - lengths[at]) / (lengths[at + 1] - lengths[at]);
    const [a, b] = [dense[at], dense[(at + 1) % steps]];
    return [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
  });
  return even.map(([x, y], i) => {
    const [before, after] = [even[(i + many - 1) % many], even[(i + 1) % many]];
    const [dx, dy] = [after[0] - before[0], after[1] - before[1]];
    const length = Math.hypot(dx, dy);
    return { x, y, nx: dy / length, ny: -dx / length };
  });
}

/**
 * How far from the middle the outline is, by the angle: as many numbers as are asked for, from the temple on counter-clockwise.
 * @param {ReturnType<typeof outline>} points @param {number} many
 */
export function radii(points, many) {
  const around = points.map(({ x, y }) => [Math.atan2(y, x), Math.hypot(x, y)]).sort((a, b) => a[0] - b[0]);
  const last = around.length - 1;
  const ring = [[around[last][0] - 2 * Math.PI, around[last][1]], ...around, [around[0][0] + 2 * Math.PI, around[0][1]]];
  return Float32Array.from({ length: many }, (_, i) => {
    let angle = (2 * Math.PI * i) / many;
    if (angle > Math.PI) angle -= 2 * Math.PI;
    const next = Math.max(1, ring.findIndex(([a]) => a >= angle));
    const [[a, r], [b, q]] = [ring[next - 1], ring[next]];
    return r + (b > a ? ((angle - a) / (b - a)) * (q - r) : 0);
  });
}
