// The classes that wasm-bindgen makes of `src/wasm/photo.rs`, as `index.js` uses them. Not part of the
// package: it lets `tsc` check the wrapper before any wasm is built.

export class Fitter {
  private constructor();
  static parse(model: Uint8Array, expressions?: Uint8Array): Fitter;
  fit(
    photo: Float64Array,
    others: Float64Array,
    rgba: Uint8Array | Uint8ClampedArray | undefined,
    images: (Uint8Array | Uint8ClampedArray)[],
    told?: (part: number) => void,
  ): import('phiz').PhotoFit;
  free(): void;
}

export class PhotoEdit {
  private constructor();
  static open(
    fitter: Fitter,
    size: Uint32Array,
    camera: Float64Array,
    light: Float64Array,
    code: string,
    weights: Float64Array,
  ): PhotoEdit;
  also(
    size: Uint32Array,
    camera: Float64Array,
    code: string,
    weights: Float64Array,
    rgba: Uint8Array,
    finer: Uint8Array | undefined,
    place: Float64Array,
  ): boolean;
  set_background(rgba: Uint8Array): void;
  field(code: string, weights: Float64Array): import('phiz').PhotoField | null;
  render(rgba: Uint8Array | Uint8ClampedArray, code: string, weights: Float64Array): Uint8Array<ArrayBuffer>;
  texture(rgba: Uint8Array | Uint8ClampedArray, size: number, finer: Uint8Array | undefined, place: Float64Array): Uint8Array<ArrayBuffer>;
  looks(rgba: Uint8Array | Uint8ClampedArray, irises: Float64Array): import('phiz').PhotoLooks;
  albedos(rgba: Uint8Array | Uint8ClampedArray, corners: Uint32Array, shares: Float32Array): Float32Array<ArrayBuffer>;
  free(): void;
}

declare const init: (options: {
  module_or_path: import('./index.js').Wasm;
}) => Promise<{ memory: WebAssembly.Memory }>;
export default init;
