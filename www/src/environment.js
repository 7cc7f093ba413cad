import { CubeTexture, DataTexture, DataUtils, HalfFloatType, LinearFilter, LinearMipmapLinearFilter, RGBAFormat } from 'three';

/** What the studio sends to a surface of each direction: `harmonics` of the studio has the order. */
export const studioUniforms = { studioLight: { value: new Float32Array(27) } };

/** What `getIBLIrradiance` of three.js reads from a cube map, without one. */
export const STUDIO_GLSL = /* glsl */ `
  uniform vec3 studioLight[9];
  vec3 studioLightOn(vec3 n) {
    return studioLight[0] + studioLight[1] * n.y + studioLight[2] * n.z + studioLight[3] * n.x
      + studioLight[4] * (n.x * n.y) + studioLight[5] * (n.y * n.z) + studioLight[6] * (3.0 * n.z * n.z - 1.0)
      + studioLight[7] * (n.x * n.z) + studioLight[8] * (n.x * n.x - n.y * n.y);
  }
`;

/** @param {{ levels: import('./groundwork/studio.js').Level[], light: Float32Array<ArrayBuffer> }} studio */
export function createEnvironment({ levels, light }) {
  studioUniforms.studioLight.value = light;
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
