// What a shader paints on a square, as the bytes of a picture file.

import { Mesh, OrthographicCamera, Scene, WebGLRenderTarget } from 'three';
import { text } from '../text.js';

/** How far what is painted runs out over its edges, pixels: programs that shrink a picture mix neighbours. */
const MARGIN = 32;

/**
 * Paints a geometry by its texture coordinates. What a shader knows of a place is most of the work, so that several pictures are painted
 * at once; a picture that is taken has 64 MB for 4096 pixels a side, and is best taken when the last one has gone.
 * @param {import('three').WebGLRenderer} renderer
 * @param {import('three').BufferGeometry} geometry
 * @param {import('three').ShaderMaterial} material sets alpha where it paints
 * @param {number} size pixels a side
 * @param {number} [count] of pictures
 */
export function paint(renderer, geometry, material, size, count = 1) {
  const target = new WebGLRenderTarget(size, size, { depthBuffer: false, count });
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  const scene = new Scene();
  scene.add(mesh);
  // Also when it is back since: what was painted is gone, and cannot be told from black.
  let isLost = false;
  const lose = () => (isLost = true);
  renderer.domElement.addEventListener('webglcontextlost', lose);
  const before = { target: renderer.getRenderTarget(), alpha: renderer.getClearAlpha(), shadows: renderer.shadowMap.needsUpdate };
  try {
    renderer.setRenderTarget(target);
    renderer.setClearAlpha(0);
    renderer.clear();
    renderer.render(scene, new OrthographicCamera());
  } finally {
    renderer.setRenderTarget(before.target);
    renderer.setClearAlpha(before.alpha);
    renderer.shadowMap.needsUpdate = before.shadows;
    material.dispose();
  }
  return {
    /**
     * @param {number} [n] which one
     * @throws where the graphics card was lost, which leaves every pixel black
     */
    picture(n = 0) {
      const rgba = new Uint8ClampedArray(4 * size * size);
      renderer.readRenderTargetPixels(target, 0, 0, size, size, rgba, undefined, n);
      if (isLost || renderer.getContext().isContextLost()) throw new Error(text.noCard);
      return { size, rgba: upright(rgba, size) };
    },
    dispose() {
      renderer.domElement.removeEventListener('webglcontextlost', lose);
      // A card that is back has nothing of it.
      if (!isLost) target.dispose();
    },
  };
}

/** Its rows from the top, as files have them. @param {Uint8ClampedArray<ArrayBuffer>} rgba @param {number} size */
function upright(rgba, size) {
  const row = 4 * size;
  const spare = new Uint8ClampedArray(row);
  for (let top = 0, end = size - 1; top < end; top++, end--) {
    spare.set(rgba.subarray(top * row, (top + 1) * row));
    rgba.copyWithin(top * row, end * row, (end + 1) * row);
    rgba.set(spare, end * row);
  }
  return rgba;
}

/**
 * Fills what nothing was painted on: near what is, with the nearest of it; elsewhere with one colour.
 * @param {{ size: number, rgba: Uint8ClampedArray<ArrayBuffer> }} picture @param {readonly number[]} ground 0 to 255
 */
export function fill({ size, rgba }, ground) {
  const texels = new Uint32Array(rgba.buffer);
  /** @type {number[]} */
  let rim = [];
  const bare = (/** @type {number} */ at) => rgba[4 * at + 3] === 0;
  for (let at = 0; at < size * size; at++) {
    if (bare(at)) continue;
    const x = at % size;
    if ((x > 0 && bare(at - 1)) || (x < size - 1 && bare(at + 1)) || (at >= size && bare(at - size)) || (at < size * (size - 1) && bare(at + size))) rim.push(at);
  }
  for (let ring = 0; ring < MARGIN; ring++) {
    /** @type {number[]} */
    const next = [];
    for (const at of rim) {
      const x = at % size;
      for (const [there, inside] of /** @type {[number, boolean][]} */ ([[at - 1, x > 0], [at + 1, x < size - 1], [at - size, at >= size], [at + size, at < size * (size - 1)]])) {
        if (!inside || !bare(there)) continue;
        texels[there] = texels[at];
        next.push(there);
      }
    }
    rim = next;
  }
  const [colour] = new Uint32Array(Uint8ClampedArray.of(...ground, 255).buffer);
  for (let at = 0; at < size * size; at++) if (bare(at)) texels[at] = colour;
}

/**
 * @param {{ size: number, rgba: Uint8ClampedArray<ArrayBuffer> }} picture
 * @param {number} quality 0 to 1
 * @returns {Promise<{ mimeType: 'image/jpeg', bytes: Uint8Array }>}
 */
export async function jpeg({ size, rgba }, quality) {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = size;
  const draw = canvas.getContext('2d');
  if (!draw) throw new Error('this browser has no room for a picture of that size');
  draw.putImageData(new ImageData(rgba, size, size), 0, 0);
  const blob = await new Promise((/** @type {(blob: Blob | null) => void} */ done) => canvas.toBlob(done, 'image/jpeg', quality));
  canvas.width = canvas.height = 0;
  if (!blob) throw new Error('the picture of the skin could not be made');
  return { mimeType: 'image/jpeg', bytes: new Uint8Array(await blob.arrayBuffer()) };
}
