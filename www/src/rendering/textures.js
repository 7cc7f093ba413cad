import { DataTexture, LinearFilter, LinearMipmapLinearFilter, RepeatWrapping, RGBAFormat } from 'three';
import { drawnByProcessor } from './graphics.js';

/** A square picture. @typedef {{ size: number, rgba: Uint8Array | Uint8ClampedArray }} Pixels */

/** Sharp at a slant too, where that costs little. @param {import('three').Texture} map @param {number} samples */
export function sharpen(map, samples) {
  if (!drawnByProcessor()) map.anisotropy = samples;
}

/** @param {Pixels} pixels */
export function createMap({ size, rgba }) {
  const map = new DataTexture(rgba, size, size, RGBAFormat);
  map.magFilter = LinearFilter;
  map.minFilter = LinearMipmapLinearFilter;
  map.generateMipmaps = true;
  sharpen(map, 4);
  map.needsUpdate = true;
  return map;
}

/** One that goes on and on. @param {Pixels} pixels */
export function createTile(pixels) {
  const tile = createMap(pixels);
  tile.wrapS = tile.wrapT = RepeatWrapping;
  return tile;
}
