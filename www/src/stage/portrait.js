import { Vector2 } from 'three';
import { createAveraging } from '../rendering/averaging.js';
import { backdropUniforms } from '../rendering/backdrop.js';
import { text } from '../text.js';

/** The smallest picture that is one, pixels a side. */
const LEAST = 16;
/** Of larger ones nobody sees single pixels, and their mean takes memory: pixels. */
const MOST_AVERAGED = 4096 ** 2;

/**
 * The view as a PNG of any size, whatever the size of the page; without the wall behind the head
 * where `transparent` is asked for. The height shows what the page's height shows.
 *
 * @param {{
 *   renderer: import('three').WebGLRenderer,
 *   camera: import('three').PerspectiveCamera,
 *   render: (width: number, height: number) => void,
 *   invalidate: () => void,
 * }} view
 * @param {{ width: number, height: number, transparent?: boolean }} options pixels
 * @returns {Promise<Blob>}
 * @throws RangeError when the graphics card draws no picture of that size, Error when it was lost
 */
export function portrait(view, { width, height, transparent = false }) {
  const { renderer, camera } = view;
  const gl = renderer.getContext();
  // One that is lost knows no limits, and leaves an empty picture when it goes.
  const held = () => {
    if (gl.isContextLost()) throw new Error(text.noCard);
  };
  held();
  const most = Math.min(gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), ...gl.getParameter(gl.MAX_VIEWPORT_DIMS));
  for (const side of [width, height]) {
    if (!Number.isInteger(side) || side < LEAST || side > most) {
      throw new RangeError(`a picture has ${LEAST} to ${most} pixels a side here, not ${typeof side === 'string' ? `"${side}"` : side}`);
    }
  }
  const canvas = renderer.domElement;
  const before = {
    size: renderer.getSize(new Vector2()),
    buffer: renderer.getDrawingBufferSize(new Vector2()),
    ratio: renderer.getPixelRatio(),
    aspect: camera.aspect,
    alpha: renderer.getClearAlpha(),
  };
  /** @param {Vector2} pixels @param {Vector2} size in those of the renderer @param {number} aspect @param {number} opacity */
  function draw(pixels, size, aspect, opacity) {
    backdropUniforms.backdropSize.value.copy(pixels);
    backdropUniforms.backdropOpacity.value = opacity;
    camera.aspect = aspect;
    camera.updateProjectionMatrix();
    view.render(size.x, size.y);
  }
  /** What was drawn gets smooth edges. @param {Vector2} size */
  function smooth({ x, y }) {
    const averaging = createAveraging(renderer);
    averaging.begin();
    while (!averaging.add(() => view.render(x, y), camera));
    averaging.dispose();
  }
  try {
    renderer.setPixelRatio(1);
    renderer.setSize(width, height, false);
    // Browsers may make the drawing buffer smaller than the canvas.
    if (gl.drawingBufferWidth !== width || gl.drawingBufferHeight !== height) {
      throw new RangeError(`the graphics card has no room for a picture of ${width} x ${height} pixels`);
    }
    renderer.setClearAlpha(transparent ? 0 : 1);
    const pixels = new Vector2(width, height);
    draw(pixels, pixels, width / height, transparent ? 0 : 1);
    if (width * height <= MOST_AVERAGED) smooth(pixels);
    held();
    // The pixels are taken at once, the compression happens later.
    return new Promise((done, fail) => {
      canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error(text.noPicture))), 'image/png');
    });
  } finally {
    renderer.setClearAlpha(before.alpha);
    renderer.setPixelRatio(before.ratio);
    renderer.setSize(before.size.x, before.size.y, false);
    draw(before.buffer, before.size, before.aspect, 1);
    view.invalidate();
  }
}
