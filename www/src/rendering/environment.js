import { CubeTexture, DataTexture, DataUtils, HalfFloatType, LinearFilter, LinearMipmapLinearFilter, RGBAFormat, Vector4 } from 'three';

/** @type {import('three').Texture} */
const dark = new DataTexture(new Uint8Array(4), 1, 1);

/**
 * What the studio sends to a surface of each direction (`harmonics` of the studio has the order), and what one
 * mirrors (its `folded`).
 */
export const studioUniforms = {
  studioLight: { value: new Float32Array(27) },
  studioMirror: { value: dark },
  studioFold: { value: new Vector4() },
};

/** What `getIBLIrradiance` and `getIBLRadiance` of three.js read from a cube map, without one. */
export const STUDIO_GLSL = /* glsl */ `
  uniform vec3 studioLight[9];
  vec3 studioLightOn(vec3 n) {
    return studioLight[0] + studioLight[1] * n.y + studioLight[2] * n.z + studioLight[3] * n.x
      + studioLight[4] * (n.x * n.y) + studioLight[5] * (n.y * n.z) + studioLight[6] * (3.0 * n.z * n.z - 1.0)
      + studioLight[7] * (n.x * n.z) + studioLight[8] * (n.x * n.x - n.y * n.y);
  }
  uniform sampler2D studioMirror;
  uniform vec4 studioFold; // from the middle to an edge; the first roughness, one over the way to the second; brightest
  vec3 studioMirrored(vec3 way, float roughness) {
    way /= abs(way.x) + abs(way.y) + abs(way.z);
    vec2 at = way.y < 0.0 ? (1.0 - abs(way.zx)) * vec2(way.x < 0.0 ? -1.0 : 1.0, way.z < 0.0 ? -1.0 : 1.0) : way.xz;
    at = at * studioFold.x + 0.5;
    at.y *= 0.5;
    // Without derivatives: they jump at the folds.
    vec3 mirrored = mix(
      textureLod(studioMirror, at, 0.0).rgb,
      textureLod(studioMirror, at + vec2(0.0, 0.5), 0.0).rgb,
      clamp((roughness - studioFold.y) * studioFold.z, 0.0, 1.0));
    return studioFold.w * mirrored * mirrored;
  }
`;

/** @param {ReturnType<typeof import('../groundwork/studio.js').studio>} studio */
export function createEnvironment({ levels, light, flat }) {
  studioUniforms.studioLight.value = light;
  const [shine, sheen] = flat.roughness;
  // All scenes of a page share it, and all studios are the same: another one would stay on the card of each beside the last.
  if (studioUniforms.studioMirror.value === dark) {
    const mirror = new DataTexture(flat.texels, flat.side, 2 * flat.side);
    mirror.magFilter = mirror.minFilter = LinearFilter;
    mirror.needsUpdate = true;
    studioUniforms.studioMirror.value = mirror;
  }
  studioUniforms.studioFold.value.set(0.5 - 0.5 / flat.side, shine, 1 / (sheen - shine), flat.brightest);
  const images = levels.map(({ size, faces }) =>
    faces.map((texels) => {
      const half = new Uint16Array(4 * size * size);
      for (let i = 0; i < size * size; i++) {
        for (let k = 0; k < 3; k++) half[4 * i + k] = DataUtils.toHalfFloat(texels[3 * i + k]);
        half[4 * i + 3] = 0x3c00;
      }
      return new DataTexture(half, size, size, RGBAFormat, HalfFloatType);
    }),
  );
  const texture = new CubeTexture(images[0]);
  texture.mipmaps = images.slice(1).map((image) => new CubeTexture(image));
  texture.format = RGBAFormat;
  texture.type = HalfFloatType;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = false;
  texture.isPMREMTexture = true;
  texture.needsUpdate = true;
  return texture;
}
