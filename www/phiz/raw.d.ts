// The classes that wasm-bindgen makes of `src/wasm`, as `index.js` uses them. Not part of the
// package: it lets `tsc` check the wrapper before any wasm is built.

export class IncomingModel {
  constructor();
  push(bytes: Uint8Array): void;
  finish(keep: boolean): FaceModel;
  free(): void;
}

export class FaceModel {
  private constructor();
  blob(): Uint8Array;
  info(): import('phiz').ModelInfo;
  face(): Face;
  from_code(code: string): Face;
  uv_triangles(): Uint32Array;
  uvs(): Float32Array;
  uv_vertices(): Uint32Array;
  colours(): Uint8Array;
  region_of(): Uint8Array;
  mirror(): Uint32Array;
  vertex_count(): number;
  free(): void;
}

export class Expressions {
  private constructor();
  static parse(bytes: Uint8Array, model: FaceModel): Expressions;
  names(): string[];
  free(): void;
}

export class Face {
  private constructor();
  set(control: string, value: number): void;
  get(control: string): number;
  reset(region?: string): void;
  blend(other: Face, t: number, regions?: string[]): void;
  attribute(name: string): number;
  set_attributes(names: string[], values: Float32Array): void;
  randomize(
    seed: number | undefined,
    spread: number | undefined,
    regions: string[] | undefined,
    attributes: string[],
    values: Float32Array,
  ): number;
  lock(region: string): void;
  unlock(region: string): void;
  locked(): string[];
  measure(name: string): number;
  set_measure(name: string, value: number): void;
  clear(control: string): void;
  lock_measure(name: string): void;
  unlock_measure(name: string): void;
  locked_measures(): string[];
  drag(vertex: number, x: number, y: number, z: number): void;
  express(expressions: Expressions, name: string, weight: number): void;
  weights(): Float32Array;
  relax(): void;
  code(): string;
  set_code(code: string): void;
  coefficients(): Float32Array;
  set_coefficients(coefficients: Float32Array): void;
  alpha(): number;
  set_alpha(mm: number): void;
  positions_ptr(): number;
  normals_ptr(): number;
  changed_first(): number;
  changed_end(): number;
  duplicate(): Face;
  free(): void;
}

export default function init(source: {
  module_or_path: import('./index.js').Wasm;
}): Promise<{ memory: WebAssembly.Memory }>;
