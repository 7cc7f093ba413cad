import { ConstantAlphaFactor, CustomBlending, FramebufferTexture, Mesh, NearestFilter, OneMinusConstantAlphaFactor, OrthographicCamera, PlaneGeometry, ShaderMaterial, Vector2 } from 'three';
import { drawnByProcessor } from './graphics.js';

// Smooth edges, and hairs thinner than a pixel: a picture that rests is drawn again between its pixels, and its mean is
// shown.

/** So many times. */
const TIMES = () => (drawnByProcessor() ? 4 : 8);

/**
 * Where the pixels of the `n`th drawing are between those of the first, pixels: as even over a pixel as can be, however
 * many there are (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
 * @param {number} n @returns {[number, number]}
 */
const between = (n) => [((0.5 + 0.7548776662466927 * n) % 1) - 0.5, ((0.5 + 0.5698402909980532 * n) % 1) - 0.5];

/** How much finer than a pixel what is drawn may be: hairs that would be specks in one picture are hairs in a mean. */
export const fineness = { value: 1 };
const FINER = 2.2;

/** @param {import('three').WebGLRenderer} renderer */
export function createAveraging(renderer) {
  const size = new Vector2();
  const sum = { value: /** @type {FramebufferTexture | null} */ (null) };
  // Weighted by a constant, all of it: colours are times their opacity already.
  const material = new ShaderMaterial({
    uniforms: { sum },
    vertexShader: 'void main() { gl_Position = vec4(2.0 * position.xy, 0.0, 1.0); }',
    fragmentShader: 'uniform sampler2D sum; void main() { gl_FragColor = texelFetch(sum, ivec2(gl_FragCoord.xy), 0); }',
    blending: CustomBlending,
    blendSrc: ConstantAlphaFactor,
    blendDst: OneMinusConstantAlphaFactor,
    transparent: true,
    depthTest: false,
    depthWrite: false,
    toneMapped: false,
  });
  const cover = new Mesh(new PlaneGeometry(), material);
  cover.frustumCulled = false;
  const camera = new OrthographicCamera();
  let drawings = 1;

  function keep() {
    if (sum.value) renderer.copyFramebufferToTexture(sum.value);
  }

  return {
    /** Takes what was just drawn for the first. */
    begin() {
      renderer.getDrawingBufferSize(size);
      const { width, height } = sum.value?.image ?? {};
      if (width !== size.x || height !== size.y) {
        sum.value?.dispose();
        sum.value = new FramebufferTexture(size.x, size.y);
        sum.value.minFilter = sum.value.magFilter = NearestFilter;
      }
      drawings = 1;
      keep();
    },
    /**
     * Draws once more, and shows the mean.
     * @param {() => void} draw @param {import('three').PerspectiveCamera} from where it draws
     * @returns {boolean} whether that was the last of them
     */
    add(draw, from) {
      from.setViewOffset(size.x, size.y, ...between(drawings), size.x, size.y);
      fineness.value = FINER;
      draw();
      fineness.value = 1;
      from.clearViewOffset();
      material.blendAlpha = drawings / (drawings + 1);
      renderer.autoClear = false;
      renderer.render(cover, camera);
      renderer.autoClear = true;
      drawings += 1;
      const isLast = drawings > TIMES();
      if (!isLast) keep();
      return isLast;
    },
    dispose() {
      sum.value?.dispose();
      sum.value = null;
      cover.geometry.dispose();
      material.dispose();
    },
  };
}
