// The skin and the eyes as pictures that other programs put on the mesh: what the page's shaders compute at each
// pixel of the screen, at each pixel of a picture instead.

import { Color, PlaneGeometry, ShaderMaterial, Vector4 } from 'three';
import { EYE_GLSL } from '../head/eyes.js';
import { SKIN_GLSL } from '../head/skin.js';
import { fill, jpeg, paint } from './raster.js';

/** Pixels a side. The skin has a quarter of its picture: 5.6 pixels a millimetre of it. */
const SKIN = 4096;
const EYE = 1024;
/** As many tell of vertices, which are two millimetres apart. */
const VERTICES = 1024;
/** What tells of light and gloss has no detail worth more. */
const SURFACE = 1024;
/**
 * What is seen past an eyeball between lids that are longer than it: on the page its white goes on to where they meet, and in the mesh
 * there is the wall behind. Linear.
 */
const BESIDE_EYES = '0.56, 0.43, 0.39';
/** How far from an eyeball that wall may be, in its radii. */
const WALL = 1.5;
/** How far from the gaze the eye's picture reaches, radians: past the lids. */
export const EYE_REACH = (110 / 180) * Math.PI;

const VERTEX = /* glsl */ `
  attribute vec3 rest;
  attribute vec3 restNormal;
  attribute vec3 shade;
  varying vec3 vRest;
  varying vec3 vRestNormal;
  varying vec3 vShade;
  varying vec3 vOpen;
  ${SKIN_GLSL.GROWN.DECLARATIONS}
  uniform vec2 aged;
  varying float vFold;
  varying vec2 vMark;
  varying vec3 vHeat;
  varying vec2 vWorn;
  void main() {
    vRest = rest;
    vRestNormal = restNormal;
    vShade = shade;
    vOpen = vec3(1.0);
    vMark = vec2(0.0);
    ${SKIN_GLSL.GROWN.PLACED}
    // At rest.
    vFold = aged.x;
    vHeat = vec3(0.0);
    vWorn = uv;
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
  }
`;

/** What is written in a round of painting, picture by picture. */
const ROUNDS = {
  look: {
    out: 'layout(location = 1) out highp vec4 leaning;',
    /* Where no light comes, in the mouth and the nostrils, skin is dark red: few programs find that out. The normal is in the axes in
       which the texture coordinates grow. */
    write: /* glsl */ `
      diffuseColor.rgb *= mix(vec3(0.3, 0.12, 0.1), vec3(1.0), smoothstep(0.02, 0.3, occlusion));
      diffuseColor.rgb = mix(diffuseColor.rgb, vec3(${BESIDE_EYES}), behindLids());
      gl_FragColor = sRGBTransferOETF(vec4(diffuseColor.rgb, 1.0));
      ${SKIN_GLSL.SLOPE}
      vec3 n = normalize(vRestNormal);
      vec3 right = dFdx(vRest);
      right = normalize(right - dot(right, n) * n);
      vec3 up = cross(n, right);
      up *= dot(up, dFdy(vRest)) < 0.0 ? -1.0 : 1.0;
      vec3 bent = normalize(n - (slope - dot(slope, n) * n));
      leaning = vec4(0.5 + 0.5 * vec3(dot(bent, right), dot(bent, up), dot(bent, n)), 1.0);`,
  },
  // As glTF has them: open to light, rough, metallic.
  surface: {
    out: '',
    write: /* glsl */ `
      ${SKIN_GLSL.ROUGHNESS}
      gl_FragColor = vec4(mix(occlusion, 0.7, behindLids()), roughnessFactor, 0.0, 1.0);`,
  },
};

/** Makes something of the head as it is to look. @typedef {<T>(make: () => T) => T} Coloured */

/**
 * @param {import('three').WebGLRenderer} renderer
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head
 * @param {Coloured} coloured
 */
function skinPainter(renderer, { skin, look, eyeballs }, coloured) {
  const { tone, roughness } = coloured(() => ({ tone: look.material.color.clone(), roughness: look.material.roughness }));
  // After it was painted so: it may have its first marks.
  const uniforms = {
    ...look.uniforms,
    markStrength: { value: [0, 0] },
    heatStrength: { value: 0 },
    browed: { value: 0 },
    skinTone: { value: tone },
    roughness: { value: roughness },
    eyeballs: { value: eyeballs.map(({ centre, radius }) => new Vector4(centre.x, centre.y, centre.z, WALL * radius)) },
  };
  const most = renderer.capabilities.maxTextureSize;
  /** @param {keyof typeof ROUNDS} round @param {number} size @param {number} [count] */
  function painted(round, size, count) {
    const { out, write } = ROUNDS[round];
    const material = new ShaderMaterial({
      uniforms,
      defines: look.defines,
      vertexShader: VERTEX,
      fragmentShader: /* glsl */ `
        #include <common>
        ${out}
        ${look.declarations}
        uniform vec3 skinTone;
        uniform float roughness;
        uniform vec4 eyeballs[${eyeballs.length}];
        // It alone looks at an eyeball that is so near.
        float behindLids() {
          float behind = 0.0;
          for (int i = 0; i < ${eyeballs.length}; i++) {
            vec3 way = eyeballs[i].xyz - vRest;
            behind = max(behind, step(length(way), eyeballs[i].w) * smoothstep(0.1, 0.4, dot(normalize(way), normalize(vRestNormal))));
          }
          return behind;
        }
        void main() {
          vec4 diffuseColor = vec4(skinTone, 1.0);
          ${SKIN_GLSL.COLOUR}
          ${write}
        }`,
      depthTest: false,
      side: 2,
      toneMapped: false,
    });
    return coloured(() => paint(renderer, skin.geometry, material, Math.min(size, most), count));
  }
  return { painted, ground: new Color().copyLinearToSRGB(tone).toArray().map((value) => Math.round(255 * value)) };
}

/** @param {ReturnType<typeof paint>} from @param {number} n @param {readonly number[]} ground */
function filled(from, n, ground) {
  const picture = from.picture(n);
  fill(picture, ground);
  return picture;
}

/** @param {Parameters<typeof skinPainter>} of */
export async function skinMaps(...of) {
  const { painted, ground } = skinPainter(...of);
  const both = painted('look', SKIN, 2);
  const open = painted('surface', SURFACE);
  try {
    return {
      colour: await jpeg(filled(both, 0, ground), 0.9),
      normal: await jpeg(filled(both, 1, [128, 128, 255]), 0.85),
      surface: await jpeg(filled(open, 0, [255, 133, 0]), 0.9),
    };
  } finally {
    both.dispose();
    open.dispose();
  }
}

/** The skin's colours alone, no finer than vertices are. @param {Parameters<typeof skinPainter>} of */
export function skinColours(...of) {
  const { painted, ground } = skinPainter(...of);
  const both = painted('look', VERTICES, 2);
  try {
    return filled(both, 0, ground);
  } finally {
    both.dispose();
  }
}

/**
 * An eyeball around its gaze, which is in the middle: away from there by the angle, `EYE_REACH` at the edge.
 * @param {import('three').WebGLRenderer} renderer
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head
 * @param {Coloured} coloured
 */
export function eyeColours(renderer, { eyeLook }, coloured) {
  const material = new ShaderMaterial({
    uniforms: eyeLook,
    vertexShader: 'varying vec2 vAt; void main() { vAt = 2.0 * uv - 1.0; gl_Position = vec4(vAt, 0.0, 1.0); }',
    fragmentShader: /* glsl */ `
      varying vec2 vAt;
      ${EYE_GLSL}
      void main() {
        float away = length(vAt);
        vec2 there = away > 0.0 ? vAt / away * sin(min(away, 0.82) * ${EYE_REACH.toFixed(4)}) : vAt;
        // Lids shade what is near them, more so the upper ones.
        float lit = (1.0 - 0.45 * smoothstep(0.08, 0.4, there.y)) * (1.0 - 0.25 * smoothstep(0.12, 0.4, -there.y));
        gl_FragColor = sRGBTransferOETF(vec4(0.9 * lit * eyeColour(there, smoothstep(0.55, 0.95, abs(there.x))), 1.0));
      }`,
    depthTest: false,
    toneMapped: false,
  });
  const square = new PlaneGeometry(1, 1);
  const painted = coloured(() => paint(renderer, square, material, EYE));
  try {
    return painted.picture();
  } finally {
    painted.dispose();
    square.dispose();
  }
}

/** @param {Parameters<typeof eyeColours>} of */
export const eyeMap = (...of) => jpeg(eyeColours(...of), 0.92);
