/**
 * phiz: design 3D human faces. A statistical face model in WebAssembly, for pages and for Node.
 *
 * Lengths are millimetres; y is up, z comes out of the face, x goes to the subject's left.
 * Control values are percentiles of the population in [0, 1]: 0.5 is the median.
 */

/**
 * Reads a model.
 *
 * @param file a `.phiz` file: a blob, packed as gzip or not. Bytes are copied; you may drop them
 *   afterwards. Of a response, such as `await fetch('model.phiz')`, or a stream, what comes in is
 *   inflated and read while the rest is still on its way.
 * @param options `build` forces one of the two wasm builds; by default the faster one that this
 *   machine can run.
 * @throws Error with the reason when the bytes are not a usable blob, or do not come.
 */
export function load(
  file: Uint8Array | ArrayBuffer | Blob | Response | ReadableStream<Uint8Array | ArrayBuffer>,
  options?: { build?: 'simd' | 'scalar' | undefined },
): Promise<FaceModel>;

/** A compiled module, where the types of the platform know such: Node's own do not. */
export type WasmModule = typeof globalThis extends { WebAssembly: { Module: { prototype: infer Module } } } ? Module : object;

/** A wasm file of this package as its user has it: where it is, a response that brings it, its bytes, or compiled. */
export type Wasm = string | URL | Response | ArrayBuffer | ArrayBufferView | WasmModule;

/**
 * Fetches and compiles the module before there is a model to read: `load` waits for less.
 *
 * @param options `wasm` is the module where a bundler does not find it by itself: `phiz/simd/phiz_bg.wasm` or
 *   `phiz/scalar/phiz_bg.wasm`, whichever `build` is. It counts before anything else has asked for that build.
 * @throws Error when it does not come; `load` tries again
 */
export function prepare(options?: { build?: 'simd' | 'scalar' | undefined; wasm?: Wasm | undefined }): Promise<void>;

/** The build that `load` takes by itself: `simd` where 128-bit instructions work. */
export function fastestBuild(): 'simd' | 'scalar';

/** Something a person moves: one slider. */
export interface Control {
  /** Its unique name, such as `nose 1`. */
  readonly name: string;
  /** The feature it belongs to, such as `nose`. */
  readonly group: string;
  /** What its values are: `percentile`. */
  readonly unit: string;
  /**
   * Between which values a slider of it should stay: those of a semantic control end where the mean face would
   * crumple. `set` takes 0 to 1.
   */
  readonly limits: readonly [number, number];
  /** A sentence for people. */
  readonly description: string;
  /**
   * The name of the measure that a semantic control (`nose width`) reads and sets, so that its
   * value can be shown in mm; null for the modes of a feature.
   */
  readonly measure: string | null;
}

/**
 * What labels of some population tell of a face, such as age: a direction that was learned from the
 * people of `description`, who need not be those of the model.
 */
export interface Attribute {
  /** Its unique name, such as `age`. */
  readonly name: string;
  /** What it is, and as whom it was learned from. */
  readonly description: string;
  /** `years`, or `share` and `amount`, which run from 0 to 1. */
  readonly unit: string;
  /** The smallest and the largest value that may be asked for: those of the labels. */
  readonly limits: readonly [number, number];
  /** The part of the variance of labels that it explains in people whom it was not learned from. */
  readonly explained: number;
  /** The standard deviation of what the model's people read; the median face reads their mean, or nearly. */
  readonly deviation: number;
}

/** What is known of a photo, but for its pixels. */
export interface PhotoView {
  /** px, whole; with the height no more than 2^28 pixels, as canvases have. */
  width: number;
  /** px, whole. */
  height: number;
  /**
   * The 68 points of iBUG as x, y, x, y ... in px, x to the right and y down from the upper left
   * corner; the subject's right jaw first. They are where the model's landmarks are: those of brows some 7 mm above their hair.
   */
  points: ArrayLike<number>;
  /**
   * The focal length in px, if it is known: that of EXIF as if for film, over the 43.3 mm of its diagonal, times that of the photo,
   * unless it was cut. Otherwise it is estimated.
   */
  focal?: number | undefined;
  /**
   * By how much points are off along each axis, px, one standard deviation, if that is known. Otherwise it is estimated by how
   * well a face has them, which a detector's points are too good for: what they are off by makes another face.
   */
  noise?: number | undefined;
  /**
   * By how much the 17 points of the jaw are off across the face's outline, px, one standard deviation, if
   * that is known and more than the other points are: detectors see eyes better than where a face ends.
   */
  jawNoise?: number | undefined;
  /**
   * The middles of the irises of the subject's right and left eye, as x, y, x, y in px, if they are known: with expressions loaded,
   * the eyes look there. They are left ahead where lids are shut, or the two do not look the same way.
   */
  irises?: ArrayLike<number> | undefined;
}

/** What is known of another photo of the same person. */
export interface PhotoBeside extends PhotoView {
  /** Its pixels, as `PhotoPoints.rgba` is those of the photo. */
  rgba?: Uint8Array | Uint8ClampedArray | undefined;
}

/** What is known of a photo. */
export interface PhotoPoints extends PhotoView {
  /**
   * Other photos of the same person, from another side or with another expression: what their points tell of the face
   * counts, too, and what their pixels tell, where the photo has its own. Each with pixels takes a fit's time.
   */
  others?: readonly PhotoBeside[] | undefined;
  /**
   * The pixels, as `ImageData.data` has them: sRGB and alpha, row by row from the upper left corner.
   * With them the shape is told better, and the light too. Where alpha is below 128 the pixel is taken for
   * background, not the person, and is not looked at, but for how dark the photo is; where it is 0 nothing is there,
   * whatever its colour, as in pictures that were cut out. They are copied at once.
   */
  rgba?: Uint8Array | Uint8ClampedArray | undefined;
  /**
   * Is called during a fit with pixels with the part of its steps that are done, above 0 and at last 1;
   * what it throws is dropped. A fit that pixels tell nothing ends sooner.
   */
  progress?: ((part: number) => void) | undefined;
}

/** A pinhole camera. Its frame is x to the right, y down, z forward; the head's is the model's. */
export interface PhotoCamera {
  /** The focal length, px. */
  readonly focal: number;
  /** The principal point, px: the middle of the image. */
  readonly centre: readonly [number, number];
  /** From the head's frame to the camera's: nine numbers, row by row. */
  readonly rotation: readonly number[];
  /** Where the head's origin is in the camera's frame, mm. */
  readonly translation: readonly [number, number, number];
  /** Yaw to the subject's left, pitch down, roll to its right, radians; 0 when it looks ahead. */
  readonly angles: readonly [number, number, number];
}

/** How well a fit tells the points. */
export interface PhotoQuality {
  /** The root mean square distance of the 51 points inside of the outline, px. */
  readonly rmsPx: number;
  /** The same at the face, mm. */
  readonly rmsMm: number;
  /** How far the face is from the mean, as a part of what is usual. */
  readonly unusual: number;
  /** How many coefficients the points determine, and the pixels if they told any. */
  readonly determined: number;
  /** Why the points should not be taken for a face's, in a sentence; null when they may. */
  readonly refusal: string | null;
}

/** How lights that are far away shade a face. */
export interface PhotoLight {
  /**
   * For red, green and blue the factors of 1, x, y, z, xy, yz, xz, x^2 - y^2 and 3 z^2 - 1, where x, y, z
   * is the unit normal (as `Face.normals` has it). Their sum times the albedo is the linear light.
   */
  readonly coefficients: readonly (readonly number[])[];
  /** How far skin is off that, as a part of it: a root mean square. */
  readonly rms: number;
}

/** A shape that a face in a photo may take: a `Face` is one. */
export interface PhotoShape {
  readonly code: string;
  readonly expression: Readonly<Record<string, number>>;
}

/**
 * How a photo changes: on the nodes of a regular grid, linear between four of them, nothing outside of
 * the outermost.
 */
export interface PhotoField {
  /** Where the first node is, px from the photo's left and upper border. */
  readonly left: number;
  readonly top: number;
  /** How far apart nodes are, px. */
  readonly step: number;
  readonly columns: number;
  readonly rows: number;
  /** Row by row, x and y of a node: from it to where the photo is read for it, px. */
  readonly motion: Float32Array;
  /** Row by row, for red, green and blue: the factor of its linear light. */
  readonly gain: Float32Array;
}

/** Hair in a photo. */
export interface PhotoHair {
  /** Its albedo: red, green and blue in linear light. */
  readonly colour: readonly [number, number, number];
  /** How much of the scalp that is seen it covers, 0 to 1. */
  readonly cover: number;
  /** How far it stands off the head, mm. */
  readonly off: number;
  /** How far it hangs down beside the face, from the tragion on, mm; 0 when it ends above. */
  readonly hangs: number;
  /** How much of the forehead it covers, 0 to 1. */
  readonly forehead: number;
  /** How much more of its left half than of its right one, -1 to 1; 0 when one of them is not seen. */
  readonly aside: number;
  /** How its strands over the forehead lean, -1 to 1: 1 is down to the left, 0 straight down, across or every way. */
  readonly lean: number;
}

/** What a photo tells of a person beside the shape. Colours are linear light, in the photo's exposure unless that is too dark. */
export interface PhotoLooks {
  /** The skin's albedo. */
  readonly skin: readonly [number, number, number];
  /** The irises' albedo; null when too little of the eyes is seen, through dark glasses or in the dark. */
  readonly irises: readonly [number, number, number] | null;
  /** How much darker than the cheeks the skin is where a beard grows: the logarithm of the brightness. */
  readonly beard: number;
  /** The albedo of a beard, of hair and of the skin between; null without one. */
  readonly beardColour: readonly [number, number, number] | null;
  /** Null when there is none, or the head is not seen above the forehead. */
  readonly hair: PhotoHair | null;
}

/** A part of a photo in more pixels than it was fitted in. */
export interface PhotoDetail {
  /**
   * Four bytes a pixel, row by row from the upper left corner; alpha as in `PhotoPoints.rgba`. What is not the person's is
   * taken from the photo's own pixels.
   */
  rgba: Uint8Array | Uint8ClampedArray;
  width: number;
  height: number;
  /** Where its upper left corner is, px of the photo as it was fitted. */
  left: number;
  top: number;
  /** So many of its px are one of those. */
  scale: number;
}

/** A photo whose face can be changed. */
export interface PhotoEdit {
  /** How the photo changes for another shape than the fitted; null when it does not. */
  field(shape: PhotoShape): PhotoField | null;
  /** The photo's pixels, changed so: by the processor, without WebGL. Colours move, and alpha stays where it was. */
  render(shape: PhotoShape, rgba: Uint8Array | Uint8ClampedArray): Uint8ClampedArray<ArrayBuffer>;
  /**
   * The head's colours as the photo has them, without its light: `size` x `size` texels, 64 to 4096 a side and 1024 unless given, in the model's
   * texture coordinates, row by row from v = 1, sRGB; alpha is how much of it is the photo's. What the
   * camera does not see, or glasses cover, is taken from the other side, or continued; a photo that is too dark
   * counts as exposed as most are. `detail` is the face in the pixels of a larger photo, of which `rgba` has fewer.
   * @throws Error when the fit has no light (see `PhotoPoints.rgba`).
   */
  texture(rgba: Uint8Array | Uint8ClampedArray, size?: number, detail?: PhotoDetail): Uint8ClampedArray<ArrayBuffer>;
  /**
   * What the photo tells of the person beside the shape; alpha as in `PhotoPoints.rgba`. Irises of few pixels are found by their middles
   * (`PhotoPoints.irises`), if they are known; without, by what is dark between the lids.
   * @throws Error when the fit has no light (see `PhotoPoints.rgba`).
   */
  looks(rgba: Uint8Array | Uint8ClampedArray, irises?: ArrayLike<number>): PhotoLooks;
  /**
   * The skin's colours at places of the face, mixes of three vertices each: three of `corners` and three of `shares` a place. Four numbers a
   * place: red, green and blue, linear light in the photo's white balance without the light on the face, and how well that is seen, 0 to 1: 0
   * behind the head, glasses, a mask or hair.
   * @throws Error when the fit has no light (see `PhotoPoints.rgba`), a place is incomplete, or there is no such vertex.
   */
  albedos(rgba: Uint8Array | Uint8ClampedArray, corners: Uint32Array, shares: Float32Array): Float32Array<ArrayBuffer>;
  /** Gives its memory back. */
  free(): void;
}

/** What a photo's pixels told of the shape, by its shading. */
export interface PhotoAppearance {
  /** How far skin is off its albedo times the shading, as a part of it: a root mean square. */
  readonly rms: number;
  /** How many patches of skin were compared. */
  readonly patches: number;
}

/** What a photo tells. */
export interface PhotoFit {
  /** The face, for `fromCode` and `Face.code`. */
  readonly code: string;
  readonly camera: PhotoCamera;
  /** What is shown of each expression, as `Face.expression` takes it. */
  readonly expression: Readonly<Record<string, number>>;
  /** From each point as given to where it is on the fitted face, px. */
  readonly residuals: readonly (readonly [number, number])[];
  readonly quality: PhotoQuality;
  /**
   * Null when no pixels were given, or they told nothing of the shape that the points agree with: then
   * camera and shape are the points' own.
   */
  readonly appearance: PhotoAppearance | null;
  /**
   * Null when no pixels were given, the points are no face's, or too few of the face's pixels are the person's
   * (see `PhotoPoints.rgba`).
   */
  readonly light: PhotoLight | null;
  /** How the other photos of the person were taken, in the order of `PhotoPoints.others`. */
  readonly others: readonly PhotoShot[];
}

/**
 * How another photo of a fitted face was taken: `{ ...fit, ...fit.others[0] }` is the fit as that photo has it, and makes
 * that photo one whose face can be changed.
 */
export interface PhotoShot {
  readonly camera: PhotoCamera;
  /** What is shown of each expression there. */
  readonly expression: Readonly<Record<string, number>>;
  /** As `PhotoFit.residuals`, of the points of that photo. */
  readonly residuals: readonly (readonly [number, number])[];
  /** As `PhotoQuality.rmsPx`, of that photo. */
  readonly rmsPx: number;
  /** As `PhotoQuality.rmsMm`, of that photo. */
  readonly rmsMm: number;
  /** As `PhotoFit.light`; null when none of its pixels were given, too. */
  readonly light: PhotoLight | null;
}

/** Another photo of a person, for the colours of the head. */
export interface PhotoOther {
  /** px, whole. */
  width: number;
  /** px, whole. */
  height: number;
  /** How it was taken: its own of a fit's `others`. */
  shot: PhotoShot;
  /** Its pixels, as `PhotoPoints.rgba`. They are copied at once. */
  rgba: Uint8Array | Uint8ClampedArray;
  /** Finer pixels of its face, if there are some; they are copied, too. */
  detail?: PhotoDetail | undefined;
}

/** A named range of triangles: `skin`, `left eyeball` ... */
export interface Part {
  readonly name: string;
  /** Its first triangle; a triangle is three entries of `FaceModel.triangles`. */
  readonly first: number;
  /** How many triangles it has. */
  readonly count: number;
}

/** A named point of the surface. */
export interface Landmark {
  /** `ibug_00` to `ibug_67`, or an anatomical name. */
  readonly name: string;
  /** `[vertex, weight]` pairs; the weights sum to 1. */
  readonly stencil: readonly (readonly [number, number])[];
}

/** A length that can be read from any face. */
export interface Measure {
  readonly name: string;
  /** Its unit: `mm`. */
  readonly unit: string;
  readonly description: string;
}

/** Where a model comes from, and whom it describes. */
export interface About {
  /** The model's name. */
  readonly title: string;
  /** Who was learned from, in a sentence or two. */
  readonly population: string;
  /** What must not be read into it. */
  readonly caveat: string;
  /** How many faces it was learned from. */
  readonly faces: number;
  /** The program and version that made it. */
  readonly made_by: string;
  /** Every source with its licence. */
  readonly licences: readonly {
    readonly source: string;
    readonly by: string;
    /** SPDX name. */
    readonly licence: string;
  }[];
}

/** What a blob says of itself. */
export interface ModelInfo {
  readonly controls: readonly Control[];
  /** What may be asked of random faces; none in a model without labels. */
  readonly attributes: readonly Attribute[];
  /** The features that can be locked, blended, randomised and reset: `eyes`, `nose` ... */
  readonly regions: readonly string[];
  /** Finer names for parts of the surface: `left eye` ... */
  readonly regionNames: readonly string[];
  /** For each of `regionNames` the feature it belongs to, an index into `regions`, or null. */
  readonly regionGroups: readonly (number | null)[];
  readonly parts: readonly Part[];
  readonly landmarks: readonly Landmark[];
  readonly measures: readonly Measure[];
  /** How far a feature's change reaches into its surround, mm: the default and the limits. */
  readonly blending: { readonly alpha: number; readonly limits: readonly [number, number] };
  readonly about: About;
}

/** A statistical model of faces of one topology: N vertices, M >= N texture coordinates. */
export class FaceModel implements ModelInfo {
  private constructor();

  /** A new face: the median person. */
  face(): Face;
  /**
   * The face that a code describes.
   * @throws Error when the code was not made by this model.
   */
  fromCode(code: string): Face;

  /**
   * Reads the model's expressions, a file beside it, given as `load` takes one. Faces that there are can show
   * them from then on. A model takes one such file; later ones are read and left.
   * @throws Error with the reason when the bytes are not usable, or of another model.
   */
  loadExpressions(file: Uint8Array | ArrayBuffer | Blob | Response | ReadableStream<Uint8Array | ArrayBuffer>): Promise<void>;
  /** The names of the expressions: ARKit's, such as `jawOpen`; none before `loadExpressions`. */
  readonly expressions: readonly string[];

  /**
   * Loads and prepares what fits photos, for the expressions that are loaded, so that the first fit takes
   * as long as the others. Without it the first fit does.
   * @param options `wasm` is `phiz/photo/photo_bg.wasm` where a bundler does not find it by itself
   * @throws Error with the reason when the module cannot be loaded.
   */
  preparePhotos(options?: { wasm?: Wasm | undefined }): Promise<void>;
  /**
   * The face and the camera that the points of a photo tell. Nothing leaves the machine; the module
   * that does it is loaded with the first photo. Expressions are told too when they are loaded, and
   * without them a smile is a part of the face. Equal points give
   * an equal fit.
   * @throws Error with the reason for sizes, points or a focal length that cannot be a photo's. Points
   *   that are no face's give a fit with a `quality.refusal`.
   */
  fitPhoto(photo: PhotoPoints): Promise<PhotoFit>;

  /**
   * Opens a photo for changing the face in it. Its size is that of the photo that was fitted; larger
   * versions of the photo change by the same field. With `rgba`, whose alpha is how much of a pixel is the
   * person's, less of the background moves. `others` are photos of the same person, which `PhotoEdit.texture` takes
   * the colours of what they show better from, in the tones of this one; one whose face has no light that is told
   * counts for nothing.
   * @throws Error with the reason when the face is not in the photo, `rgba` has another size, or the fit's camera or light
   *   have numbers that none has.
   */
  editPhoto(photo: { width: number; height: number; fit: PhotoFit; rgba?: Uint8Array | Uint8ClampedArray | undefined; others?: readonly PhotoOther[] | undefined }): Promise<PhotoEdit>;

  readonly controls: readonly Control[];
  readonly attributes: readonly Attribute[];
  readonly regions: readonly string[];
  readonly regionNames: readonly string[];
  readonly regionGroups: readonly (number | null)[];
  readonly parts: readonly Part[];
  readonly landmarks: readonly Landmark[];
  readonly measures: readonly Measure[];
  readonly blending: { readonly alpha: number; readonly limits: readonly [number, number] };
  readonly about: About;

  /** N. */
  readonly vertexCount: number;
  /**
   * Three corners a triangle, counter-clockwise from outside; a corner is an index into `uvs`. This and the arrays below are the
   * model's own, for all its faces and their exports: copy what you write into.
   */
  readonly triangles: Uint32Array;
  /** Two texture coordinates a corner, M pairs. */
  readonly uvs: Float32Array;
  /**
   * The vertex of each corner, M entries. Corner i < N is vertex i; the others repeat a vertex
   * on a seam.
   */
  readonly uvVertices: Uint32Array;
  /** Prescribed colours, sRGB, three bytes a vertex. */
  readonly colours: Uint8Array;
  /** The region of each vertex, an index into `regionNames`. */
  readonly regionOf: Uint8Array;
  /** The vertex on the other side of the face, for each vertex. */
  readonly mirror: Uint32Array;

  /** Releases the model's memory and that of its faces. Later calls throw; what was read of it before may still be read. */
  free(): void;
}

/** A face: a model and its coefficients; everything else is computed from them. */
export class Face {
  private constructor();

  /** The model that the face belongs to. */
  readonly model: FaceModel;
  /** The model's controls. */
  readonly controls: readonly Control[];

  /**
   * Moves a control.
   * @throws Error when no control has that name, the value is no percentile from 0 to 1 (of a control of that unit), or a measure
   *   that is held cannot be.
   */
  set(control: string, value: number): void;
  /** Where the face stands on a control, in the control's unit. */
  get(control: string): number;
  /** Back to the median: all of the face, with the model's blending distance unless something is locked, or the controls of one region. */
  reset(region?: string): void;
  /**
   * Moves towards another face of the same model: t from 0, which changes nothing, to 1, which takes it over. All of a face has its
   * blending distance with it unless something is locked here; regions have none.
   */
  blend(other: Face, t: number, options?: { regions?: readonly string[] | undefined }): void;
  /**
   * Where the face stands on an attribute, in its unit. Edits by semantic controls do not count.
   * @throws Error when no attribute has that name.
   */
  attribute(name: string): number;
  /**
   * Makes the face read values on some attributes, in their units, and stay as like itself as the population lets it: by the
   * most probable change, to a thousandth of their limits where people's limits let it. All other attributes read what they
   * did. Locked regions and held measures stay. Shares of one whole are asked for together, and sum to 1:
   * `setAttributes({ african: 0.6, asian: 0.2, caucasian: 0.2 })`; one alone, or three that do not, are met half-way.
   * @throws Error for what is unknown, and for values beyond their limits; the face then stays as it was.
   */
  setAttributes(values: Readonly<Record<string, number>>): void;
  /**
   * A random person of the population. `spread`, from 0 to 3, is 1 for the population's own variety, `seed` a whole number to
   * 2^53 - 1. Locked
   * regions stay. Of `attributes` those that are named read what is asked, to a thousandth of their
   * limits, and all else is random as before; where regions stay, the others go their own part of
   * the way there.
   * @returns the seed that was used; the same seed and options give the same person again, where the blending distance and
   *   what is locked or not among `regions` are the same.
   * @throws Error for what is unknown, and for values beyond their limits.
   */
  randomize(options?: {
    seed?: number | undefined;
    spread?: number | undefined;
    regions?: readonly string[] | undefined;
    attributes?: Readonly<Record<string, number>> | undefined;
  }): number;
  /**
   * Holds a region where and as it is, to 0.0001 mm, until it is unlocked: `randomize`, `blend`,
   * `drag` and `reset` leave its coefficients alone, and what others move there is taken back. Its
   * own sliders still move it. Unlocking moves nothing.
   */
  lock(region: string): void;
  unlock(region: string): void;
  readonly locked: string[];
  /** A measure of the present face, in the measure's unit. */
  measure(name: string): number;
  /**
   * Gives a measure a value in its unit, to 0.01 mm: by its semantic control, however far beyond
   * the control's limits, or where it has none by the most probable change of what is not locked.
   * @throws Error when no measure has that name or the face cannot have that length.
   */
  setMeasure(name: string, value: number): void;
  /**
   * Undoes what one control did and touches no other.
   * @throws Error when no control has that name.
   */
  clear(control: string): void;
  /**
   * Holds a measure where it is, to 0.0001 mm: when something else changes the face, the rest
   * follows as the population would have it. Setting the measure itself still moves it. A change
   * that makes holding impossible throws and leaves the face as it was.
   */
  lockMeasure(name: string): void;
  unlockMeasure(name: string): void;
  readonly lockedMeasures: string[];
  /**
   * Brings a vertex, where it is shown, to a point (mm) by the most probable change of what is not locked. Each coefficient
   * stays within 3 standard deviations, or where it was if that is farther, and held measures are held: a point that no such
   * face reaches is approached, not met. With an expression the face at rest moves as far as the shown one would have to.
   * @throws Error when there is no such vertex, the point is not finite, or a held measure cannot be held; the face then stays
   *   as it was.
   */
  drag(vertex: number, target: ArrayLike<number>): void;

  /**
   * Shows so much of an expression, 0 to 1, together with the others that are shown. Expressions
   * follow the face's proportions. They are no part of its `code`, its measures or its shape: these
   * are of the face at rest.
   * @throws Error when the model has no such expression, or the weight is not from 0 to 1.
   */
  express(name: string, weight: number): void;
  /** Every expression that is shown, with its weight; may be assigned, `{}` for a face at rest. The same object until another is shown. */
  get expression(): Readonly<Record<string, number>>;
  set expression(shown: Readonly<Record<string, number>>);

  /**
   * The whole face as a short string for URLs; may be assigned. What is locked is no part of it, and stays locked: held
   * measures are held at the lengths of the face that it then is.
   */
  code: string;
  /**
   * All coefficients in standard deviations, a copy; may be assigned, beyond limits and those of locked
   * regions, too. What others move in a locked region is taken back, and held measures are held. The whole of
   * a face is its `code`.
   * @throws Error when their number is wrong, one is beyond 255, or a held measure cannot be held.
   */
  get coefficients(): Float32Array<ArrayBuffer>;
  set coefficients(coefficients: ArrayLike<number>);
  /** How far a feature's change reaches into its surround, mm; may be assigned, which heeds no locks. */
  alpha: number;

  /**
   * x, y, z of each vertex, mm. A view on wasm memory: valid until the next call of anything in
   * this package, so copy what you keep. Reading `normals` and `changed` of the same face, and `vertexCount` to
   * `mirror` of its model, does not end it.
   */
  readonly positions: Float32Array;
  /** Unit normals, as `positions`. */
  readonly normals: Float32Array;
  /**
   * `[first, end)`: a range that has all vertices that the last call moved or turned, and others between them.
   * Of a face that has had expressions those that differ from what they were when positions, normals or this were last asked for.
   */
  readonly changed: [number, number];

  /** A face of its own with the same state, locks as well. */
  clone(): Face;
  /** Releases the face's memory. Any later use throws. */
  free(): void;
}
