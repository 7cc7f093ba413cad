import { Color, Vector3, Vector4 } from 'three';
import { smoothstep } from '../groundwork/paint.js';
import { KINDS, marksOf, MOST } from './marks.js';

// How marks of the skin are drawn: by the skin's shader, from where they are on the head at rest, so that they are as sharp as one looks and
// go where the skin does.

// What marks take from light, red, green and blue: melanin, most of blue, and vessels, most of green.
const MELANIN = [0.67, 0.8, 0.98];
const BROWN = [0.52, 0.68, 0.84];
const WINE = [0.3, 1.05, 0.86];
// What scars are like, linear: there is no melanin in them; then as red as the blood that is.
const PALE = [0.82, 0.62, 0.53];
const PINK = [0.66, 0.26, 0.24];
const RED = [0.42, 0.09, 0.09];
/** Deep skin has deeper scars: how much of their colours the deepest has, and from which green on they are whole. */
const DEEP = [0.22, 0.4];
/** How much of a scar's colour it has. */
const LIKE = 0.5;

/** How much melanin a mole has. @param {number} tone */
const depthOf = (tone) => tone * (0.25 + 1.9 * tone);

const between = (/** @type {number[]} */ a, /** @type {number[]} */ b, /** @type {number} */ t) => a.map((from, k) => from + (b[k] - from) * t);
/**
 * About what colour a mark has on a skin.
 * @param {import('./marks.js').Kind} kind @param {number} tone @param {Color} skin linear
 */
export function markColour(kind, tone, skin) {
  const [r, g, b] = skin.toArray().map((own, k) => {
    if (kind === 'scar') {
      const like = tone < 0.5 ? between(PALE, PINK, 2 * tone) : between(PINK, RED, 2 * tone - 1);
      return own ** (1 - LIKE) * (like[k] * (DEEP[0] + (1 - DEEP[0]) * smoothstep(0, DEEP[1], skin.g))) ** LIKE;
    }
    return own * Math.exp(kind === 'mole' ? -depthOf(tone) * MELANIN[k] : -between(BROWN, WINE, tone)[k]);
  });
  return new Color(r, g, b);
}

const vec3 = (/** @type {number[]} */ numbers) => `vec3(${numbers.map((x) => x.toFixed(3)).join(', ')})`;

/** Of the lamp that shines most, in the head's axes: what stands out of the skin has a shadow. */
const KEY = '-0.4615, 0.5035, 0.7273';

/**
 * Declarations of the skin's shader beside its own. `findMarks` sets the variables, by which the skin is changed.
 */
const GLSL = /* glsl */ `
  uniform int markCount;
  uniform vec4 markAround[${MOST}]; // all of it is in this sphere
  uniform vec4 markAt[${MOST}]; // where it is or begins; half of how large it is; mm
  uniform vec4 markTo[${MOST}]; // where a scar ends; a number of its own
  uniform vec4 markUp[${MOST}]; // the way out of the skin; its kind
  uniform vec3 markSide[${MOST}]; // the way across a scar
  uniform vec3 markLook[${MOST}]; // tone, form, strength
  vec3 markTake; // what is left of light that goes through it
  vec4 markTint; // which colour it is like, and how much
  vec3 markSlope;
  float markSmooth; // how little there is of pores
  float markBald; // and of hairs
  float markShade; // how much of the lamp it hides

  float markChance(vec3 at) {
    at = fract(at * vec3(0.1031, 0.1030, 0.0973));
    at += dot(at, at.yzx + 33.33);
    return fract((at.x + at.y) * at.z);
  }
  float markNoise(vec3 at) {
    vec3 cell = floor(at);
    vec3 within = at - cell;
    within *= within * (3.0 - 2.0 * within);
    vec2 next = vec2(0.0, 1.0);
    vec4 near = vec4(markChance(cell), markChance(cell + next.yxx), markChance(cell + next.xyx), markChance(cell + next.yyx));
    vec4 far = vec4(markChance(cell + next.xxy), markChance(cell + next.yxy), markChance(cell + next.xyy), markChance(cell + next.yyy));
    vec4 layer = mix(near, far, within.z);
    vec2 line = mix(layer.xy, layer.zw, within.y);
    return mix(line.x, line.y, within.x);
  }

  void mole(int i) {
    vec3 away = vRest - markAt[i].xyz;
    vec3 up = markUp[i].xyz;
    vec3 look = markLook[i];
    float size = markAt[i].w;
    float own = markTo[i].w;
    vec3 across = away - dot(away, up) * up;
    // No two are round alike.
    vec3 there = away / size + 61.0 * own;
    float uneven = markNoise(1.3 * there);
    float fine = markNoise(4.1 * there);
    float far = length(across) / size * (0.9 + 0.24 * uneven) + 0.06 * (fine - 0.5);
    float soft = clamp(0.22 / size, 0.1, 0.5) + 0.1 * look.y;
    float cover = look.z * smoothstep(1.0 + soft, 1.0 - soft, far);
    // Melanin, more of it in places. What has hardly any has a little more blood than the skin.
    float deep = look.x * (0.25 + 1.9 * look.x) * (0.72 + 0.35 * uneven + 0.3 * fine + 0.2 * (1.0 - far * far));
    markTake *= exp(-cover * (deep * ${vec3(MELANIN)} + (1.0 - look.x) * vec3(0.0, 0.1, 0.1)));
    float raised = look.y * look.z;
    if (raised > 0.0) {
      float inside = max(0.0, 1.0 - far * far);
      vec3 outward = across / max(length(across), 0.001);
      // A dome, which is not smooth.
      markSlope -= outward * raised * 2.3 * far * inside;
      markSlope += raised * inside * 0.5 * (vec3(fine, markNoise(4.1 * there.zxy + 7.0), markNoise(4.1 * there.yzx + 3.0)) - 0.5);
      // It is dark where it leaves the skin, and on the side that no lamp shines on.
      markTake *= 1.0 - 0.2 * raised * smoothstep(0.6, 1.0, far) * smoothstep(1.5, 1.0, far);
      vec3 lamp = vec3(${KEY});
      vec3 shaded = across + (lamp - dot(lamp, up) * up) * size * 0.75 * raised;
      markShade = max(markShade, raised * smoothstep(1.15, 0.55, length(shaded) / size) * smoothstep(0.75, 1.05, far));
      markSmooth = max(markSmooth, 0.6 * raised * cover);
    }
    markBald = max(markBald, 0.7 * cover);
  }

  void scar(int i) {
    vec3 away = vRest - markAt[i].xyz;
    vec3 way = markTo[i].xyz - markAt[i].xyz;
    vec3 side = markSide[i];
    vec3 look = markLook[i];
    float size = markAt[i].w;
    float own = markTo[i].w;
    float whole = max(length(way), 0.1);
    way /= whole;
    // Where it is seen from above: on a skin that is round its middle is higher than its ends.
    float along = dot(away, way);
    float beside = dot(away, side);
    float bend = markNoise(vec3(0.22 * along, 57.0 * own, 0.0)) - 0.5;
    float uneven = markNoise(vec3(0.8 * along, 31.0 * own, 5.0));
    float fine = markNoise(vec3(1.9 * along, 2.5 * beside, 17.0 * own));
    beside += bend * (0.5 + 0.9 * size);
    float end_ = smoothstep(0.0, 1.0, min(along, whole - along) / min(0.5 * whole, 2.0 + 2.5 * size));
    float half_ = size * (0.25 + 0.75 * sqrt(end_)) * (0.7 + 0.6 * uneven);
    float far = abs(beside) / half_;
    float shown = look.z * smoothstep(0.0, 0.12, end_);
    float soft = clamp(0.25 / half_, 0.15, 0.6);
    float cover = shown * smoothstep(1.0 + soft, 1.0 - soft, far + 0.3 * (fine - 0.5));
    vec3 like = look.x < 0.5 ? mix(${vec3(PALE)}, ${vec3(PINK)}, 2.0 * look.x) : mix(${vec3(PINK)}, ${vec3(RED)}, 2.0 * look.x - 1.0);
    float much = cover * ${LIKE} * (0.8 + 0.4 * fine);
    markTint = vec4(mix(markTint.rgb, like, much > 0.0 ? much / max(much, markTint.a + much * (1.0 - markTint.a)) : 0.0), markTint.a + much * (1.0 - markTint.a));
    // Around what is fresh the skin is red.
    markTake *= 1.0 - vec3(0.02, 0.2, 0.17) * shown * look.x * smoothstep(2.6, 0.8, abs(beside) / size);
    float height = 2.0 * look.y - 1.0;
    float inside = max(0.0, 1.0 - far * far);
    markSlope -= side * sign(beside) * shown * height * 1.7 * far * inside * (0.6 + 0.7 * uneven);
    markSlope += way * cover * height * 0.5 * (fine - 0.5);
    markTake *= 1.0 - 0.22 * shown * max(0.0, -height) * inside;
    markSmooth = max(markSmooth, 0.8 * cover);
    markBald = max(markBald, shown * smoothstep(1.7, 1.1, far));
  }

  void birthmark(int i, float facing) {
    vec3 away = vRest - markAt[i].xyz;
    vec3 look = markLook[i];
    float size = markAt[i].w;
    float own = markTo[i].w;
    float far = length(away) / size;
    vec3 there = away / size + 40.0 * look.y + 7.0 * own;
    float broadly = markNoise(1.4 * there);
    float uneven = markNoise(3.6 * there);
    float fine = markNoise(9.5 * there);
    float finest = markNoise(0.9 * vRest + own);
    float edge = far + 0.9 * (broadly - 0.5) + 0.5 * (uneven - 0.5) + 0.24 * (fine - 0.5) + 0.1 * (finest - 0.5);
    float soft = 0.06 + min(0.2, 1.4 / size);
    // What lies behind a thin place, as lips and ears are, is another skin.
    float cover = look.z * smoothstep(0.82 + soft, 0.82 - soft, edge) * smoothstep(-0.5, 0.0, facing);
    vec3 taken = mix(${vec3(BROWN)}, ${vec3(WINE)}, look.x);
    markTake *= exp(-cover * taken * (0.72 + 0.3 * uneven + 0.26 * fine + 0.16 * finest));
  }

  void findMarks() {
    markTake = vec3(1.0);
    markTint = vec4(0.0);
    markSlope = vec3(0.0);
    markSmooth = markBald = markShade = 0.0;
    vec3 out_ = normalize(vRestNormal);
    // The nearest of each kind, in its own sizes: a processor that draws does all of a branch for each pixel, whether it is taken or not, and
    // would do the work of a dozen. Of two that overlap each has what is nearer to it.
    ivec3 nearest = ivec3(-1);
    vec3 least = vec3(1e6);
    for (int i = 0; i < markCount; i++) {
      vec3 off = vRest - markAround[i].xyz;
      vec3 away = vRest - markAt[i].xyz;
      vec3 way = markTo[i].xyz - markAt[i].xyz;
      float kind = markUp[i].w;
      bool isScar = kind > 0.5 && kind < 1.5;
      bool isStain = kind > 1.5;
      float along = dot(away, way);
      bool isIn = dot(off, off) < markAround[i].w * markAround[i].w && (isStain || dot(out_, markUp[i].xyz) > 0.1) && (!isScar || (along > 0.0 && along < dot(way, way)));
      float far = (isScar ? abs(dot(away, markSide[i])) : length(away)) / markAt[i].w;
      bvec3 isNearer = bvec3(isIn && !isScar && !isStain && far < least.x, isIn && isScar && far < least.y, isIn && isStain && far < least.z);
      least = mix(least, vec3(far), vec3(isNearer));
      nearest = ivec3(isNearer.x ? i : nearest.x, isNearer.y ? i : nearest.y, isNearer.z ? i : nearest.z);
    }
    if (nearest.z >= 0) birthmark(nearest.z, dot(out_, markUp[nearest.z].xyz));
    if (nearest.y >= 0) scar(nearest.y);
    if (nearest.x >= 0) mole(nearest.x);
  }
  vec3 withMarks(vec3 tone) {
    // Some light comes back from the surface, whatever is below.
    vec3 surface = min(vec3(0.012, 0.008, 0.006), 0.5 * tone);
    tone = surface + (tone - surface) * markTake;
    if (markTint.a == 0.0) return tone;
    vec3 like = markTint.rgb * mix(${DEEP[0]}, 1.0, smoothstep(0.0, ${DEEP[1]}, tone.g));
    // As the eye goes from one colour to another.
    return pow(max(tone, 0.0), vec3(1.0 - markTint.a)) * pow(max(like, 0.01), vec3(markTint.a));
  }
`;

/**
 * A place on the skin of a face.
 * @param {Uint32Array} triangles @param {ArrayLike<number>} values 3 a vertex
 * @param {import('./marks.js').Place} place @param {Vector3} out
 */
export function placed(triangles, values, { triangle, b, c }, out) {
  out.set(0, 0, 0);
  [255 - b - c, b, c].forEach((weight, k) => {
    const o = 3 * triangles[3 * triangle + k];
    out.x += (weight / 255) * values[o];
    out.y += (weight / 255) * values[o + 1];
    out.z += (weight / 255) * values[o + 2];
  });
  return out;
}

/**
 * The place that is nearest to a point.
 * @param {Uint32Array} triangles @param {ArrayLike<number>} positions @param {Vector3} point mm
 * @returns {import('./marks.js').Place}
 */
export function placeNear(triangles, positions, point) {
  let least = Infinity;
  let best = { triangle: 0, b: 0, c: 0 };
  const [a, b, c, p] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];
  for (let t = 0; 3 * t < triangles.length; t++) {
    a.fromArray(positions, 3 * triangles[3 * t]);
    // No triangle is that large.
    if (Math.abs(a.x - point.x) > 25 || Math.abs(a.y - point.y) > 25 || Math.abs(a.z - point.z) > 25) continue;
    b.fromArray(positions, 3 * triangles[3 * t + 1]).sub(a);
    c.fromArray(positions, 3 * triangles[3 * t + 2]).sub(a);
    p.copy(point).sub(a);
    const [bb, bc, cc, pb, pc] = [b.dot(b), b.dot(c), c.dot(c), p.dot(b), p.dot(c)];
    const area = bb * cc - bc * bc;
    if (area <= 0) continue;
    // Where it is above the triangle, or near to that on its edge: the point is on one of them.
    let v = Math.min(1, Math.max(0, (cc * pb - bc * pc) / area));
    let w = Math.min(1, Math.max(0, (bb * pc - bc * pb) / area));
    if (v + w > 1) [v, w] = [v / (v + w), w / (v + w)];
    const far = p.addScaledVector(b, -v).addScaledVector(c, -w).lengthSq();
    if (far >= least) continue;
    least = far;
    const second = Math.round(255 * v);
    best = { triangle: t, b: second, c: Math.min(255 - second, Math.round(255 * w)) };
  }
  return best;
}

/** A number from 0 to 1 that a place always has. @param {import('./marks.js').Place} place */
const ownOf = ({ triangle }) => (triangle * 0.6180339887498949) % 1;

/** Where nothing grows: from where to where, and half as wide as it is, mm. @typedef {readonly [number, number, number, number, number, number, number]} Bald */

/**
 * Draws marks on a head.
 * @param {{ positions: ArrayLike<number>, normals: ArrayLike<number>, triangles: Uint32Array }} skin at rest
 */
export function createMarking({ positions, normals, triangles }) {
  const four = () => ({ value: Array.from({ length: MOST }, () => new Vector4()) });
  const three = () => ({ value: Array.from({ length: MOST }, () => new Vector3()) });
  const uniforms = { markCount: { value: 0 }, markAround: four(), markAt: four(), markTo: four(), markUp: four(), markSide: three(), markLook: three() };
  const [at, to, up, there] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];
  /** @param {import('./marks.js').Place | undefined} place */
  const isThere = (place) => !place || 3 * place.triangle < triangles.length;
  return {
    glsl: GLSL,
    uniforms,
    /**
     * @param {{ readonly marks?: string }} colouring whose marks are drawn from now on: those that are on this mesh
     * @returns {Bald[]} where hairs are missing
     */
    lay(colouring) {
      const marks = marksOf(colouring).filter((mark) => isThere(mark.at) && isThere(mark.to));
      uniforms.markCount.value = marks.length;
      return marks.flatMap(({ kind, at: begin, to: end, size, tone, form, strength }, i) => {
        placed(triangles, positions, begin, at);
        placed(triangles, normals, begin, up).normalize();
        if (end) {
          placed(triangles, positions, end, to);
          up.add(placed(triangles, normals, end, there).normalize());
          // Seen from above the line between them.
          there.copy(to).sub(at);
          up.addScaledVector(there, -up.dot(there) / Math.max(1e-6, there.lengthSq())).normalize();
          uniforms.markSide.value[i].crossVectors(up, there).normalize();
        } else to.copy(at);
        const half = size / 2;
        if (end) uniforms.markAround.value[i].set((at.x + to.x) / 2, (at.y + to.y) / 2, (at.z + to.z) / 2, 0.65 * at.distanceTo(to) + 3 * half + 3);
        else uniforms.markAround.value[i].set(at.x, at.y, at.z, kind === 'mole' ? 2.2 * half + 1 : 1.7 * half);
        uniforms.markAt.value[i].set(at.x, at.y, at.z, half);
        uniforms.markTo.value[i].set(to.x, to.y, to.z, ownOf(begin));
        uniforms.markUp.value[i].set(up.x, up.y, up.z, KINDS.indexOf(kind));
        uniforms.markLook.value[i].set(tone, form, strength);
        // What has faded away half has its hairs.
        return kind === 'scar' && strength >= 0.5 ? [/** @type {Bald} */ ([...at.toArray(), ...to.toArray(), half])] : [];
      });
    },
  };
}

/** @typedef {ReturnType<typeof createMarking>} Marking */
