import {
  BufferAttribute, BufferGeometry, Color, DataTexture, DoubleSide, DynamicDrawUsage, FloatType, Mesh, MeshDepthMaterial, NearestFilter, RGBAFormat,
  ShaderMaterial, UniformsLib, UniformsUtils, Vector2, Vector3,
} from 'three';
import { fineness } from '../rendering/averaging.js';
import { backdropUniforms } from '../rendering/backdrop.js';
import { STUDIO_GLSL, studioUniforms } from '../rendering/environment.js';
import { drawnByProcessor } from '../rendering/graphics.js';
import { smoothstep } from '../groundwork/paint.js';
import { numberOf, SHORT } from './ribbons.js';
import { SCATTERED } from './scattered.js';
import { breadthOf, standingOf } from './standing.js';
import { ANCHORS, POINTS, shiftsOf } from './strands.js';

// Longer hair: each strand is a ribbon that turns to whoever looks, and some hairs are drawn on it.

/** How many of the strands are drawn: where a processor draws, fewer, which are broader. */
const share = () => (drawnByProcessor() ? 0.3 : 1);
/** How many are in files. */
const FILED = 0.5;
const filed = (/** @type {import('./plant.js').Planting} */ { strands }) => Math.round(FILED * strands);
/** How much broader a ribbon is where only so many are. @param {number} share */
const broader = (share) => share ** -0.7;
/** @typedef {ReturnType<typeof import('../head/pigments.js').pigments>} Pigments */

/** Hair that hardly bends is shorter, mm. */
const SHORTER = 45;

/**
 * Styles that are kept grown: two faces side by side are drawn in turn, and one of them changes; or four sit for their portraits between two
 * frames, and none of them pushes out that of the face on the stage.
 */
const KEPT = 6;

/** Of those so many on the graphics card, each in some megabytes: of two side by side one changes. */
const LOADED = 3;

/** What of a corner goes by its style, and in how many numbers. */
const STYLED = /** @type {const} */ ([['position', 3], ['course', 4], ['outward', 4]]);

/** How far beside a scar hairs are missing, mm: a root is a point, and its hairs are beside it. */
const ROOT = 0.3;

/** Of a hair that lies on the skin, its root and where it is half as long. */
const LYING = [0, POINTS / 2];

/** How far from its root a hair may begin, mm: those of a ribbon begin one after the other. */
const ROOTLESS = 4;

const PLACE = /* glsl */ `
  attribute vec4 course; // the way to the tip; which side, and by how much light gets there
  attribute vec4 outward; // the way out of the head, as long as it is broad; how far along
  attribute vec2 strand; // its lock, its own number
  uniform highp sampler2D lockShifts;
  uniform float halfWidth; // mm
  uniform float heatStrength;
  uniform float hides;
  vec3 strandAt() {
    float at = min(outward.w * ${(ANCHORS - 1).toFixed(1)}, ${(ANCHORS - 1.001).toFixed(3)});
    ivec2 lock = ivec2(int(strand.x), int(at));
    return position + mix(texelFetch(lockShifts, lock, 0).xyz, texelFetch(lockShifts, lock + ivec2(0, 1), 0).xyz, fract(at));
  }
  // What is measured is the head.
  bool strandHidden() { return max(heatStrength, hides) > 0.5; }
  // Half its width, mm: roots are close, and tips thin.
  float ribbon() { return halfWidth * length(outward.xyz) * (1.0 + 0.4 * max(0.0, 1.0 - 4.0 * outward.w)) * (1.0 - 0.95 * outward.w * outward.w); }
`;
// Ribbons lie over ribbons: what can be is done once a corner, tone mapping among it, and little is left for each pixel.
/** Of how many of a ribbon's hairs have turned grey its number times the first tells, which has a fraction of its own; and how far ribbons differ in that. */
const TURNS = 43.7;
const UNLIKE = 1.6;

const VERTEX = /* glsl */ `
  #include <common>
  #include <lights_pars_begin>
  #include <tonemapping_pars_fragment>
  ${STUDIO_GLSL}
  ${PLACE}
  uniform vec2 backdropSize;
  uniform vec2 fade;
  uniform vec3 young;
  uniform vec3 old;
  uniform float turned;
  uniform float gloss;
  uniform float gaps;
  uniform float thin;
  uniform vec3 skin;
  uniform float fineness;
  varying vec3 vColour;
  varying vec3 vGrey; // of its hairs that have turned
  varying vec3 vShine;
  varying vec4 vHair; // across, along, its own number, the neck's fading
  varying vec3 vSeen; // how far its hairs are told from each other, how much of it they fill, how many are grey
  vec3 onScreen(vec3 light) {
    vec3 mapped = ACESFilmicToneMapping(light);
    return mix(pow(mapped, vec3(0.41666)) * 1.055 - 0.055, mapped * 12.92, vec3(lessThanEqual(mapped, vec3(0.0031308))));
  }
  ${SCATTERED}
  void main() {
    vec3 at = strandAt();
    vec4 view = modelViewMatrix * vec4(at, 1.0);
    vec3 toEye = normalize(-view.xyz);
    vec3 along = normalize(normalMatrix * course.xyz);
    vec3 normal = normalize(normalMatrix * outward.xyz);

    float tip = outward.w;
    float under = abs(course.w); // 1 is open to the light
    // Hairs turn grey one after the other, here sooner and there later.
    float grey = turned + ${UNLIKE} * turned * (1.0 - turned) * (fract(strand.y * ${TURNS}) - 0.5);
    vec3 own = mix(young, old, grey);
    float shade = (0.88 + 0.24 * fract(strand.y * 57.0)) * mix(0.85, 1.0, smoothstep(0.0, 0.5, tip));
    // Less light gets to the roots, and below other hair.
    float open = mix(0.45, 1.0, under) * mix(0.8, 1.0, smoothstep(0.0, 0.4, tip));
    // Hairs of a ribbon lie side by side where they are told from each other, and close where they are not. Of those that are drawn
    // broader than they are, the skin between them takes its part.
    float pixel = -2.0 * view.z / (projectionMatrix[1][1] * backdropSize.y * fineness);
    float apart = ribbon() / (1.0 - gaps);
    float seen = 1.0 - smoothstep(0.4, 1.1, 2.0 * pixel / apart);
    float room = mix(ribbon(), apart, seen);
    float drawn = max(room, 0.6 * pixel);
    float fill = min(1.0, max(ribbon(), 1.4 * seen * pixel) / room);
    vSeen = vec3(seen, fill, grey);
    float cover = mix(1.0, ribbon() / (drawn * fill), thin);
    vec3 dark = mix(skin, scattered(young) * shade, cover);
    vec3 white = mix(skin, scattered(old) * shade, cover);
    vec3 hair = mix(dark, white, grey);
    vec3 comes = studioLightOn(normalize(outward.xyz)) * 0.62 * open;
    vec3 shine = vec3(0.0);
    vec3 sheen = vec3(0.0);
    // Locks lie at angles of their own, or all would shine in one line.
    float tilt = 0.3 * (fract(strand.x * 0.7548776662) - 0.5);
    for (int i = 0; i < NUM_DIR_LIGHTS; i++) {
      vec3 light = directionalLights[i].direction;
      float lit = saturate((dot(normal, light) + 0.35) / 1.35);
      float sine = sqrt(max(0.0, 1.0 - pow2(dot(along, light))));
      vec3 sent = directionalLights[i].color * lit * open;
      comes += RECIPROCAL_PI * mix(1.0, sine, 0.6) * sent;
      // From the surface of hairs, and light that went through and comes back in their colour, each to its side (Kajiya
      // and Kay 1989; the shifts are Marschner's, 2003).
      vec3 halfway = normalize(light + toEye);
      float first = dot(normalize(along + (0.05 + 0.06 * fract(strand.y * 91.0) + tilt) * normal), halfway);
      float second = dot(normalize(along - (0.12 - tilt) * normal), halfway);
      shine += sent * pow(max(0.0, 1.0 - first * first), 45.0) * 0.08;
      shine += sent * pow(hair, vec3(0.6)) * pow(max(0.0, 1.0 - second * second), 9.0) * 0.2 * (1.0 - 0.7 * own.r);
      // Short hairs point everywhere: together they shine as what they grow on is rounded.
      sheen += sent * pow(saturate(dot(normal, halfway)), 5.0) * 0.035;
    }
    vColour = onScreen(comes * dark);
    vGrey = turned > 0.0 ? onScreen(comes * white) : vColour;
    vec3 sum = comes * hair;
    vShine = onScreen(sum + cover * mix(sheen, shine, gloss)) - (turned > 0.0 ? onScreen(sum) : vColour);

    vec3 across = cross(along, toEye);
    view.xyz += across / max(0.2, length(across)) * sign(course.w) * drawn;
    vHair = vec4(sign(course.w), tip, strand.y, smoothstep(fade.x, fade.y, at.y));
    gl_Position = strandHidden() ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * view;
  }
`;
const FRAGMENT = /* glsl */ `
  varying vec3 vColour;
  varying vec3 vGrey;
  varying vec3 vShine;
  varying vec4 vHair;
  varying vec3 vSeen;
  uniform float rootless;
  void main() {
    // Hairs of a ribbon begin and end one after the other. Gaps that are smaller than a pixel would be specks.
    float across = (0.5 + 0.5 * vHair.x) * 4.0;
    float own = fract(fract(vHair.z * 113.5 + floor(across) * 0.618) * 57.31);
    float end = 1.0 - 0.45 * own;
    float wide = vSeen.y * mix(1.0, 1.05 - smoothstep(end - 0.45, end, vHair.y), vSeen.x);
    float beside = (1.0 - vSeen.y) * (fract(own * 23.7) - 0.5);
    if (abs(fract(across) - 0.5 - beside) * 2.0 > wide || (vHair.y > end && vSeen.x > 0.5) || vHair.y < rootless * fract(own * 7.3)) discard;
    // Where the neck runs out, hairs end one by one.
    if (vHair.w < 0.1 + 0.9 * fract(vHair.z * 31.0)) discard;
    own = mix(0.5, own, max(0.5, vSeen.x));
    // From afar hairs of both colours are one between.
    float grey = mix(vSeen.z, step(fract(vHair.z * 71.3 + floor(across) * 0.618), vSeen.z), vSeen.x);
    vec3 shown = mix(vColour, vGrey, grey) * (0.68 + 0.64 * own) + vShine * (0.5 + own);
    gl_FragColor = vec4(shown, 1.0);
  }
`;

/**
 * Whether a point is on a scar.
 * @param {readonly import('../head/marking.js').Bald[]} scars @param {ArrayLike<number>} position @param {number} o where it begins
 */
function isBald(scars, position, o) {
  return scars.some(([ax, ay, az, bx, by, bz, half]) => {
    const [wx, wy, wz] = [bx - ax, by - ay, bz - az];
    const [x, y, z] = [position[o] - ax, position[o + 1] - ay, position[o + 2] - az];
    const t = Math.min(1, Math.max(0, (x * wx + y * wy + z * wz) / Math.max(0.01, wx * wx + wy * wy + wz * wz)));
    // A long one lies over a skin that is round.
    const reach = half + ROOT + 0.1 * Math.hypot(wx, wy, wz) * 4 * t * (1 - t);
    return Math.hypot(x - t * wx, y - t * wy, z - t * wz) < reach;
  });
}

/**
 * Hair of one kind that is longer than a crop.
 *
 * @template {import('./plant.js').Kind} K
 * @template {import('./plant.js').Styles[K]} S
 * @param {{
 *   kind: K, style: (colours: Pigments) => S, thinning: (colours: Pigments) => import('./standing.js').Thinning, long: (style: S) => number, half: number, stride?: (style: S) => number,
 *   gaps?: number, bare?: number, carries?: (colours: Pigments) => number,
 * }} of `half` of a ribbon's width, mm; of the points of a strand every `stride`th is in files, in which each is once more
 *   for every slider, and none where there is no `stride`;
 *   `gaps`: how much of a ribbon's breadth is between its hairs; `bare`: how much of the skin is seen between hairs, however many there are;
 *   `carries`: how far it stands for what is painted of it
 * @param {{ grower: import('./grower.js').Grower, rest: Float32Array, onGrown: () => void }} on the head at rest
 * @param {{ heatStrength: { value: number }, hides?: { value: number }, stands?: { value: number } }} uniforms of the skin; what hides it beside
 *   heat, from 0 to 1; how far it carries what is painted of it, 0 when it is not there
 * @param {readonly number[]} fade heights between which hair runs out with the neck, mm
 */
export function createTresses({ kind, style: styleOf, thinning: thinningOf, long, half, stride, gaps: between, bare = 0, carries = () => 1 }, { grower, rest, onGrown }, { heatStrength, hides = { value: 0 }, stands = { value: 0 } }, fade) {
  /** There when there first is hair; null where none grows. @type {import('./plant.js').Planting | null | undefined} */
  let hair;
  const geometry = new BufferGeometry();
  const shifts = new DataTexture(new Float32Array(4), 1, 1, RGBAFormat, FloatType);
  shifts.minFilter = shifts.magFilter = NearestFilter;
  const [young, old, turned] = [{ value: new Color() }, { value: new Color() }, { value: 0 }];
  const [gloss, gaps, rootless, thin] = [{ value: 1 }, { value: 0 }, { value: 0 }, { value: bare }];
  const skin = { value: new Color() };
  const drawn = share();
  /** Those strands that are there, of those that are drawn. @type {Uint16Array | null} */
  let standing = null;
  /** Whether others are to be, once hair is worn again: what is shown stays as it is until a style has grown. */
  let restands = true;
  /** All that stand, drawn or not. @type {Uint16Array} */
  let remaining = new Uint16Array(0);
  /** @type {import('./standing.js').Thinning} */
  let thinning = { share: 1, gone: [0, 0, 0, 0] };
  /** Where nothing grows. @type {readonly import('../head/marking.js').Bald[]} */
  let bald = [];
  let broad = half;
  let carrying = 1;
  const shared = { halfWidth: { value: half }, lockShifts: { value: shifts }, heatStrength, hides };
  const material = new ShaderMaterial({
    uniforms: {
      ...UniformsUtils.clone(UniformsLib.lights),
      backdropSize: backdropUniforms.backdropSize,
      ...studioUniforms,
      ...shared,
      fineness,
      young,
      old,
      turned,
      gloss,
      gaps,
      rootless,
      thin,
      skin,
      fade: { value: new Vector2(...fade) },
    },
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: DoubleSide,
    lights: true,
  });
  const mesh = new Mesh(geometry, material);
  // The light sees each ribbon's full width.
  const depth = new MeshDepthMaterial({ side: DoubleSide });
  depth.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, shared);
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', `#include <common>\n${PLACE}`)
      .replace(
        '#include <begin_vertex>',
        /* glsl */ `
        vec3 transformed = strandAt() + normalize(cross(course.xyz, outward.xyz) + 1e-6) * sign(course.w) * ribbon();
        if (strandHidden()) transformed = vec3(0.0);`,
      );
  };
  mesh.customDepthMaterial = depth;
  // Before the skin: what is behind the neck is seen where that runs out.
  mesh.renderOrder = -0.5;
  mesh.frustumCulled = false;
  // Of hairs that lie on the skin it would be finer than a shadow is drawn.
  mesh.castShadow = bare === 0;
  mesh.visible = false;
  mesh.name = kind;
  mesh.raycast = () => {};

  /** Triangles of all points, and of those that short hair takes: the first strand's, and those of the strands that stand. @type {{ first: Uint32Array, index: BufferAttribute, of: Uint16Array | null }[]} */
  const indexed = [];
  /** @type {0 | 1} */
  let isShort = 0;
  /** The latest first. @type {{ key: string, style: S, ribbons: import('./plant.js').Ribbons }[]} */
  const kept = [];
  /** The styles on the graphics card, the one that was worn last first. @type {{ of: typeof kept[number], attributes: BufferAttribute[] }[]} */
  const loaded = [];
  /** What is asked for. @type {{ key: string, style: S } | null} */
  let wanted = null;
  /** Whether something is being grown: what is wanted, or was. */
  let growing = false;
  /** Whether what was wanted since that was asked for has been shown: then nobody waits for it. */
  let outdated = false;
  /** @type {typeof kept[number] | null} */
  let shown = null;
  /** @type {ArrayLike<number>} */
  let present = rest;
  /**
   * Where its points are and how many, -1 when they have gone elsewhere: when a step ends and when the page gets another size, tens of thousands
   * are looked at, several times.
   */
  let places = new Float32Array(0);
  let placed = -1;

  /** Short hair is seen one by one, the shortest as grains on what is painted of it; and curls would fill what they wind around. */
  const slender = (/** @type {S} */ style) => (0.15 + 0.4 * smoothstep(0, 9, long(style)) + 0.45 * smoothstep(12, 60, long(style))) * (1 - 0.4 * style.curl) * breadthOf(thinning);

  /** What is short points everywhere, and would glitter. */
  const glossOf = (/** @type {S} */ style) => 0.15 + 0.85 * smoothstep(10, 60, long(style));

  /** How much of a ribbon's breadth is between its hairs. */
  const gapsOf = (/** @type {S} */ style) => between ?? 0.8 - 0.68 * smoothstep(12, 60, long(style));

  /** What does not depend on the style. @param {import('./plant.js').Planting} planting */
  function lay({ strands, locks, all, short, strand }) {
    for (const [indices, points] of /** @type {const} */ ([[all, POINTS], [short, SHORT.length]])) {
      const each = (points - 1) * 6;
      const index = new BufferAttribute(indices.subarray(0, Math.round(drawn * strands) * each), 1).setUsage(DynamicDrawUsage);
      indexed.push({ first: indices.slice(0, each), index, of: null });
    }
    // Hair that casts shadows need not be all of it.
    mesh.onBeforeShadow = () => geometry.setDrawRange(0, Math.round(corners() / 12) * 6);
    mesh.onAfterShadow = () => geometry.setDrawRange(0, corners());
    geometry.setAttribute('strand', new BufferAttribute(strand, 2));
    shifts.image = { data: new Float32Array(4 * ANCHORS * locks), width: locks, height: ANCHORS };
  }

  /** Of all triangles that are drawn. */
  const corners = () => (standing ? standing.length * indexed[isShort].first.length : 0);

  /** Those of some strands that have a root that is not bald. @param {Uint16Array} strands */
  function rooted(strands) {
    const { position } = shown?.ribbons ?? {};
    if (!position || bald.length === 0) return strands;
    // Those that lie on the skin would lie on the scar from beside it.
    const points = bare > 0 ? LYING : [0];
    return strands.filter((n) => !points.some((s) => isBald(bald, position, 6 * (n * POINTS + s))));
  }

  /** Draws the strands that stand, and no others. @param {import('./plant.js').Planting} planting */
  function stand(planting) {
    if (restands || !standing) {
      restands = false;
      const all = standingOf(planting.strands, planting, thinning);
      remaining = rooted(all);
      // The fewer there are, the more of them are drawn.
      const most = drawn * planting.strands;
      standing = rooted(all.subarray(0, Math.round(most)));
      // As broad as if they were everywhere.
      broad = half * broader(Math.min(1, most / Math.max(1, all.length)));
    }
    const { first, index, of } = indexed[isShort];
    if (of !== standing) {
      // Where there are but more of them or fewer, those that stay are there.
      let same = 0;
      while (of && same < standing.length && of[same] === standing[same]) same++;
      const { array, updateRanges } = index;
      for (let j = same, o = same * first.length; j < standing.length; j++) {
        const from = 2 * POINTS * standing[j];
        for (let i = 0; i < first.length; i++) array[o++] = from + first[i];
      }
      indexed[isShort].of = standing;
      if (same < standing.length) {
        // With what was changed and has not been drawn yet.
        const begin = Math.min(same * first.length, ...updateRanges.map(({ start }) => start));
        const end = Math.max(corners(), ...updateRanges.map(({ start, count }) => start + count));
        index.clearUpdateRanges();
        index.addUpdateRange(begin, end - begin);
        index.needsUpdate = true;
      }
    }
    geometry.setIndex(index);
    geometry.setDrawRange(0, corners());
  }

  /** @param {NonNullable<typeof wanted>} as @param {import('./grower.js').Grown | null} grown */
  function keep({ key, style }, grown) {
    if (hair === undefined) {
      hair = grown && grown.planting;
      if (hair) lay(hair);
    }
    if (!grown) return null;
    const before = kept.find((one) => one.key === key);
    if (before) return before;
    const one = { key, style, ribbons: grown.ribbons };
    kept.unshift(one);
    kept.length = Math.min(kept.length, KEPT);
    return one;
  }

  /** @param {boolean} visible */
  function appear(visible) {
    mesh.visible = visible;
    stands.value = visible ? carrying : 0;
  }

  /** Puts a style on the graphics card, unless it is there: in the place of one that was worn longest ago. @param {typeof kept[number]} one */
  function load(one) {
    const arrays = STYLED.map(([name]) => one.ribbons[name]);
    const at = loaded.findIndex(({ of }) => of === one);
    const [place] = loaded.splice(at >= 0 ? at : LOADED - 1, 1);
    const attributes = place?.attributes ?? STYLED.map(([, size], i) => new BufferAttribute(arrays[i], size, arrays[i] instanceof Int8Array).setUsage(DynamicDrawUsage));
    if (place && place.of !== one) attributes.forEach((attribute, i) => Object.assign(attribute, { array: arrays[i], needsUpdate: true }));
    loaded.unshift({ of: one, attributes });
    attributes.forEach((attribute, i) => geometry.setAttribute(STYLED[i][0], attribute));
  }

  /** @param {typeof kept[number]} one */
  function wear(one) {
    kept.splice(kept.indexOf(one), 1);
    kept.unshift(one);
    appear(true);
    if (one !== shown) {
      shown = one;
      const { style } = one;
      gloss.value = glossOf(style);
      gaps.value = gapsOf(style);
      rootless.value = Math.min(0.3, ROOTLESS / long(style));
      isShort = long(style) * (1 + 2 * style.curl) < SHORTER ? 1 : 0;
      load(one);
    }
    if (hair) stand(hair);
    shared.halfWidth.value = broad * slender(one.style);
    follow();
  }

  /** @returns {boolean} whether what is wanted is shown now */
  function show() {
    const key = wanted?.key;
    const found = kept.find((one) => one.key === key);
    if (found) wear(found);
    else if (!wanted || hair === null) appear(false);
    else return false;
    outdated = true;
    return true;
  }

  /** Has what is wanted grown beside the page; until it comes, what was shown is. */
  function ask() {
    if (show() || growing || !wanted) return;
    const asked = wanted;
    growing = true;
    outdated = false;
    grower.later(kind, asked.style, (grown) => {
      growing = false;
      const before = [shown, hair];
      const one = keep(asked, grown);
      // While a slider is drawn, what comes is of a moment ago. It may be somebody's whom nobody looks at any more.
      if (one && wanted && !outdated) wear(one);
      ask();
      // Whoever could not wait has shown it already.
      if (before[0] !== shown || before[1] !== hair) onGrown();
    });
  }

  /** Of what is in files, a strand's point among all. @param {number} n @param {number} s @param {number} many points of a strand */
  const pointOf = (n, s, many) => n * POINTS + (s === many - 1 ? POINTS - 1 : (POINTS / many) * s);

  /**
   * How far the head takes a point of a strand along, as in the shader.
   * @param {Float32Array} moved of each anchor @param {number} n @param {number} point among all @param {number[]} into
   */
  function shiftAt(moved, n, point, into) {
    if (!hair || !shown) return;
    const at = Math.min(ANCHORS - 1.001, (shown.ribbons.outward[8 * point + 3] / 127) * (ANCHORS - 1));
    const before = 4 * (Math.floor(at) * hair.locks + hair.lockOf[n]);
    const after = before + 4 * hair.locks;
    for (let k = 0; k < 3; k++) into[k] = moved[before + k] + (moved[after + k] - moved[before + k]) * (at % 1);
  }

  /**
   * The same ribbons with a front of their own, which do not turn to who looks: every `stride`th point, on any face of the model;
   * null where none stands.
   * @param {Float32Array} positions
   */
  function bodies(positions) {
    if (!stride || !hair || !mesh.visible || !shown) return null;
    const { style, ribbons } = shown;
    const many = POINTS / stride(style);
    const left = rooted(standingOf(filed(hair), hair, thinning));
    // Every part of a beard may be shaved off.
    if (left.length === 0) return null;
    const count = left.length * many;
    const out = {
      positions: new Float32Array(6 * count),
      normals: new Float32Array(6 * count),
      colours: new Float32Array(6 * count),
      triangles: new Uint32Array(left.length * (many - 1) * 6),
    };
    const moved = new Float32Array(4 * ANCHORS * hair.locks);
    shiftsOf(ribbons, positions, moved);
    const shift = [0, 0, 0];
    const wide = half * broader(FILED) * slender(style);
    const [way, up, across] = [new Vector3(), new Vector3(), new Vector3()];
    let [o, i] = [0, 0];
    for (const n of left) {
      // As in the shader from afar.
      const grey = turned.value + UNLIKE * turned.value * (1 - turned.value) * (((numberOf(n) * TURNS) % 1) - 0.5);
      const shade = young.value.clone().lerp(old.value, grey).toArray();
      for (let s = 0; s < many; s++) {
        const from = pointOf(n, s, many);
        way.fromArray(ribbons.course, 8 * from);
        up.fromArray(ribbons.outward, 8 * from);
        const breadth = up.length() / 127;
        up.normalize();
        const along = ribbons.outward[8 * from + 3] / 127;
        const open = Math.abs(ribbons.course[8 * from + 3]) / 127;
        across.crossVectors(way, up).normalize().multiplyScalar(wide * breadth * (1 + 0.4 * Math.max(0, 1 - 4 * along)) * (1 - 0.95 * along ** 2));
        shiftAt(moved, n, from, shift);
        if (s < many - 1) for (const corner of [0, 1, 2, 1, 3, 2]) out.triangles[i++] = o / 3 + corner;
        for (const side of [-1, 1]) {
          for (let k = 0; k < 3; k++) {
            out.positions[o + k] = ribbons.position[6 * from + k] + shift[k] + side * across.getComponent(k);
            out.normals[o + k] = up.getComponent(k);
            out.colours[o + k] = shade[k] * (0.4 + 0.6 * open) * (0.6 + 0.8 * ((n * 0.7548776662) % 1));
          }
          o += 3;
        }
      }
    }
    return out;
  }

  /**
   * How the vertices of `bodies` go along when those of the head move.
   * @param {Float32Array} moves 3 a vertex of the head, mm
   * @param {number} least mm
   * @returns {Float32Array | null} null when no root goes further than `least`
   */
  function carried(moves, least) {
    if (!stride || !hair || !shown) return null;
    const moved = new Float32Array(4 * ANCHORS * hair.locks);
    shiftsOf(shown.ribbons, rest.map((value, i) => value + moves[i]), moved);
    if (moved.every((value) => Math.abs(value) <= least)) return null;
    const many = POINTS / stride(shown.style);
    const left = rooted(standingOf(filed(hair), hair, thinning));
    const out = new Float32Array(6 * many * left.length);
    const shift = [0, 0, 0];
    for (let i = 0; i < out.length; i += 6) {
      const n = left[Math.floor(i / (6 * many))];
      shiftAt(moved, n, pointOf(n, (i / 6) % many, many), shift);
      out.set(shift, i);
      out.set(shift, i + 3);
    }
    return out;
  }

  function follow() {
    placed = -1;
    if (!hair || !mesh.visible || !shown) return;
    shiftsOf(shown.ribbons, present, /** @type {Float32Array} */ (shifts.image.data));
    shifts.needsUpdate = true;
  }

  /** Finds the points of all strands that stand, where they are to be seen. @returns {number} how many */
  function place() {
    if (!hair || !mesh.visible || !shown || heatStrength.value > 0.5) return 0;
    if (placed >= 0) return placed;
    const { position, outward } = shown.ribbons;
    const { locks, lockOf } = hair;
    const moved = /** @type {Float32Array} */ (shifts.image.data);
    const most = 3 * SHORT.length * remaining.length;
    if (places.length < most) places = new Float32Array(most);
    let o = 0;
    for (let i = 0; i < remaining.length; i++) {
      const n = remaining[i];
      for (let k = 0; k < SHORT.length; k++) {
        const point = n * POINTS + SHORT[k];
        // As in the shader.
        const at = Math.min(ANCHORS - 1.001, (outward[8 * point + 3] / 127) * (ANCHORS - 1));
        const anchor = Math.floor(at);
        const part = at - anchor;
        const before = 4 * (anchor * locks + lockOf[n]);
        const after = before + 4 * locks;
        const y = position[6 * point + 1] + moved[before + 1] + (moved[after + 1] - moved[before + 1]) * part;
        if (y < fade[0]) continue;
        places[o] = position[6 * point] + moved[before] + (moved[after] - moved[before]) * part;
        places[o + 1] = y;
        places[o + 2] = position[6 * point + 2] + moved[before + 2] + (moved[after + 2] - moved[before + 2]) * part;
        o += 3;
      }
    }
    placed = o / 3;
    return placed;
  }

  /** As far up and down as it is seen from any side that the page has a view of. @type {import('../stage/scene.js').Reach} */
  function reach({ x, y, z }, distance) {
    let [low, high] = [Infinity, -Infinity];
    for (let o = 0, end = 3 * place(); o < end; o += 3) {
      const aside = Math.abs(places[o] - x);
      const ahead = places[o + 2] - z;
      const nearer = Math.max(ahead, 0.79 * ahead + 0.62 * aside, aside);
      const seen = y + ((places[o + 1] - y) * distance) / (distance - nearer);
      if (seen < low) low = seen;
      if (seen > high) high = seen;
    }
    return [low, high];
  }

  /** As far to each side as it is seen. @type {import('../stage/scene.js').Breadth} */
  function breadth({ x, axis }, theta, distance) {
    const [sine, cosine] = [Math.sin(theta), Math.cos(theta)];
    let [left, right] = [0, 0];
    for (let o = 0, end = 3 * place(); o < end; o += 3) {
      const aside = places[o] - x;
      const ahead = places[o + 2] - axis;
      const seen = ((aside * cosine - ahead * sine) * distance) / (distance - aside * sine - ahead * cosine);
      if (seen > right) right = seen;
      if (-seen > left) left = -seen;
    }
    return [left, right];
  }

  return {
    name: kind,
    mesh,
    reach,
    breadth,
    bodies,
    carried,
    /** @param {ArrayLike<number>} positions of the face as it is */
    update(positions) {
      present = positions;
      follow();
    },
    /**
     * A style that is new comes when it has grown.
     * @param {Pigments & { bald?: typeof bald }} colours `bald`: where nothing grows
     * @param {boolean} [asks] otherwise whoever paints it has it grown at once
     */
    paint(colours, asks = true) {
      const tones = colours.grown[kind];
      young.value.copy(tones.young);
      old.value.copy(tones.old);
      turned.value = tones.turned;
      carrying = carries(colours);
      skin.value.copy(colours.skin);
      const now = thinningOf(colours);
      if (JSON.stringify(now) !== JSON.stringify(thinning)) {
        thinning = now;
        thin.value = bare > 0 ? bare : 1 - now.share;
        restands = true;
      }
      const { bald: scars = [] } = colours;
      if (JSON.stringify(scars) !== JSON.stringify(bald)) {
        bald = scars;
        restands = true;
      }
      const style = styleOf(colours);
      wanted = style.length > 0 && thinning.share > 0 ? { key: JSON.stringify(style), style } : null;
      if (asks) ask();
      else show();
    },
    /** Whether what was painted last is not what is shown, yet. */
    get isGrowing() {
      return wanted !== null && hair !== null && wanted.key !== shown?.key;
    },
    /** Which style is seen; none, where there is no hair. */
    get worn() {
      return mesh.visible && shown ? shown.key : '';
    },
    /** For who cannot wait. */
    finish() {
      if (show() || !wanted) return;
      keep(wanted, grower.now(kind, wanted.style));
      show();
      onGrown();
    },
  };
}
