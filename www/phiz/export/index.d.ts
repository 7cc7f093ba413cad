/**
 * A face as files that other programs read. Each function gives the bytes of one file, which shows
 * the face with its expression.
 */

import type { Face } from 'phiz';

/**
 * Wavefront OBJ, text: positions in millimetres (y up) with sRGB colours behind them, texture
 * coordinates, normals, and a group for each of the model's parts. Vertex i of the file is vertex
 * i of the model.
 *
 * @param options `colours`: those of this face, sRGB, three a vertex, in place of the model's
 */
export function toObj(face: Face, options?: { colours?: Uint8Array | Uint8ClampedArray | undefined }): Uint8Array<ArrayBuffer>;

/**
 * Binary little-endian PLY: positions in millimetres (y up), normals, sRGB colours. Vertex i of the
 * file is vertex i of the model.
 *
 * @param options `colours`: those of this face, sRGB, three a vertex, in place of the model's
 */
export function toPly(face: Face, options?: { colours?: Uint8Array | Uint8ClampedArray | undefined }): Uint8Array<ArrayBuffer>;

/** Binary STL in millimetres, turned as slicers want it: z up, the face looks along -y. */
export function toStl(face: Face): Uint8Array<ArrayBuffer>;

/** What one control does to a face. */
export interface MorphTarget {
  /** The control's name. */
  readonly name: string;
  /** The feature it belongs to. */
  readonly group: string;
  /**
   * `[coefficient, change in sigmas]` of weight 1. For a mode that is one coefficient and 1; for any
   * other control half the way from its 15.87th to its 84.13th percentile, measured from the
   * median person: one standard deviation, where it is distributed normally.
   */
  readonly direction: readonly (readonly [number, number])[];
  /** How far weight 1 moves each vertex, mm, three numbers a vertex. */
  readonly positions: Float32Array;
  /** How weight 1 changes each normal, to first order. */
  readonly normals: Float32Array;
}

/**
 * A morph target for each control of the face's model, in their order. Vertices are linear in the
 * coefficients: the face plus weights times targets is exactly the face whose coefficients are
 * moved by weights times directions.
 * @throws Error when a control is in another unit than percentiles
 */
export function morphTargets(face: Face): MorphTarget[];

/** What an expression does to a face. */
export interface ExpressionTarget {
  /** The expression's name, which is ARKit's. */
  readonly name: string;
  /** How far weight 1 moves each vertex, mm, three numbers a vertex. */
  readonly positions: Float32Array;
  /** How weight 1 changes each normal. */
  readonly normals: Float32Array;
}

/**
 * A target for each expression that the model has loaded, measured on this face at rest. Each at
 * weight 1 is exactly the face with that expression. Between, and together, targets go straight
 * ways, where lids in this package slide on the eyeball.
 */
export function expressionTargets(face: Face): ExpressionTarget[];

/** Whether a part is an eyeball. */
export function isEyeball(part: { readonly name: string }): boolean;

/**
 * The model's texture coordinates (`FaceModel.uvs`), but for the corners of eyeballs, which lie as `Appearance.eyes` has them.
 *
 * @param reach the angle at the edge of the eyes' picture, radians
 */
export function aroundGaze(face: Face, reach: number): Float32Array;

/** A picture as the bytes of a file. */
export interface Picture {
  readonly mimeType: 'image/jpeg' | 'image/png';
  readonly bytes: Uint8Array;
}

/** A mesh beside the face, such as a row of teeth. */
export interface Part {
  readonly name: string;
  /** In the face at rest, mm, three numbers a vertex. */
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  /** Linear, 0 to 1, three numbers a vertex. */
  readonly colours: Float32Array;
  readonly triangles: Uint32Array;
  readonly roughness: number;
  /** 0 to 1, as glTF has it; 0 by default. */
  readonly metalness?: number | undefined;
  /** 0 to 1: less than 1, the default, is seen through. */
  readonly opacity?: number | undefined;
  /** By a control's or an expression's name how far weight 1 of it moves each vertex, mm. */
  readonly targets: Readonly<Record<string, Float32Array>>;
}

/** How a face looks, in place of the model's colour a vertex. */
export interface Appearance {
  /**
   * In the model's texture coordinates: colours as sRGB, normals in the tangents' axes, and in red how open to
   * light the skin is and in green how rough.
   */
  readonly skin: { readonly colour: Picture; readonly normal: Picture; readonly surface: Picture };
  /**
   * Both eyeballs: around the gaze, which is in the middle, away from there by the angle, `reach` (radians) at
   * the edge.
   */
  readonly eyes?: { readonly colour: Picture; readonly reach: number } | undefined;
  /** Those without a vertex or a triangle are left out. */
  readonly parts?: readonly Part[] | undefined;
}

/**
 * Binary glTF 2.0, in metres as glTF has it (y up, the face looks along +z). One mesh: vertex i < N
 * is vertex i of the model, those behind repeat vertices on a seam of the texture coordinates.
 * Colours are per vertex.
 *
 * @param options `targets` (default true) adds a morph target for each control, and for each
 *   expression that the model has loaded, named in `mesh.extras.targetNames`; see `MorphTarget` for
 *   what a weight means. The mesh is then the face at rest, and the weights are its expression. `targetNormals` (default
 *   true) gives them normals, which doubles the file; programs that compute normals need none. `appearance` puts
 *   pictures on skin and eyeballs, which then have no colour a vertex, and meshes beside the face, each a node
 *   whose targets have the names of the face's. `measured` is what `morphTargets` and `expressionTargets` gave for this
 *   face, for who has called them: they are most of the work.
 * @throws Error when an appearance is of what no glTF can be, naming the part and what is wrong of it
 */
export function toGlb(
  face: Face,
  options?: {
    targets?: boolean | undefined;
    targetNormals?: boolean | undefined;
    appearance?: Appearance | undefined;
    measured?: { controls: readonly MorphTarget[]; expressions: readonly ExpressionTarget[] } | undefined;
  },
): Uint8Array<ArrayBuffer>;
