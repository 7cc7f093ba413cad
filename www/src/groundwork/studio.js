// A photographer's studio as an environment: a dim room and soft boxes, which also are what the
// eyes mirror. three.js would draw such a room and prefilter it on the graphics card, with hundreds
// of samples for each of half a million texels, on which a weak one spends seconds. But the room is
// six rectangles, and a processor has it in less than a tenth of one.

const SIZE = 128;
/** From 128 down to 8 texels a side, the least that diffuse light can be read from. */
const LEVELS = 5;
const WALL = [0.3, 0.31, 0.33];
/** The width of a soft box's edge, radians: about a texel. */
const EDGE = 0.018;

/** @param {number[]} a @param {number[]} b */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {number[]} a @param {number[]} b */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {number[]} a */
const normalised = (a) => a.map((x) => x / Math.hypot(...a));

/**
 * A soft box that faces the middle of the room.
 * @param {number[]} at @param {number[]} size @param {number[]} colour @param {number} power
 */
function softbox(at, size, colour, power) {
  const away = normalised(at);
  const across = normalised(cross(Math.abs(away[1]) > 0.999 ? [0, 0, 1] : [0, 1, 0], away));
  const half = size.map((s) => s / 2);
  const distance = Math.hypot(...at);
  return {
    away,
    across,
    up: cross(away, across),
    half,
    distance,
    // No direction further from its middle than this meets it, or the soft edge around it.
    cosine: distance / Math.hypot(distance, half[0] + distance * EDGE, half[1] + distance * EDGE),
    colour: colour.map((c) => c * power),
  };
}

const BOXES = [
  softbox([-4.6, 3.1, 7.2], [3.6, 4.2], [1, 0.96, 0.9], 10),
  softbox([7.5, 1.5, 4.5], [3.2, 6], [0.92, 0.96, 1], 2.2),
  softbox([0, 9.5, 0], [9, 9], [1, 1, 1], 1.5),
  softbox([6, 3, -7], [2.5, 7], [1, 0.97, 0.93], 5),
  softbox([-7, 2, -6], [2.5, 7], [0.9, 0.95, 1], 4),
  softbox([0, -9, 2], [12, 12], [1, 0.9, 0.82], 0.45),
];

/**
 * What is seen in a direction, into `seen`. No box stands before another.
 * @param {number[]} way of length 1 @param {number[]} seen
 */
function radiance(way, seen) {
  for (let k = 0; k < 3; k++) seen[k] = WALL[k];
  for (const box of BOXES) {
    const cosine = dot(way, box.away);
    if (cosine < box.cosine) continue;
    const t = box.distance / cosine;
    const soft = t * EDGE;
    const across = Math.min(1, Math.max(0, (box.half[0] - Math.abs(t * dot(way, box.across))) / soft + 0.5));
    const along = Math.min(1, Math.max(0, (box.half[1] - Math.abs(t * dot(way, box.up))) / soft + 0.5));
    for (let k = 0; k < 3; k++) seen[k] += (box.colour[k] - seen[k]) * across * along;
  }
}

/**
 * The direction of each face's middle, of its columns and of its rows; three.js mirrors x for cube
 * maps.
 */
const FACES = [
  [-1, 0, 0, 0, 0, -1, 0, -1, 0],
  [1, 0, 0, 0, 0, 1, 0, -1, 0],
  [0, 1, 0, -1, 0, 0, 0, 0, 1],
  [0, -1, 0, -1, 0, 0, 0, 0, -1],
  [0, 0, 1, -1, 0, 0, 0, -1, 0],
  [0, 0, -1, 1, 0, 0, 0, -1, 0],
];

/** One level: six faces of `size` x `size` texels, red, green and blue. @typedef {{ size: number, faces: Float32Array[] }} Level */

/**
 * @param {number} size
 * @param {(way: number[], colour: number[], square: number) => void} look writes the colour of a
 *   direction; `square` is the square of the texel's distance from the middle of the cube
 * @returns {Level}
 */
function level(size, look) {
  const way = [0, 0, 0];
  const colour = [0, 0, 0];
  const faces = FACES.map((axes) => {
    const texels = new Float32Array(3 * size * size);
    for (let j = 0, o = 0; j < size; j++) {
      const t = (2 * j + 1) / size - 1;
      for (let i = 0; i < size; i++, o += 3) {
        const s = (2 * i + 1) / size - 1;
        const square = 1 + s * s + t * t;
        const length = Math.sqrt(square);
        for (let k = 0; k < 3; k++) way[k] = (axes[k] + s * axes[3 + k] + t * axes[6 + k]) / length;
        look(way, colour, square);
        texels[o] = colour[0];
        texels[o + 1] = colour[1];
        texels[o + 2] = colour[2];
      }
    }
    return texels;
  });
  return { size, faces };
}

/** Half the size, each texel the mean of four. @param {Level} from @returns {Level} */
function halved({ size, faces }) {
  const half = size / 2;
  return {
    size: half,
    faces: faces.map((texels) => {
      const mean = new Float32Array(3 * half * half);
      for (let at = 0; at < mean.length; at++) {
        const pixel = (at / 3) | 0;
        const o = 3 * (2 * ((pixel / half) | 0) * size + 2 * (pixel % half)) + (at % 3);
        mean[at] = (texels[o] + texels[o + 3] + texels[o + 3 * size] + texels[o + 3 * size + 3]) / 4;
      }
      return mean;
    }),
  };
}

/**
 * Adds what a level has in a direction, between its texels.
 * @param {number[]} sum @param {number} weight @param {Level} level
 * @param {number} x @param {number} y @param {number} z
 */
function read(sum, weight, { size, faces }, x, y, z) {
  const ax = Math.abs(x);
  const ay = Math.abs(y);
  const az = Math.abs(z);
  let face;
  let s;
  let t;
  if (ax >= ay && ax >= az) {
    face = x < 0 ? 0 : 1;
    s = (x < 0 ? -z : z) / ax;
    t = -y / ax;
  } else if (ay >= az) {
    face = y > 0 ? 2 : 3;
    s = -x / ay;
    t = (y > 0 ? z : -z) / ay;
  } else {
    face = z > 0 ? 4 : 5;
    s = (z > 0 ? -x : x) / az;
    t = -y / az;
  }
  const texels = faces[face];
  const i = Math.min(size - 1, Math.max(0, (s + 1) * 0.5 * size - 0.5));
  const j = Math.min(size - 1, Math.max(0, (t + 1) * 0.5 * size - 0.5));
  const left = Math.min(size - 2, i | 0);
  const top = Math.min(size - 2, j | 0);
  const u = i - left;
  const v = j - top;
  const o = 3 * (top * size + left);
  for (let k = 0; k < 3; k++) {
    const above = texels[o + k] + (texels[o + 3 + k] - texels[o + k]) * u;
    const p = o + 3 * size + k;
    const below = texels[p] + (texels[p + 3] - texels[p]) * u;
    sum[k] += weight * (above + (below - above) * v);
  }
}

/** Writes what a surface mirrors that faces a direction. @typedef {(way: number[], colour: number[]) => void} Mirror */

/**
 * A surface of some roughness: the GGX lobe around each direction, as three.js has it (the view along the
 * normal, weighted with the cosine), by samples.
 * @param {number} roughness @param {Level[]} sharp the room at all sizes
 * @returns {Mirror}
 */
function glossy(roughness, sharp) {
  const alpha2 = roughness ** 4;
  // The sharper, the smaller the lobe, and the more texels there are to fill.
  const samples = roughness < 0.2 ? 16 : 64;
  // Each sample reads a level whose texels are as large as what it stands for.
  const lobe = Array.from({ length: samples }, (_, i) => {
    const x = (i + 0.5) / samples;
    const inverse = 1 / (1 - x + alpha2 * x);
    const cosine = (1 - x - alpha2 * x) * inverse;
    const turn = i * 2.399963229728653;
    const sine = Math.sqrt(Math.max(0, 1 - cosine * cosine));
    const stands = (4 * Math.PI * alpha2 * inverse * inverse) / samples;
    const texels = Math.sqrt(stands / ((4 * Math.PI) / (6 * SIZE * SIZE)));
    const from = sharp[Math.max(0, Math.min(sharp.length - 1, Math.round(Math.log2(texels))))];
    return { cosine, x: sine * Math.cos(turn), y: sine * Math.sin(turn), from };
  }).filter(({ cosine }) => cosine > 0);
  const total = lobe.reduce((sum, { cosine }) => sum + cosine, 0);
  return (n, colour) => {
    // Any two directions across: the lobe is round.
    const [ux, uy, uz] = Math.abs(n[2]) < 0.9 ? [-n[1], n[0], 0] : [0, -n[2], n[1]];
    const long = Math.sqrt(ux * ux + uy * uy + uz * uz);
    const u = [ux / long, uy / long, uz / long];
    const v = cross(n, u);
    colour.fill(0);
    for (const { cosine, x, y, from } of lobe) {
      read(
        colour,
        cosine / total,
        from,
        n[0] * cosine + u[0] * x + v[0] * y,
        n[1] * cosine + u[1] * x + v[1] * y,
        n[2] * cosine + u[2] * x + v[2] * y,
      );
    }
  };
}

/**
 * The same for a rough surface, whose lobe is wide: every texel of a small level counts.
 * @param {number} roughness @param {Level} from
 * @returns {Mirror}
 */
function matt(roughness, from) {
  const alpha2 = roughness ** 4;
  /** Direction, solid angle, colour of each texel, seven numbers each. @type {number[]} */
  const lights = [];
  let texel = 0;
  level(from.size, (way, _, square) => {
    const o = 3 * (texel % from.size ** 2);
    const colour = from.faces[Math.floor(texel / from.size ** 2)].subarray(o, o + 3);
    lights.push(...way, square ** -1.5, ...colour);
    texel += 1;
  });
  const list = Float32Array.from(lights);
  return ([x, y, z], colour) => {
    let red = 0;
    let green = 0;
    let blue = 0;
    let total = 0;
    for (let o = 0; o < list.length; o += 7) {
      const cosine = x * list[o] + y * list[o + 1] + z * list[o + 2];
      if (cosine <= 0) continue;
      // The half vector lies at half the angle.
      const spread = (0.5 + 0.5 * cosine) * (alpha2 - 1) + 1;
      const weight = (cosine * list[o + 3]) / (spread * spread);
      red += weight * list[o + 4];
      green += weight * list[o + 5];
      blue += weight * list[o + 6];
      total += weight;
    }
    colour[0] = red / total;
    colour[1] = green / total;
    colour[2] = blue / total;
  };
}

/** @param {number} roughness @param {Level[]} sharp the room at all sizes */
const mirror = (roughness, sharp) => (roughness < 0.45 ? glossy(roughness, sharp) : matt(roughness, sharp[3]));

/** Texels along a side of `folded`, the first and the last on its edge. */
const FOLDED = 32;
/** What `folded` has, from a shine to a sheen. */
const FOLDED_ROUGHNESS = [0.33, 0.62];

/**
 * What surfaces of two roughnesses mirror, one square below the other, each an octahedron around the head
 * that is folded flat: up is in the middle, down in all four corners. Square roots, as bytes, of parts of `brightest`.
 * Skin is never so sharp a mirror that it needs more, and a lookup here costs a third of one in a cube
 * map of all roughnesses where a processor draws.
 * @param {Level[]} sharp
 */
function folded(sharp) {
  const colours = new Float32Array(3 * FOLDED * FOLDED * FOLDED_ROUGHNESS.length);
  const colour = [0, 0, 0];
  FOLDED_ROUGHNESS.forEach((roughness, at) => {
    const look = mirror(roughness, sharp);
    for (let j = 0, o = 3 * at * FOLDED * FOLDED; j < FOLDED; j++) {
      for (let i = 0; i < FOLDED; i++, o += 3) {
        let x = (2 * i) / (FOLDED - 1) - 1;
        let z = (2 * j) / (FOLDED - 1) - 1;
        const y = 1 - Math.abs(x) - Math.abs(z);
        if (y < 0) [x, z] = [(1 - Math.abs(z)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (z < 0 ? -1 : 1)];
        look(normalised([x, y, z]), colour);
        colours.set(colour, o);
      }
    }
  });
  const brightest = colours.reduce((most, c) => Math.max(most, c), 0);
  const texels = new Uint8Array((colours.length / 3) * 4).fill(255);
  colours.forEach((c, o) => {
    texels[4 * Math.floor(o / 3) + (o % 3)] = Math.round(255 * Math.sqrt(c / brightest));
  });
  return { texels, side: FOLDED, roughness: FOLDED_ROUGHNESS, brightest };
}

/**
 * What a rough surface gets from each side, which is so smooth that polynomials of the second degree in
 * the direction have it: spherical harmonics, their constants multiplied in. Colours of 1, y, z, x, xy, yz,
 * 3zz - 1, xz, xx - yy.
 * @param {Level} rough
 */
function harmonics({ size, faces }) {
  const light = new Float32Array(27);
  // Of the solid angle that texels have; their number is right up to a constant, which is divided out.
  let whole = 0;
  let texel = 0;
  level(size, ([x, y, z], _, square) => {
    const angle = square ** -1.5;
    const values = [1, y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y];
    const o = 3 * (texel % size ** 2);
    const texels = faces[Math.floor(texel / size ** 2)];
    for (let i = 0; i < 9; i++) {
      for (let k = 0; k < 3; k++) light[3 * i + k] += angle * NORMS[i] * values[i] * texels[o + k];
    }
    whole += angle;
    texel += 1;
  });
  return light.map((sum) => sum / whole);
}

/** One over the mean square, over the sphere, of each polynomial of `harmonics`. */
const NORMS = [1, 3, 3, 3, 15, 15, 5 / 4, 15, 15 / 4];

/**
 * The studio, prefiltered as three.js expects it of an environment: from what a mirror shows to what lights
 * a rough surface; the latter also as polynomials, and what skin mirrors as a flat map.
 * @returns {{ levels: Level[], light: Float32Array<ArrayBuffer>, flat: ReturnType<typeof folded> }}
 */
export function studio() {
  const sharp = [level(SIZE, radiance)];
  while (sharp[sharp.length - 1].size > 4) sharp.push(halved(sharp[sharp.length - 1]));
  const levels = sharp.map((present, lod) => {
    if (lod === 0) return present;
    // Which level stands for which roughness is three.js's. One below the roughest tells it how many
    // there are, and has nothing new.
    const roughness = 1 - Math.sqrt(1 - Math.min(1, lod / (LEVELS - 1)));
    return level(present.size, mirror(roughness, sharp));
  });
  return { levels, light: harmonics(levels[LEVELS - 1]), flat: folded(sharp) };
}
