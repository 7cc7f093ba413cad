import { BufferAttribute, BufferGeometry, Color, CustomBlending, Mesh, OneFactor, ShaderMaterial, Vector2 } from 'three';

/**
 * Of a material that runs out into what was drawn before it: the wall, hair behind the neck, or nothing where the wall is
 * left out. Its colours are times their opacity.
 */
export const RUNS_OUT = /** @type {const} */ ({ blending: CustomBlending, blendSrc: OneFactor });

// The studio wall, a function of the pixel alone.
const FRAGMENT = /* glsl */ `
  uniform vec3 backdropCentre;
  uniform vec3 backdropEdge;
  uniform vec2 backdropSize;
  uniform float backdropOpacity;
  void main() {
    vec2 at = gl_FragCoord.xy / backdropSize - vec2(0.5, 0.56);
    at.x *= min(backdropSize.x / backdropSize.y, 1.35);
    float away = smoothstep(0.0, 0.95, length(at));
    // Half a step of noise hides the bands of an eight-bit gradient.
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    gl_FragColor = vec4(mix(backdropCentre, backdropEdge, away) + (noise - 0.5) / 255.0, 1.0) * backdropOpacity;
  }
`;

/** Shared by every material that shows the backdrop. */
export const backdropUniforms = {
  backdropCentre: { value: new Color() },
  backdropEdge: { value: new Color() },
  backdropSize: { value: new Vector2(1, 1) },
  /** 1, or 0 for a picture of the head alone. */
  backdropOpacity: { value: 1 },
};

const WALLS = {
  light: { centre: [0.965, 0.96, 0.95], edge: [0.8, 0.805, 0.81] },
  dark: { centre: [0.225, 0.235, 0.25], edge: [0.06, 0.065, 0.075] },
};

/** @param {'light' | 'dark'} theme */
export function paintBackdrop(theme) {
  const { centre, edge } = WALLS[theme];
  backdropUniforms.backdropCentre.value.fromArray(centre);
  backdropUniforms.backdropEdge.value.fromArray(edge);
}

/** One triangle over the whole screen, behind everything. */
export function createBackdrop() {
  const geometry = new BufferGeometry();
  geometry.setAttribute(
    'position',
    new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3),
  );
  const material = new ShaderMaterial({
    uniforms: backdropUniforms,
    vertexShader: 'void main() { gl_Position = vec4(position.xy, 1.0, 1.0); }',
    fragmentShader: FRAGMENT,
    depthTest: false,
    depthWrite: false,
    toneMapped: false,
  });
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.renderOrder = -1;
  return mesh;
}
