/** @typedef {import('phiz').PhotoField} Field */

const VERTEX = /* glsl */ `#version 300 es
  // One triangle over everything.
  void main() {
    gl_Position = vec4(vec2(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1), 0.0, 1.0);
  }`;

// As Field::render in src/photo/reshape/render.rs, which is the same for the processor where a photo is opaque.
const FRAGMENT = /* glsl */ `#version 300 es
  precision highp float;
  precision highp sampler2D;
  uniform sampler2D photo;
  uniform sampler2D motion;
  uniform sampler2D gain;
  uniform bool changed;
  uniform float strength;
  uniform float split;    // px from the left; before it the photo is as it was
  uniform float upside;   // the height, px, when rows are counted from above; or 0
  uniform vec2 place;     // where the first pixel of what is drawn is in the texture, px
  uniform vec2 origin;    // where the first node is in the texture, px
  uniform float nodeStep; // px
  uniform float scale;    // px of the texture for a px of the field
  out vec4 colour;

  vec3 linear(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(vec3(0.04045), c));
  }
  vec3 encoded(vec3 c) {
    return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), c));
  }
  // Catmull and Rom's weights: linear interpolation would blur pores and hair.
  vec4 weights(float t) {
    vec4 powers = vec4(1.0, t, t * t, t * t * t);
    return 0.5 * vec4(
      dot(powers, vec4(0.0, -1.0, 2.0, -1.0)), dot(powers, vec4(2.0, 0.0, -5.0, 3.0)),
      dot(powers, vec4(0.0, 1.0, 4.0, -3.0)), dot(powers, vec4(0.0, 0.0, -1.0, 1.0)));
  }

  void main() {
    vec2 at = gl_FragCoord.xy;
    if (upside > 0.0) at.y = upside - at.y;
    ivec2 own = ivec2(floor(at + place));
    colour = texelFetch(photo, own, 0);
    vec2 node = (at + place - origin) / nodeStep;
    ivec2 most = textureSize(motion, 0) - 1;
    bool outside = any(lessThan(node, vec2(0.0))) || any(greaterThan(node, vec2(most)));
    if (!changed || outside || at.x < split) return;
    ivec2 first = min(ivec2(node), most - 1);
    vec2 part = node - vec2(first);
    vec2 moved = vec2(0.0);
    vec3 lit = vec3(0.0);
    bool still = true;
    for (int i = 0; i < 4; i++) {
      ivec2 corner = ivec2(i & 1, i >> 1);
      vec2 near = mix(1.0 - part, part, vec2(corner));
      vec2 motionHere = texelFetch(motion, first + corner, 0).xy;
      vec3 gainHere = texelFetch(gain, first + corner, 0).xyz;
      still = still && motionHere == vec2(0.0) && gainHere == vec3(1.0);
      moved += near.x * near.y * motionHere;
      lit += near.x * near.y * gainHere;
    }
    if (still) return;
    moved *= strength * scale;
    vec2 whole = floor(moved);
    vec4 across = weights(moved.x - whole.x);
    vec4 down = weights(moved.y - whole.y);
    ivec2 last = textureSize(photo, 0) - 1;
    // A colour counts by how much of it is seen, and what is seen through moves like everything.
    vec4 sum = vec4(0.0);
    bool opaque = true;
    for (int j = 0; j < 4; j++) {
      vec4 line = vec4(0.0);
      for (int i = 0; i < 4; i++) {
        ivec2 texel = clamp(own + ivec2(whole) + ivec2(i, j) - 1, ivec2(0), last);
        vec4 tap = texelFetch(photo, texel, 0);
        opaque = opaque && tap.a == 1.0;
        line += across[i] * vec4(tap.rgb * tap.a, tap.a);
      }
      sum += down[j] * line;
    }
    colour.a = opaque ? 1.0 : min(sum.a, 1.0);
    if (colour.a < 0.5 / 255.0) {
      colour = vec4(0.0);
      return;
    }
    // Without transparency the weights are one but for rounding.
    if (!opaque) sum.rgb /= sum.a;
    sum.rgb = clamp(sum.rgb, 0.0, 1.0);
    colour.rgb = encoded(min(linear(sum.rgb) * pow(lit, vec3(strength)), 1.0));
  }`;

/** Photos are drawn at full size in squares of so many pixels a side. */
const TILE = 1024;
/** What is read around a square besides the motion: the outer taps. */
const TAPS = 3;

/** @param {HTMLCanvasElement} canvas */
function contextOf(canvas) {
  // Colours are not multiplied by how much of them is seen, here nor in the file that is saved.
  const gl = canvas.getContext('webgl2', { antialias: false, depth: false, preserveDrawingBuffer: true, premultipliedAlpha: false });
  if (!gl) throw new Error('WebGL2 is not available');
  return gl;
}

/**
 * Draws a photo, changed as a field says, with the graphics card.
 *
 * @param {HTMLCanvasElement} canvas it takes the photo's size
 * @throws Error when there is no WebGL2
 */
export function createWarp(canvas) {
  const gl = contextOf(canvas);
  const UNIFORMS = /** @type {const} */ ([
    'photo', 'motion', 'gain', 'changed', 'strength', 'split', 'upside', 'place', 'origin', 'nodeStep', 'scale',
  ]);
  /** @type {Record<typeof UNIFORMS[number], WebGLUniformLocation | null>} */
  let uniform;
  /** @type {WebGLTexture[]} */
  let textures = [];
  /** @type {ImageBitmap | HTMLCanvasElement | null} */
  let shown = null;
  /** Its colours. @type {PredefinedColorSpace} */
  let space = 'srgb';
  /** What is drawn, to be drawn again. @type {[Field | null, { strength: number, split: number | null, scale: number }]} */
  let last = [null, { strength: 1, split: null, scale: 1 }];

  /** @param {number} type @param {string} source */
  function compile(type, source) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(type));
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
      throw new Error(`the photo's shader does not compile: ${gl.getShaderInfoLog(shader)}`);
    }
    return shader;
  }

  function prepare() {
    const program = /** @type {WebGLProgram} */ (gl.createProgram());
    gl.attachShader(program, compile(gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(program);
    gl.useProgram(program);
    uniform = /** @type {typeof uniform} */ (
      Object.fromEntries(UNIFORMS.map((name) => [name, gl.getUniformLocation(program, name)]))
    );
    textures = ['photo', 'motion', 'gain', 'part'].map(() => {
      const texture = /** @type {WebGLTexture} */ (gl.createTexture());
      gl.bindTexture(gl.TEXTURE_2D, texture);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
      for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
      return texture;
    });
    gl.uniform1i(uniform.photo, 0);
    gl.uniform1i(uniform.motion, 1);
    gl.uniform1i(uniform.gain, 2);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    // Colours as they are, or what does not move would change.
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    useSpace();
  }
  /** Without the one the other would change colours. */
  function useSpace() {
    if ('unpackColorSpace' in gl && 'drawingBufferColorSpace' in gl) gl.unpackColorSpace = gl.drawingBufferColorSpace = space;
  }

  /** @param {TexImageSource} photo */
  function upload(photo) {
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, textures[0]);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, photo);
  }

  /** @param {Field | null} field */
  function uploadField(field) {
    gl.uniform1i(uniform.changed, field ? 1 : 0);
    const size = field ? [field.columns, field.rows] : [1, 1];
    /** @type {[number, number, number, Float32Array][]} */
    const images = [
      [1, gl.RG32F, gl.RG, field?.motion ?? new Float32Array(2)],
      [2, gl.RGB32F, gl.RGB, field?.gain ?? new Float32Array(3)],
    ];
    for (const [unit, inside, format, numbers] of images) {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, textures[unit]);
      gl.texImage2D(gl.TEXTURE_2D, 0, inside, size[0], size[1], 0, format, gl.FLOAT, numbers);
    }
  }

  /**
   * Where a field is in a texture whose first pixel is at (x, y) of the photo.
   * @param {Field | null} field @param {number} strength @param {number} scale @param {number} x @param {number} y
   */
  function put(field, strength, scale, x = 0, y = 0) {
    gl.uniform1f(uniform.strength, strength);
    gl.uniform1f(uniform.scale, scale);
    gl.uniform1f(uniform.nodeStep, (field?.step ?? 1) * scale);
    gl.uniform2f(uniform.origin, (field?.left ?? 0) * scale - x, (field?.top ?? 0) * scale - y);
  }

  function redraw() {
    if (!shown || gl.isContextLost()) return;
    const [field, { strength, split, scale }] = last;
    uploadField(field);
    put(field, strength, scale);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, textures[0]);
    gl.uniform1f(uniform.split, split === null ? -1 : split * canvas.width);
    gl.uniform1f(uniform.upside, canvas.height);
    gl.uniform2f(uniform.place, 0, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  prepare();
  canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
  canvas.addEventListener('webglcontextrestored', () => {
    prepare();
    if (shown) upload(shown);
    redraw();
  });

  return {
    get lost() {
      return gl.isContextLost();
    },
    /** @param {ImageBitmap | HTMLCanvasElement} photo not premultiplied; it is kept, to be drawn again @param {PredefinedColorSpace} colours */
    setPhoto(photo, colours) {
      shown = photo;
      space = colours;
      useSpace();
      canvas.width = photo.width;
      canvas.height = photo.height;
      upload(photo);
      last = [null, { ...last[1], split: null }];
      redraw();
    },
    /** There is no photo any more, here nor with the graphics card. */
    clear() {
      shown = null;
      last = [null, { ...last[1], split: null }];
      canvas.width = canvas.height = 1;
      for (const unit of [0, 3]) {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, textures[unit]);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
      }
      uploadField(null);
    },
    /**
     * @param {Field | null} field null: nothing changes
     * @param {{ strength?: number, split?: number | null, scale?: number }} [options] how much of the change is
     *   shown, left of which part of the width it is not, px of this photo for a px of the field's
     */
    draw(field, { strength = 1, split = null, scale = 1 } = {}) {
      last = [field, { strength, split, scale }];
      redraw();
    },
    /**
     * Changes a photo of any size where it is, square by square. What a square is made of reaches into those
     * around it, so each is put back when nothing is read any more of where it is.
     * @param {OffscreenCanvasRenderingContext2D} context of a canvas that holds the photo
     * @param {Field} field
     * @param {{ strength: number, scale: number }} options
     */
    render(context, field, { strength, scale }) {
      const photo = context.canvas;
      let most = 0;
      for (const motion of field.motion) most = Math.max(most, Math.abs(motion));
      const around = Math.ceil(most * strength * scale) + TAPS;
      const left = Math.max(0, Math.floor(field.left * scale));
      const top = Math.max(0, Math.floor(field.top * scale));
      const right = Math.min(photo.width, Math.ceil((field.left + (field.columns - 1) * field.step) * scale));
      const bottom = Math.min(photo.height, Math.ceil((field.top + (field.rows - 1) * field.step) * scale));
      const target = gl.createTexture();
      const frame = gl.createFramebuffer();
      /** @type {[ImageData, number, number][]} */
      let made = [];
      /** Puts back what ends above a row. @param {number} row */
      const putBack = (row) => {
        made = made.filter(([pixels, x, y]) => {
          if (y + pixels.height > row) return true;
          context.putImageData(pixels, x, y);
          return false;
        });
      };
      try {
        for (let y = top; y < bottom; y += TILE) {
          putBack(y - around);
          for (let x = left; x < right; x += TILE) {
            const [width, height] = [Math.min(TILE, right - x), Math.min(TILE, bottom - y)];
            const [from, above] = [Math.max(0, x - around), Math.max(0, y - around)];
            const to = Math.min(photo.width, x + width + around);
            const below = Math.min(photo.height, y + height + around);
            const part = context.getImageData(from, above, to - from, below - above);
            if (gl.isContextLost()) throw new Error('the graphics card was lost while the photo was drawn');
            // Its numbers, in whichever colours.
            gl.activeTexture(gl.TEXTURE0);
            gl.bindTexture(gl.TEXTURE_2D, textures[3]);
            gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, part.width, part.height, 0, gl.RGBA, gl.UNSIGNED_BYTE, part.data);
            gl.activeTexture(gl.TEXTURE3);
            gl.bindTexture(gl.TEXTURE_2D, target);
            gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
            gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
            gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
            gl.viewport(0, 0, width, height);
            uploadField(field);
            put(field, strength, scale, from, above);
            gl.uniform1f(uniform.split, -1);
            gl.uniform1f(uniform.upside, 0);
            gl.uniform2f(uniform.place, x - from, y - above);
            gl.drawArrays(gl.TRIANGLES, 0, 3);
            const pixels = context.createImageData(width, height);
            gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(pixels.data.buffer));
            made.push([pixels, x, y]);
          }
        }
        putBack(Infinity);
      } finally {
        gl.deleteFramebuffer(frame);
        gl.deleteTexture(target);
        redraw();
      }
    },
  };
}
