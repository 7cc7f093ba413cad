import { Color, DataTexture, MeshDepthMaterial, MeshPhysicalMaterial, ShaderChunk, Vector2, Vector3, Vector4 } from 'three';
import { THROUGH_BLOOD } from './pigments.js';
import { RUNS_OUT } from '../rendering/backdrop.js';
import { STUDIO_GLSL, studioUniforms } from '../rendering/environment.js';
import { SCATTERED } from '../hair/scattered.js';
import { TILE } from '../hair/crop.js';
import { browLine, movesOf, UNMOVED_GLSL } from '../hair/browform.js';
import { BELOW_CHIN, foldsOf } from './folds.js';
import { BELOW } from './nostrils.js';
import { createMap, createTile, sharpen } from '../rendering/textures.js';

/** @typedef {ReturnType<typeof import('./pigments.js').pigments>} Paints */

// Light that enters skin comes out again some millimetres away, red furthest. Three cheap things
// stand for that: each colour channel wraps around the terminator by its own amount, the edges
// of shadows bleed red, and red is lit by the smooth normal while blue sees every pore.
// None of it takes powers where a polynomial is as near: where a processor draws, this shader is what a
// frame waits for.
const LIGHTS = ShaderChunk.lights_physical_pars_fragment
  .replace(
    'reflectedLight.directDiffuse += irradiance * diffuseBRDF * ( 1.0 - F );',
    /* glsl */ `
    vec3 scatter = skinScatter;
    vec3 facing = vec3(
      dot(smoothNormal, directLight.direction),
      dot(normalize(mix(smoothNormal, geometryNormal, 0.5)), directLight.direction),
      dot(geometryNormal, directLight.direction));
    vec3 wrapped = saturate((facing + scatter) / (1.0 + scatter));
    // To the power of 1 + scatter, within 0.01.
    wrapped *= 1.0 - scatter * (1.0 - wrapped) * (1.6 - 0.72 * wrapped);
    reflectedLight.directDiffuse += wrapped * directLight.color * diffuseBRDF * (1.0 - F);
    `,
  )
  // The same for every light.
  .replaceAll('IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness )', 'sheenToView')
  .replaceAll(
    'void RE_Direct_Physical',
    'vec3 smoothNormal; vec3 skinScatter; float sheenToView;\nvoid RE_Direct_Physical',
  );

const ENVIRONMENT = ShaderChunk.envmap_physical_pars_fragment
  .replace(/vec4 envMapColor = textureLod\([^;]*ENVMAP_MAX_LOD \);/, 'vec3 light = studioLightOn(worldNormal);')
  .replace('PI * envMapColor.rgb * envMapIntensity', 'PI * light * envMapIntensity')
  .replace(/vec4 envMapColor = textureLod\([^;]*roughnessToMip\( roughness \) \);/, 'vec3 mirrored = studioMirrored(reflectVec, roughness);')
  .replace('envMapColor.rgb * envMapIntensity', 'mirrored * envMapIntensity');

const SHADOWS = ShaderChunk.lights_fragment_begin.replace(
  /directLight\.color \*= (\( directLight\.visible && receiveShadow \) \? getShadow\( directionalShadowMap[^;]*);/,
  (_, lit) => /* glsl */ `
    // Lamps are wide, and noses and jaws are far from what they shade: edges are some millimetres wide, and on the neck some
    // more. In an edge three rings tell it, as one would be grains.
    float wide = 4.5 + 8.0 * sqrt(1.0 - vShade.z);
    float lit = ${lit.replace('.shadowRadius', '.shadowRadius * wide')};
    if (lit > 0.0 && lit < 1.0) {
      float middle = ${lit.replace('.shadowRadius', '.shadowRadius * 0.65 * wide')};
      float inner = ${lit.replace('.shadowRadius', '.shadowRadius * 0.3 * wide')};
      lit = (lit + middle + inner) / 3.0;
    }
    // Around the terminator the wrap decides, not the head's shadow on itself.
    lit = mix(1.0, lit, smoothstep(-0.2, 0.12, dot(smoothNormal, directLight.direction)));
    // To the powers of 0.8 and 0.95, nearly.
    directLight.color *= lit * vec3(1.53 - lit * (0.95 - 0.42 * lit), 1.12 - lit * (0.2 - 0.08 * lit), 1.0);`,
);

const DECLARATIONS = /* glsl */ `
  varying vec3 vRest;
  varying vec3 vRestNormal;
  varying vec3 vShade; // occlusion, ear, fade
  varying vec3 vOpen; // to red, green and blue
  varying vec2 vMark;
  varying vec3 vHeat;
  uniform float heatStrength;
  uniform sampler2D poreMap;
  uniform sampler2D faceMap;
  uniform sampler2D browMap;
  uniform vec4 faceFrame;
  uniform vec4 browFrame;
  uniform vec4 browLine;
  uniform vec2 browSpan;
  uniform vec4 browMoves;
  uniform float browSlant;
  // Of hair, beards and brows: those hairs that are not grey, those that are, and how many are.
  uniform vec3 young[3];
  uniform vec3 old[3];
  uniform vec3 turned;
  uniform float bushy;
  uniform float browed; // whether hairs stand on what is painted of brows
  uniform vec3 lipColour;
  uniform float lipCover;
  uniform vec3 accent;
  uniform vec2 markStrength;
  uniform float faceDepth;
  uniform float noseBase;
  varying vec3 vGrowth;
  uniform sampler2D strandMap;
  uniform vec2 dense;
  uniform vec2 covered; // by longer hair, by a longer beard
  varying vec2 vWorn;
  uniform sampler2D wornMap;
  uniform float worn;
  uniform vec3 wornTint[2];
  uniform sampler2D lineMap;
  uniform vec4 lineFrame;
  uniform vec2 aged; // lines, freckles
  uniform float creased; // whether there are any
  varying float vFold;
  ${STUDIO_GLSL}
  ${SCATTERED}
  ${UNMOVED_GLSL}

  // Relief and mottling, projected along the three axes of the head at rest.
  vec4 triplanar(float size, out vec3 slope) {
    vec3 weight = abs(vRestNormal);
    weight *= weight * weight * weight * weight;
    weight /= weight.x + weight.y + weight.z;
    vec4 a = texture2D(poreMap, vRest.zy / size);
    vec4 b = texture2D(poreMap, vRest.xz / size);
    vec4 c = texture2D(poreMap, vRest.xy / size);
    slope = vec3(0.0, a.g - 0.5, a.r - 0.5) * weight.x
          + vec3(b.r - 0.5, 0.0, b.g - 0.5) * weight.y
          + vec3(c.r - 0.5, c.g - 0.5, 0.0) * weight.z;
    return a * weight.x + b * weight.y + c * weight.z;
  }

  // Hairs that lie on the head, in the same way: cover, lightness; and how far they lean.
  vec2 strands(out vec3 slope) {
    vec3 weight = abs(vRestNormal);
    weight *= weight * weight;
    weight /= weight.x + weight.y + weight.z;
    vec3 a = texture2D(strandMap, vRest.zy / ${TILE.toFixed(1)}).rgb;
    vec3 b = texture2D(strandMap, vRest.xz / ${TILE.toFixed(1)}).rgb;
    vec3 c = texture2D(strandMap, vRest.xy / ${TILE.toFixed(1)}).rgb;
    slope = vec3((b.b - 0.5) * weight.y + (c.b - 0.5) * weight.z, 0.0, (a.b - 0.5) * weight.x);
    return a.rg * weight.x + b.rg * weight.y + c.rg * weight.z;
  }
`;

/** How bright skin in the middle of the face is over its albedo. */
const LIT = 1.45;
/** A photo's light up to which its hue is told by undoing a curve. */
const BRIGHTEST = 0.72;
const COLOUR = /* glsl */ `
  vec2 faceAt = (vRest.xy - faceFrame.xy) / faceFrame.zw;
  float front = smoothstep(faceDepth, faceDepth + 14.0, vRest.z)
              * smoothstep(0.0, 0.03, faceAt.y) * smoothstep(1.0, 0.97, faceAt.y);
  vec4 paint = texture2D(faceMap, faceAt) * front;
  vec2 browAt = (unmovedBrow(vRest.xy) - browFrame.xy) / browFrame.zw;
  float inBrow = step(0.0, min(min(browAt.x, browAt.y), min(1.0 - browAt.x, 1.0 - browAt.y)));
  // The two sides may be far apart on the map where they meet on the skin.
  vec2 hairsOfBrow = textureGrad(browMap, clamp(browAt, 0.0, 1.0), dFdx(vRest.xy) / browFrame.zw, dFdy(vRest.xy) / browFrame.zw).rg;
  float brow = min(1.0, hairsOfBrow.r * bushy) * inBrow * (1.0 - 0.2 * browed)
             * smoothstep(faceDepth - 12.0, faceDepth - 4.0, vRest.z);

  vec4 folded = vec4(0.5, 0.5, 0.0, 0.0);
  // How old the skin looks: on the face and the neck, and not below hair.
  float years = 0.0;
  if (creased > 0.0 && heatStrength < 1.0) {
    // As far as they are seen from the front: the neck stands back.
    float depthHere = faceDepth - 36.0 * (1.0 - smoothstep(-14.0, -8.0, vRest.y - lineFrame.y - ${BELOW_CHIN.toFixed(1)}));
    float faces = smoothstep(depthHere, depthHere + 14.0, vRest.z) * smoothstep(0.12, 0.4, vRestNormal.z);
    folded = mix(folded, texture2D(lineMap, (vRest.xy - lineFrame.xy) / lineFrame.zw), faces);
    years = aged.x * faces * (1.0 - smoothstep(-0.8, -0.3, vGrowth.x));
  }

#ifdef MARKED
  findMarks();
  brow *= 1.0 - markBald;
#endif
  vec3 fine;
  vec3 coarse;
  vec4 relief = triplanar(26.0, fine);
  vec4 broad = triplanar(97.0, coarse);
  float occlusion = vShade.x;
  float ear = vShade.y;
  float lip = paint.r;
  float blood = clamp(paint.g + 0.55 * ear, 0.0, 1.0);
  float smoothSkin = max(paint.b, 0.6 * ear);

  vec3 tone = diffuseColor.rgb * vec3(${THROUGH_BLOOD.join(', ')});
  // Blood takes green and blue, melanin takes all, more of the blue.
  tone *= mix(vec3(1.0), vec3(0.96, 0.70, 0.66), blood * 0.62);
  tone *= mix(vec3(1.0), vec3(1.0, 0.88, 0.84), (broad.a - 0.5) * 1.1);
  // With the years it gets blotchy and sallow.
  tone *= mix(vec3(1.0), vec3(0.93, 0.9, 0.88), (relief.a - 0.5) * (0.9 + 1.2 * years));
  tone *= mix(vec3(1.0), vec3(0.97, 0.96, 0.92), years);
  tone *= 1.0 - 0.2 * (1.0 - relief.b) * (1.0 - smoothSkin);
  tone = mix(tone, tone * vec3(0.86, 0.87, 0.9), paint.a * 0.3);
  // Lines are darker and a little redder; around the eyes skin is thin, and its shadows are those of veins. Freckles are melanin.
  vec3 fold = mix(vec3(0.25, 0.32, 0.32), vec3(0.3, 0.31, 0.25), smoothSkin);
  vec3 drawn = (1.0 - vFold * folded.b * fold) * (1.0 - aged.y * folded.a * vec3(0.32, 0.47, 0.57));
  tone *= drawn;
  vec3 lips = lipColour * (0.86 + 0.28 * relief.a);
  tone = mix(tone, lips, lip * lipCover);
#ifdef MARKED
  tone = withMarks(tone);
#endif
  // Not all hairs turn grey at once.
  float turns = hairsOfBrow.g / max(hairsOfBrow.r, 0.01);
  vec3 browTone = mix(young[2], old[2], smoothstep(turns - 0.15, turns + 0.15, turned.z));
  tone = mix(tone, browTone, clamp(brow * 1.15, 0.0, 0.9));
  // How much of what is worn the photo shows.
  float photographed = 0.0;
  if (worn > 0.0) {
    vec4 photo = texture2D(wornMap, vWorn);
    vec3 seen = photo.rgb;
    photographed = worn * photo.a;
#ifdef TONE_MAPPING
    // What ACESFilmicToneMapping shows as the photo does, where there is as much light as in the middle of the face: the
    // photo's own curve has made bright colours pale already, and they are not made so once more.
    vec3 shown = mat3(0.64304, 0.05927, 0.00596, 0.31119, 0.93144, 0.06393, 0.04578, 0.00929, 0.93012) * seen;
    // Next to white a curve tells nothing of hues.
    shown *= min(1.0, ${BRIGHTEST} / max(max(shown.r, shown.g), max(shown.b, 0.001)));
    vec3 square = 1.0 - 0.983729 * shown;
    vec3 linear = 0.0245786 - 0.432951 * shown;
    vec3 lit = (sqrt(linear * linear + 4.0 * square * (0.000090537 + 0.238081 * shown)) - linear) / (2.0 * square);
    lit = mat3(1.76474, -0.14703, -0.03634, -0.67578, 1.16025, -0.16244, -0.08896, -0.01322, 1.19877) * lit;
    seen = max(lit * (0.6 / (${LIT} * toneMappingExposure)), 0.0);
#else
    // A photo is exposed so that lit skin is brighter than its albedo.
    seen *= 0.8;
#endif
    seen *= mix(wornTint[0], wornTint[1], lip) * drawn;
#ifdef MARKED
    // What is put on somebody's face is put on the photo that it wears as well, which has those that it had.
    seen = withMarks(seen);
#endif
    tone = mix(tone, seen, worn);
  }
  // What no light reaches, the mouth and the depth of nostrils, is mucous membrane; where skin ends in a nose or an ear it is as dark as
  // the skin is, and too dark to be red.
  float nostril = step(noseBase, vRest.y);
  vec3 mucous = mix(vec3(0.42, 0.12, 0.11), tone * vec3(0.4, 0.22, 0.2), nostril);
  tone = mix(tone, mucous, 0.85 * (1.0 - smoothstep(0.03, 0.2, occlusion)));
  float hairs = 0.0;
  float underHair = 0.0;
  vec3 lying = vec3(0.0);
  // Distances are the head's, and their colours no darker under hair.
  if (dense.x + dense.y > 0.0 && heatStrength < 1.0) {
    vec2 strand = strands(lying);
    // No hairline is a line: each hair has its own. Of a beard the dark ones are first.
    vec2 grown = vGrowth.xy + 0.3 * (broad.a - 0.5) + vec2(0.8, -0.8) * (strand.g - 0.5);
    grown = smoothstep(vec2(-0.3, -0.35), vec2(0.45, 0.4), grown) * dense * (1.0 - lip);
#ifdef MARKED
    grown *= 1.0 - markBald;
#endif
    float thick = grown.x;
    // The lightest turn grey first.
    vec2 greyed = smoothstep(-0.3, 0.3, (2.25 - 0.8 * turned.xy) * turned.xy - 0.95 + 1.7 * (strand.g - 0.5));
    vec3 hair = scattered(mix(young[0], old[0], greyed.x));
    vec3 ofBeard = scattered(mix(young[1], old[1], greyed.y));
    // Roots show through the skin; hairs lie over it.
    tone = mix(tone, mix(tone * 0.6, hair, 0.6 + 0.2 * thick), thick * (0.3 + 0.65 * thick));
    underHair = smoothstep(0.1, 0.7, thick) * covered.x;
    // It is dark between roots, but at the edge.
    tone = mix(tone, hair * (0.72 - 0.3 * smoothstep(0.5, 1.0, thick)), underHair * 0.95);
    hairs = clamp(thick * (0.05 + 0.5 * thick + 1.1 * strand.r), 0.0, 0.95);
    tone = mix(tone, hair * (0.35 + 1.3 * strand.g) * (1.0 - 0.4 * covered.x), hairs);
    // A photo that is worn has its own beard, as far as it shows the skin. One that is thin is single hairs, on skin that is greyer for
    // their roots.
    float beard = grown.y * vGrowth.z * (1.0 - smoothSkin) * (1.0 - photographed);
    float rank = 1.7 * strand.g - 0.45;
    float whisker = smoothstep(-0.25, 0.25, 1.25 * beard - rank) * min(1.0, 5.0 * beard) * (0.5 + 0.45 * beard);
    tone = mix(tone, mix(tone * vec3(0.5, 0.53, 0.58), 0.5 * mix(young[1], old[1], turned.y), 0.75 * beard), beard * (0.45 + 0.45 * beard));
    tone = mix(tone, ofBeard * 0.85, beard * covered.y * 0.8);
    tone = mix(tone, ofBeard * (0.05 + (1.1 + 0.6 * beard) * strand.g) * (1.0 - 0.1 * covered.y), whisker);
    hairs = max(hairs, whisker);
    underHair = max(underHair, whisker * covered.y);
    lying *= hairs;
  }
  float marked = dot(smoothstep(0.15, 0.85, vMark), markStrength);
  vec2 rim = smoothstep(0.0, 0.45, vMark) * smoothstep(1.0, 0.55, vMark);
  diffuseColor.rgb = mix(tone, accent * (0.35 + 0.9 * dot(tone, vec3(0.33))), clamp(marked * 0.1 + dot(rim, markStrength) * 0.3, 0.0, 0.5));
`;

const SLOPE = /* glsl */ `
  float depth = mix(1.0, 0.35, smoothSkin) * (1.0 - lip) * (1.0 - 0.7 * brow) * (1.0 - 0.8 * hairs);
  vec3 slope = fine * 0.55 * depth + coarse * 0.16 * depth;
  // Lips are furrowed from edge to edge, not pitted.
  float furrow = sin(vRest.x * 5.2 + 2.6 * (broad.a - 0.5) + 5.0 * (relief.a - 0.5));
  slope += vec3(0.055 * furrow * lip, 0.0, 0.0) + 1.3 * lying;
  vec3 form = vec3(2.0 * folded.rg - 1.0, 0.0) * vFold * (1.0 - lip);
  slope += form;
#ifdef MARKED
  slope = slope * (1.0 - markSmooth) + markSlope * (1.0 - hairs);
  form += 0.5 * markSlope;
#endif
`;

const NORMAL = /* glsl */ `
  {
    ${SLOPE}
    // Bags and folds are larger than what light crosses below the skin: red is shaded by them as well, or their shadows were orange.
    form = 0.75 * (normalMatrix * form);
    smoothNormal = normalize(normal - (form - dot(form, normal) * normal));
    slope = normalMatrix * slope;
    normal = normalize(normal - (slope - dot(slope, normal) * normal));
  }
  skinScatter = mix(vec3(0.17, 0.10, 0.075), vec3(0.5, 0.2, 0.13), ear * (1.0 - 0.6 * worn));
  sheenToView = IBLSheenBRDF(normal, isOrthographic ? vec3(0.0, 0.0, 1.0) : normalize(vViewPosition), sheenRoughness);
`;

const ROUGHNESS = /* glsl */ `
  float oil = clamp(paint.g * 0.4 + 0.35 * front * smoothstep(0.35, 0.8, vRestNormal.z), 0.0, 1.0);
  float roughnessFactor = roughness;
  roughnessFactor += 0.10 * (relief.a - 0.5) + 0.07 * (broad.a - 0.5) - 0.07 * oil;
  roughnessFactor = mix(roughnessFactor, 0.38, lip);
#ifdef MARKED
  roughnessFactor -= 0.1 * markSmooth;
#endif
  roughnessFactor = mix(roughnessFactor, 0.62, clamp(brow + hairs, 0.0, 1.0));
  roughnessFactor = clamp(roughnessFactor, 0.2, 1.0);
`;

const OCCLUSION = /* glsl */ `
  {
    reflectedLight.indirectDiffuse *= vOpen;
    // Where light comes through flesh alone, between lips and in nostrils, it is a deep red and not black.
    float closed = 1.0 - smoothstep(0.0, 0.45, occlusion);
    reflectedLight.indirectDiffuse += diffuseColor.rgb * vec3(0.11, 0.022, 0.018) * (1.0 - 0.55 * nostril) * closed;
    float dotNV = saturate(dot(normal, geometryViewDir));
    float shine = computeSpecularOcclusion(dotNV, occlusion, material.roughness);
    reflectedLight.indirectSpecular *= shine * mix(0.55, 1.0, occlusion) * (1.0 - 0.8 * underHair);
    // Lamps shine into an open mouth past lips that hide less of them than of the sky.
    reflectedLight.directDiffuse *= mix(vec3(1.0), vOpen, 0.55 + 0.3 * closed * closed);
    reflectedLight.directSpecular *= smoothstep(0.1, 0.6, occlusion) * mix(1.0, relief.b, 0.5 * (1.0 - lip)) * (1.0 - 0.6 * hairs);
#ifdef MARKED
    reflectedLight.directDiffuse *= 1.0 - 0.5 * markShade;
    reflectedLight.directSpecular *= 1.0 - 0.8 * markShade;
#endif
    // Down catches no light below hair.
    sheenSpecularDirect *= 1.0 - underHair;
    sheenSpecularIndirect *= 1.0 - underHair;
  }
`;

/** Where hair and beard grow, for a corner of the mesh: `parts` are those of `parts.js`, and until they come all of it is there. */
const GROWN = {
  DECLARATIONS: /* glsl */ `
    attribute vec2 growth;
    attribute vec4 parts;
    uniform vec4 gone;
    uniform vec2 covered;
    varying vec3 vGrowth;`,
  // Strands that become few leave no stain, and a line that recedes no edge before them.
  PLACED: 'vGrowth = vec3(min(growth.x - 0.15 * covered.x, 11.0 * (parts.w - gone.w) - mix(0.35, 0.9, smoothstep(0.0, 0.1, gone.w)) * covered.x), growth.y, 1.0 - dot(parts.xyz, gone.xyz));',
};

/**
 * What the skin is painted with, for pictures of it that other programs read. The colours of a corner of the mesh
 * are found from where it is on the head at rest. Each sets variables: the skin's declarations come before main; then
 * `COLOUR` changes `diffuseColor` (that of a photo for the page's tone curve, where there is one), `ROUGHNESS` makes
 * `roughnessFactor` of `roughness`, and `SLOPE` is how far the normal at rest leans, in the head's axes. `GROWN` is for the corners: it
 * sets one of the variables.
 */
export const SKIN_GLSL = { COLOUR, ROUGHNESS, SLOPE, GROWN };

/** More than it came out of any of two thousand people who differ twice as much as people do, mm. */
const DEEPER = 10;

/**
 * What lies deep in a mouth comes out of few chins, and is drawn behind them all the same.
 * @param {{ vertexShader: string }} shader
 */
function keepInside(shader) {
  shader.vertexShader = shader.vertexShader.replace('#include <common>', '#include <common>\nattribute float inside;').replace(
    '#include <project_vertex>',
    /* glsl */ `#include <project_vertex>
    {
      vec4 back = projectionMatrix * (mvPosition - vec4(0.0, 0.0, ${DEEPER.toFixed(1)} * inside, 0.0));
      gl_Position.z = back.z / back.w * gl_Position.w;
    }`,
  );
}

/** What a skin's shader is told where there are marks. */
const MARKED = { MARKED: '' };

/** The fine down on skin, which catches light at the edge. */
const FUZZ = new Color(0.95, 0.72, 0.62);

/**
 * The skin: a physical material with pores, blood, lips and brows of its own.
 *
 * @param {{
 *   pores: import('three').Texture,
 *   face: { map: import('three').Texture, frame: number[] },
 *   brows: { map: import('three').Texture, frame: number[] },
 *   depth: number,
 *   landmarks: import('../groundwork/paint.js').Points,
 * }} look `depth` is the z (mm, at rest) from which on the maps apply
 */
export function createSkin({ pores, face, brows, depth, landmarks }) {
  /** Until there are lines: nobody looks at it. @type {import('three').Texture} */
  const lineless = new DataTexture(new Uint8Array(4), 1, 1);
  /** No hair, which would be neither light nor dark, and leans nowhere. @type {import('three').Texture} */
  const hairless = new DataTexture(Uint8Array.of(0, 128, 128, 0), 1, 1);
  hairless.needsUpdate = true;
  const uniforms = {
    ...studioUniforms,
    poreMap: { value: pores },
    faceMap: { value: face.map },
    browMap: { value: brows.map },
    faceFrame: { value: new Vector4().fromArray(face.frame) },
    browFrame: { value: new Vector4().fromArray(brows.frame) },
    browLine: { value: new Vector4() },
    browSpan: { value: new Vector2(0, 1) },
    browMoves: { value: new Vector4(0, 1, 0, 0) },
    browSlant: { value: 0 },
    young: { value: [new Color(), new Color(), new Color()] },
    old: { value: [new Color(), new Color(), new Color()] },
    turned: { value: new Vector3() },
    bushy: { value: 1 },
    browed: { value: 0 },
    /** Painted when there is hair. */
    strandMap: { value: hairless },
    dense: { value: new Vector2() },
    lift: { value: 0 },
    gone: { value: new Vector4() },
    /** By longer hair, and by a longer beard. */
    covered: { value: new Vector2() },
    lipColour: { value: new Color() },
    lipCover: { value: 0 },
    accent: { value: new Color('#39a79c') },
    markStrength: { value: [0, 0] },
    faceDepth: { value: depth },
    /** At rest, mm. */
    noseBase: { value: (landmarks.get('ibug_33')?.[1] ?? 0) - BELOW },
    /** Painted when there are lines or freckles. */
    lineMap: { value: lineless },
    lineFrame: { value: new Vector4(0, 0, 1, 1) },
    aged: { value: new Vector2() },
    creased: { value: 0 },
    foldsRight: { value: new Vector4(0, 0, 0, 0) },
    foldsLeft: { value: new Vector4(0, 0, 0, 0) },
    smooths: { value: new Vector2() },
    heatStrength: { value: 0 },
    /** A person's own colours, and how much of them shows. */
    wornMap: { value: new DataTexture(new Uint8Array(4), 1, 1) },
    worn: { value: 0 },
    /** How much lighter its skin and its lips are than they were. */
    wornTint: { value: [new Color(1, 1, 1), new Color(1, 1, 1)] },
  };
  const brow = browLine(landmarks);
  if (brow) {
    uniforms.browLine.value.fromArray(brow.heights);
    uniforms.browSpan.value.set(brow.outer, brow.length);
  }
  const material = new MeshPhysicalMaterial({
    ...RUNS_OUT,
    roughness: 0.52,
    specularIntensity: 0.85,
    ior: 1.42,
    sheen: 0.22,
    sheenRoughness: 0.55,
  });
  /** How marks are drawn, once there were some: a skin without has nothing of it in its shader. */
  let marking = '';
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace(
        '#include <common>',
        /* glsl */ `#include <common>
        attribute vec3 rest;
        attribute vec3 restNormal;
        attribute vec3 shade;
        attribute vec2 mark;
        ${GROWN.DECLARATIONS}
        attribute vec4 folding;
        uniform vec4 foldsRight;
        uniform vec4 foldsLeft;
        uniform vec2 smooths; // right, left
        uniform vec2 aged;
        uniform float worn;
        varying float vFold;
        uniform float lift;
        uniform float heatStrength;
        varying vec3 vRest;
        varying vec3 vRestNormal;
        varying vec3 vShade;
        varying vec3 vOpen;
        varying vec2 vMark;
        attribute vec3 heat;
        varying vec3 vHeat;
        varying vec2 vWorn;`,
      )
      .replace(
        '#include <begin_vertex>',
        /* glsl */ `#include <begin_vertex>
        vRest = rest;
        vRestNormal = restNormal;
        vShade = shade;
        // Light bounced between skin and skin is red: occlusion darkens red least.
        vOpen = pow(vec3(shade.x), vec3(0.78, 1.08, 1.18));
        vMark = mark;
        ${GROWN.PLACED}
        // An expression folds young skin a little, and old skin where it is folded.
        vec4 folds = folding * mix(foldsRight, foldsLeft, smoothstep(-6.0, 6.0, rest.x));
        // A photo that is worn has those of its face's expression.
        vFold = aged.x + (1.0 - worn) * max(max(folds.x, folds.y), max(folds.z, folds.w)) * (0.45 + 0.4 * aged.x);
        vFold *= 1.0 + min(0.0, folding.w) * 0.9 * mix(smooths.x, smooths.y, smoothstep(-6.0, 6.0, rest.x));
        // Hair stands off the head, and longer hair over that.
        transformed += objectNormal * (lift * (1.0 - heatStrength) * smoothstep(-0.1, 0.9, vGrowth.x));
        vHeat = heat;
        vWorn = uv;`,
      );
    keepInside(shader);
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', `#include <common>\nuniform mat3 normalMatrix;\n${DECLARATIONS}${marking}`)
      .replace('#include <lights_physical_pars_fragment>', LIGHTS)
      .replace('#include <envmap_physical_pars_fragment>', ENVIRONMENT)
      .replace('#include <lights_fragment_begin>', SHADOWS)
      .replace('#include <color_fragment>', `#include <color_fragment>\n${COLOUR}`)
      .replace('#include <roughnessmap_fragment>', ROUGHNESS)
      .replace('#include <normal_fragment_maps>', NORMAL)
      .replace('#include <aomap_fragment>', OCCLUSION)
      .replace(
        '#include <dithering_fragment>',
        /* glsl */ `
        {
          // After tone mapping, so that a colour is the colour bar's; a little light keeps the form.
          float light = dot(gl_FragColor.rgb, vec3(0.3, 0.55, 0.15));
          gl_FragColor.rgb = mix(gl_FragColor.rgb, vHeat * (0.82 + 0.3 * light), heatStrength);
        }
        gl_FragColor = vec4(gl_FragColor.rgb, 1.0) * vShade.z;`,
      );
  };
  const most = (/** @type {Vector4} */ { x, y, z, w }) => Math.max(x, y, z, w);
  function crease() {
    const { aged, foldsRight, foldsLeft, creased, lineMap } = uniforms;
    const deepest = Math.max(aged.value.x, aged.value.y, most(foldsRight.value), most(foldsLeft.value));
    if (deepest > 0) want('lines');
    // What there is until they come would tilt all of the face.
    creased.value = lineMap.value === lineless ? 0 : deepest;
  }
  /** @type {ReturnType<typeof import('./finework.js').layFinework> | null} */
  let finework = null;
  /** What is to be seen and has not come. @type {Set<keyof import('./finework.js').Finework>} */
  const wanted = new Set();
  const maps = { lines: uniforms.lineMap, strands: uniforms.strandMap };
  /** @param {keyof typeof maps} what */
  function want(what) {
    if (!finework || wanted.has(what) || ![lineless, hairless].includes(maps[what].value)) return;
    wanted.add(what);
    finework.soon(what);
  }
  /** @param {Partial<import('./finework.js').Finework>} come */
  function take({ lines, strands }) {
    if (lines) {
      uniforms.lineMap.value = createMap(lines.map);
      uniforms.lineFrame.value.fromArray(lines.frame);
      wanted.delete('lines');
      crease();
    }
    if (strands) {
      const tile = createTile(strands);
      // Its rows are a canvas's.
      tile.flipY = true;
      sharpen(tile, 8);
      uniforms.strandMap.value = tile;
      wanted.delete('strands');
    }
  }
  const shadow = new MeshDepthMaterial();
  shadow.onBeforeCompile = keepInside;
  return {
    material,
    /** What casts its shadow. */
    shadow,
    uniforms,
    /**
     * Lets it have lines, freckles and cropped hair.
     * @param {typeof import('./finework.js').layFinework} lay @param {() => void} onCome some that was wanted has come
     */
    refine(lay, onCome) {
      finework = lay(landmarks, (work) => {
        const before = wanted.size;
        take(work);
        if (wanted.size < before) onCome();
      });
      crease();
    },
    dispose: () => finework?.dispose(),
    /** What it is drawn with: its shader has these declarations and definitions. */
    look: {
      material,
      uniforms,
      get declarations() {
        return DECLARATIONS + marking;
      },
      get defines() {
        return marking ? MARKED : {};
      },
    },
    /** From now on it may have marks. @param {import('./marking.js').Marking} by */
    beMarked(by) {
      if (marking) return;
      marking = by.glsl;
      Object.assign(uniforms, by.uniforms);
      material.defines = { ...material.defines, ...MARKED };
      material.needsUpdate = true;
    },
    /** Whether something that is to be seen has not come yet. */
    get isUnfinished() {
      return wanted.size > 0;
    },
    /** For who cannot wait. */
    finish() {
      for (const what of wanted) finework?.now(what);
    },
    /** @param {Readonly<Record<string, number>>} expression weights by ARKit's names */
    fold(expression) {
      const [right, left] = [foldsOf(expression, 'Right'), foldsOf(expression, 'Left')];
      uniforms.foldsRight.value.fromArray(right.folds);
      uniforms.foldsLeft.value.fromArray(left.folds);
      uniforms.smooths.value.set(right.smooths, left.smooths);
      crease();
    },
    /** Colours of a photo become others as the skin and the lips do. @param {Paints} now @param {Paints} before */
    tint(now, before) {
      uniforms.wornTint.value = [now.skin, now.lips].map((colour, i) => {
        const was = [before.skin, before.lips][i];
        return new Color(colour.r / was.r, colour.g / was.g, colour.b / was.b);
      });
    },
    /** @param {Paints} colours */
    paint({ skin, bright, lips, lipCover, grown, bushy, browForm, dense, lift, standing, gone, style, whiskers, lines, freckles }) {
      material.color.copy(skin);
      // On dark skin all that is mirrored stands out, and a little of it is plastic.
      material.sheenColor.copy(FUZZ).multiplyScalar(bright * bright);
      material.specularIntensity = 0.85 - 0.3 * (1 - bright);
      material.roughness = 0.52 + 0.06 * (1 - bright);
      uniforms.lipColour.value.copy(lips);
      uniforms.lipCover.value = lipCover;
      const tones = [grown.hair, grown.beard, grown.brows];
      uniforms.young.value = tones.map(({ young }) => young);
      uniforms.old.value = tones.map(({ old }) => old);
      uniforms.turned.value.fromArray(tones.map(({ turned }) => turned));
      uniforms.bushy.value = bushy;
      if (brow) {
        const { apart, broad, raise, arch, slant } = movesOf(browForm, brow);
        uniforms.browMoves.value.set(apart, broad, raise, arch);
        uniforms.browSlant.value = slant;
      }
      uniforms.dense.value.fromArray(dense);
      uniforms.lift.value = lift;
      uniforms.gone.value.fromArray(gone);
      uniforms.covered.value.set(Math.min(1, 6 * style.length) * standing[0], Math.min(1, 6 * whiskers.length) * standing[1]);
      uniforms.aged.value.set(lines, freckles);
      crease();
      if (dense.some((much) => much > 0)) want('strands');
    },
  };
}
