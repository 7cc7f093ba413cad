import { BufferAttribute, BufferGeometry, Mesh, ShaderMaterial, Vector4 } from 'three';
import { RUNS_OUT } from '../rendering/backdrop.js';

// The head for the moments before its skin, eyes, lashes and light are made: the model's own colours by a
// lamp and a bright room, a shader that a graphics card has at once.

const VERTEX = /* glsl */ `
  attribute vec3 colour;
  varying vec3 vColour;
  varying vec3 vNormal;
  varying vec3 vPlace;
  void main() {
    vColour = colour;
    vNormal = normal;
    vPlace = position;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }
`;
const FRAGMENT = /* glsl */ `
  varying vec3 vColour;
  varying vec3 vNormal;
  varying vec3 vPlace;
  uniform vec4 eyes[2]; // centre and radius, mm
  uniform vec2 fade; // from which height to which, mm
  void main() {
    vec3 n = normalize(vNormal);
    vec3 lamp = normalize(vec3(-330.0, 360.0, 520.0));
    float key = max(0.0, (dot(n, lamp) + 0.15) / 1.15);
    vec3 room = mix(vec3(0.30, 0.26, 0.24), vec3(0.55, 0.53, 0.52), 0.5 + 0.5 * n.y) * (0.75 + 0.25 * n.z);
    vec3 tone = vColour * vec3(1.05, 0.98, 0.95);
    for (int i = 0; i < 2; i++) {
      vec4 eye = eyes[i];
      if (distance(vPlace, eye.xyz) > 1.02 * eye.w) continue;
      float away = length(vPlace.xy - eye.xy) / eye.w;
      tone = mix(vec3(0.05, 0.03, 0.015), vec3(0.5, 0.47, 0.45), smoothstep(0.44, 0.52, away));
    }
    vec3 lit = pow(tone * (0.95 * room + key * vec3(0.62, 0.58, 0.53)), vec3(1.0 / 2.2));
    gl_FragColor = vec4(min(lit, 1.0), 1.0) * smoothstep(fade.x, fade.y, vPlace.y);
  }
`;

/** sRGB byte to linear. @param {number} byte */
const linear = (byte) => (byte / 255) ** 2.2;

/**
 * @param {import('phiz').FaceModel} model
 * @param {import('../groundwork/groundwork.js').Rest} rest
 * @param {readonly [number, number]} fade the neck runs out between these heights, mm
 */
export function createPreview(model, { positions, normals, triangles: vertices }, fade) {
  const { uvVertices: corners, colours, triangles } = model;
  const geometry = new BufferGeometry();
  // One vertex is enough where a picture is not wrapped around: no seams.
  geometry.setIndex(new BufferAttribute(vertices, 1));
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new BufferAttribute(normals, 3));
  geometry.setAttribute('colour', new BufferAttribute(Float32Array.from(colours, linear), 3));
  const eyes = model.parts
    .filter(({ name }) => /eyeball/.test(name))
    .map(({ first, count }) => {
      // The middle of its box is near enough to its own.
      const low = [Infinity, Infinity, Infinity];
      const high = [-Infinity, -Infinity, -Infinity];
      for (const corner of triangles.subarray(3 * first, 3 * (first + count))) {
        for (let k = 0; k < 3; k++) {
          const x = positions[3 * corners[corner] + k];
          low[k] = Math.min(low[k], x);
          high[k] = Math.max(high[k], x);
        }
      }
      return new Vector4((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2, (high[1] - low[1]) / 2);
    });
  while (eyes.length < 2) eyes.push(new Vector4(0, 0, 0, 0));
  const material = new ShaderMaterial({
    ...RUNS_OUT,
    uniforms: { eyes: { value: eyes.slice(0, 2) }, fade: { value: fade } },
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    toneMapped: false,
  });
  const mesh = new Mesh(geometry, material);
  mesh.name = 'preview';
  mesh.frustumCulled = false;
  return {
    mesh,
    dispose() {
      mesh.removeFromParent();
      geometry.dispose();
      material.dispose();
    },
  };
}
