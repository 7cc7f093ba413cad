/** @typedef {import('./raw.js').FaceModel} RawFaceModel */
/** @typedef {import('./raw.js').Face} RawFace */
/** @typedef {import('./raw.js').Expressions} RawExpressions */
/** @typedef {import('./raw-photo.js').Fitter} RawFitter */

// The smallest module with a 128-bit instruction: (func (result v128) i32.const 0  i8x16.splat
// i8x16.popcnt).
const SIMD_PROBE = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253,
  15, 253, 98, 11,
]);

/** @returns {'simd' | 'scalar'} */
export function fastestBuild() {
  return WebAssembly.validate(SIMD_PROBE) ? 'simd' : 'scalar';
}

// A build is instantiated once; all models that use it share its memory.
/** @typedef {{ glue: typeof import('./raw.js'), memory: WebAssembly.Memory }} Instance */
/** @type {Map<string, Promise<Instance>>} */
const instances = new Map();
/** Those that are there. @type {Map<string, Instance>} */
const ready = new Map();

/** A module as the caller has it: where it is, its bytes, or compiled. @typedef {string | URL | Response | BufferSource | WebAssembly.Module} Wasm */

/** @param {'simd' | 'scalar'} build @param {Wasm} [wasm] */
async function instantiate(build, wasm) {
  if (typeof WebAssembly !== 'object') {
    throw new Error('WebAssembly is not available here, and phiz needs it');
  }
  if (build !== 'simd' && build !== 'scalar') throw new Error(`there is no build "${build}": take simd or scalar`);
  // The two paths are written out so that bundlers find the modules and the wasm files.
  const glue =
    build === 'simd' ? await import('./simd/phiz.js') : await import('./scalar/phiz.js');
  const own = () =>
    build === 'simd'
      ? new URL('./simd/phiz_bg.wasm', import.meta.url)
      : new URL('./scalar/phiz_bg.wasm', import.meta.url);
  const { memory } = await started(glue, () => wasm ?? own());
  tellOfMemory([glue.FaceModel, glue.Face, glue.Expressions, glue.IncomingModel]);
  return { glue, memory };
}

/**
 * Who asks for more memory than there is gets a word of it. The engine has only "unreachable" for that. Nothing else is known to
 * bring it about, as all that can fail says why; but who knows.
 * @param {Function[]} classes of a module
 */
function tellOfMemory(classes) {
  for (const one of classes) {
    for (const of of [one, one.prototype]) {
      for (const [name, { value, writable }] of Object.entries(Object.getOwnPropertyDescriptors(of))) {
        if (typeof value !== 'function' || !writable || name === 'constructor' || name.startsWith('__')) continue;
        /** @type {any} */ (of)[name] = function (/** @type {unknown[]} */ ...given) {
          try {
            return value.apply(this, given);
          } catch (why) {
            if (!(why instanceof WebAssembly.RuntimeError)) throw why;
            throw new Error('phiz has no memory left, or met an error of its own: free faces and models that nobody needs', { cause: why });
          }
        };
      }
    }
  }
}

/**
 * Gives memory back. What was at work when memory ran out is never given back: nobody is told a second time.
 * @param {{ free: () => void } | null | undefined} raw
 */
function release(raw) {
  try {
    raw?.free();
  } catch {
    // As above.
  }
}

/**
 * @param {Wasm} wasm
 * @returns {Promise<Wasm>}
 */
async function wasmSource(wasm) {
  if (!/^file:/i.test(wasm instanceof URL ? wasm.href : typeof wasm === 'string' ? wasm : '')) return wasm;
  // Node's fetch does not read files. The name is in a variable so that bundlers for pages do not
  // try to resolve it.
  const fs = 'node:fs/promises';
  return (await import(/* webpackIgnore: true */ /* @vite-ignore */ fs)).readFile(new URL(/** @type {URL | string} */ (wasm)));
}

/**
 * Starts a module. What the engine says of a page in its place names neither phiz nor a way out.
 * @template T
 * @param {{ default: (from: { module_or_path: Wasm }) => Promise<T> }} glue
 * @param {() => Wasm} source throws where a bundler has left no address
 */
async function started(glue, source) {
  try {
    return await glue.default({ module_or_path: await wasmSource(source()) });
  } catch (why) {
    const cause = /** @type {Error} */ (why);
    throw new Error(`phiz has no wasm file (see Bundlers in its README): ${cause.message}`, { cause });
  }
}

/**
 * The module that fits photos, which is loaded when the first photo is there.
 * @type {Promise<typeof import('./raw-photo.js')> | null}
 */
let photoModule = null;

/** @param {Wasm} [wasm] */
async function loadPhotoModule(wasm) {
  const glue = await import('./photo/photo.js');
  await started(glue, () => wasm ?? new URL('./photo/photo_bg.wasm', import.meta.url));
  tellOfMemory([glue.Fitter, glue.PhotoEdit]);
  return glue;
}

/** A failed download may be tried again. @param {Wasm} [wasm] */
function loadedPhotoModule(wasm) {
  photoModule ??= loadPhotoModule(wasm).catch((why) => {
    photoModule = null;
    throw why;
  });
  return photoModule;
}

/** Sides of photos are not longer, and what is not a whole number would wrap around in wasm. */
const MOST_PIXELS = 1 << 20;
/** Nor are there more pixels, in four bytes each: more than these take a wasm memory whole, and no canvas has more. */
const MOST_AREA = 1 << 28;

/**
 * @param {string} what
 * @param {unknown} value
 */
function pixels(what, value) {
  if (typeof value !== 'number' || !Number.isInteger(value) || value < 1 || value > MOST_PIXELS) {
    throw new Error(`a photo's ${what} must be a whole number of pixels above 0, not ${value}`);
  }
  return value;
}

/** @param {unknown} width @param {unknown} height */
function sizeOf(width, height) {
  const size = Uint32Array.of(pixels('width', width), pixels('height', height));
  if (size[0] * size[1] > MOST_AREA) throw new Error(`a photo of ${size[0]} x ${size[1]} pixels is too large: it may have ${MOST_AREA}`);
  return size;
}

/** What is known of a photo, but for its pixels, as numbers. @param {import('phiz').PhotoView} photo @returns {number[]} */
function viewOf(photo) {
  if (typeof photo !== 'object' || !photo) wrong('a photo', 'an object of its width, height and points', photo);
  const { width, height, points, focal, noise, jawNoise, irises, ...others } = photo;
  noMore('fitPhoto', others);
  const size = sizeOf(width, height);
  if (!(points?.length >= 0)) wrong('points', 'an array of x, y, x, y ...', points);
  if (points.length % 2) throw new Error('points are pairs of x and y, and one has no y');
  // What is not known is no number, and what is given as none is refused as 0 is.
  const known = Object.entries({ focal, noise, jawNoise }).map(([name, value]) => (value === undefined ? NaN : number(name, value) || 0));
  if (irises !== undefined && irises?.length !== 4) wrong('irises', 'an array of x, y, x, y', irises);
  // Nor is a place of one.
  const middles = irises === undefined ? [NaN, NaN, NaN, NaN] : Array.from(irises, (value) => (Number.isFinite(value) ? value : Infinity));
  return [...size, ...known, ...middles, ...Float64Array.from(points)];
}

// Glue takes whatever it is given for what it expects: another type would be read as an address.
/** @param {string} what @param {string} wanted @param {unknown} value @returns {never} */
function wrong(what, wanted, value) {
  const kind = kindOf(value);
  const named = typeof value === 'string' ? `"${value}"` : typeof value !== 'object' || !value ? String(value) : /^(Array|Object)$/.test(kind) ? `an ${kind.toLowerCase()}` : `a ${kind}`;
  throw new TypeError(`${what} must be ${wanted}, not ${named}`);
}
/** @param {string} what @param {unknown} value */
const string = (what, value) => (typeof value === 'string' ? value : wrong(what, 'a string', value));
/** @param {string} what @param {unknown} value */
const number = (what, value) => (typeof value === 'number' ? value : wrong(what, 'a number', value));
/** Of lists and maps nobody would find the names. @template T @param {string} what @param {T} value @returns {T} */
const record = (what, value) => (typeof value !== 'object' || !value || Symbol.iterator in value ? wrong(what, 'an object', value) : value);
/** @param {string} what @param {unknown} value @returns {string[] | undefined} */
const strings = (what, value) =>
  value === undefined || (Array.isArray(value) && value.every((one) => typeof one === 'string')) ? value : wrong(what, 'an array of strings', value);
/** @param {string} what @param {object} others options that nobody asks for */
function noMore(what, others) {
  const [unknown] = Object.keys(others);
  if (unknown !== undefined) throw new Error(`${what} knows no option "${unknown}"`);
}

/** What it is, also of a frame's or a worker's own classes. @param {unknown} value */
const kindOf = (value) => Object.prototype.toString.call(value).slice(8, -1);

/** @param {string} what @param {unknown} value @returns {Uint8Array} what it holds */
function rgbaOf(what, value) {
  const kind = kindOf(value);
  if (kind !== 'Uint8Array' && kind !== 'Uint8ClampedArray') wrong(what, 'a Uint8Array or Uint8ClampedArray of RGBA, as `ImageData.data` is', value);
  const { buffer, byteOffset, byteLength } = /** @type {Uint8Array} */ (value);
  return new Uint8Array(buffer, byteOffset, byteLength);
}

/** @param {Partial<import('phiz').PhotoFit> | undefined} fit */
function checkFit(fit) {
  const { camera, light, code, expression } = fit ?? {};
  const [centre, rotation, translation] = [camera?.centre, camera?.rotation, camera?.translation].map((list) => list?.length);
  const isWhole = typeof camera?.focal === 'number' && centre === 2 && rotation === 9 && translation === 3 && typeof expression === 'object' && expression;
  if (!isWhole || typeof code !== 'string' || !Array.isArray((light ?? { coefficients: [] }).coefficients)) wrong('a fit', 'what `fitPhoto` gave', fit);
}

/** Names, and a number for each. @param {Readonly<Record<string, number>>} values @returns {[string[], Float32Array]} */
function namedNumbers(values) {
  const names = Object.keys(record('attributes', values));
  return [names, Float32Array.from(names, (name) => number(`the attribute "${name}"`, values[name]))];
}

/** What a packed model may inflate to, as in `src/blob.rs`: twenty times the default model. */
const MOST_BYTES = 64 * 1024 * 1024;

/** @param {Uint8Array} bytes */
function isPacked(bytes) {
  return bytes[0] === 0x1f && bytes[1] === 0x8b;
}

/** Those of a file, in one. @param {readonly Uint8Array[]} chunks */
function joined(chunks) {
  const bytes = new Uint8Array(chunks.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const chunk of chunks) {
    bytes.set(chunk, at);
    at += chunk.length;
  }
  return bytes;
}

/**
 * Hands over the bytes of a blob as they come: a model on disk is gzip, and is inflated on the way.
 * @param {ReadableStream<Uint8Array | ArrayBuffer>} file
 * @param {(bytes: Uint8Array) => void} take
 * @param {(bytes: Uint8Array) => void} [seen] the file's own
 */
async function unpackTo(file, take, seen = () => {}) {
  let length = 0;
  /** @param {Uint8Array} bytes */
  function count(bytes) {
    length += bytes.length;
    if (length > MOST_BYTES) throw new Error(`not a usable phiz blob: unpacked it is over the limit of ${MOST_BYTES} bytes`);
    take(bytes);
  }
  const source = file.getReader();
  /** @type {WritableStreamDefaultWriter<BufferSource> | null} */
  let packed = null;
  /** @type {Promise<unknown>} */
  let inflating = Promise.resolve();
  /** @param {ReadableStream<Uint8Array>} readable */
  async function inflate(readable) {
    const inflated = readable.getReader();
    for (;;) {
      const { value } = await inflated.read().catch((why) => {
        throw new Error(`not a usable phiz blob: its packed bytes are damaged: ${why.message}`);
      });
      if (!value) return;
      count(value);
    }
  }
  try {
    // Two bytes tell what it is; they may come one by one, and after none.
    let begin = new Uint8Array(0);
    for (let isTold = false; ; ) {
      const { done, value: chunk } = await source.read();
      let value = done ? undefined : bytesOf(chunk);
      if (!done && !(value instanceof Uint8Array)) {
        throw new TypeError(`a stream must bring bytes, not ${/** @type {any} */ (chunk)?.constructor?.name ?? typeof chunk}`);
      }
      if (value) seen(value);
      const first = !isTold;
      if (first) {
        if (value) begin = joined([begin, value]);
        if (value && begin.length < 2) continue;
        isTold = true;
        if (begin.length > 0) value = begin;
      }
      if (!value) break;
      // As servers answer who asks for what they do not have.
      if (first && value[0] === 0x3c) throw new Error('not a usable phiz blob but a page: is its address right?');
      if (first && isPacked(value)) {
        if (typeof DecompressionStream !== 'function') {
          throw new Error('this browser has no DecompressionStream, which unpacks models: it is too old');
        }
        const { writable, readable } = new DecompressionStream('gzip');
        packed = writable.getWriter();
        inflating = inflate(/** @type {ReadableStream<Uint8Array>} */ (readable));
      }
      // What inflates tells why it takes no more.
      if (packed) await Promise.race([packed.write(/** @type {Uint8Array<ArrayBuffer>} */ (value)).catch(() => inflating), inflating]);
      else count(value);
    }
    await packed?.close().catch(() => {});
    await inflating;
  } catch (why) {
    source.cancel().catch(() => {});
    packed?.abort().catch(() => {});
    inflating.catch(() => {});
    // A stream may break off with anything.
    throw why instanceof Error ? why : new Error(`the file broke off: ${why}`, { cause: why });
  }
}

/** The blob in a file's bytes. @param {Uint8Array} bytes */
async function unpack(bytes) {
  if (!isPacked(bytes)) return bytes;
  /** @type {Uint8Array[]} */
  const chunks = [];
  await unpackTo(streamOf(bytes), (chunk) => chunks.push(chunk));
  return joined(chunks);
}

/** A copy comes out of it, whatever becomes of the bytes. @param {Uint8Array} bytes */
const streamOf = (bytes) => new Blob([/** @type {BlobPart} */ (bytes)]).stream();

/**
 * The bytes of a buffer, or of a view of one, whatever its numbers are; all else as it is.
 * @template T @param {T} file @returns {Exclude<T, ArrayBuffer> | Uint8Array}
 */
function bytesOf(file) {
  if (ArrayBuffer.isView(file)) {
    const bytes = new Uint8Array(file.buffer, file.byteOffset, file.byteLength);
    // Browsers take nothing out of memory that threads share.
    return kindOf(file.buffer) === 'ArrayBuffer' ? bytes : bytes.slice();
  }
  return kindOf(file) === 'ArrayBuffer' ? new Uint8Array(/** @type {ArrayBuffer} */ (file)) : /** @type {Exclude<T, ArrayBuffer>} */ (file);
}

/** What brings a file. @param {string} what @param {Uint8Array | Blob | Response | ReadableStream<Uint8Array | ArrayBuffer>} file */
function opened(what, file) {
  if (ArrayBuffer.isView(file)) return streamOf(file);
  if (file instanceof Blob) return file.stream();
  if (file instanceof Response) {
    if (!file.ok) throw new Error(`${file.url || 'the response'}: ${file.status} ${file.statusText}`.trim());
    if (!file.body) throw new Error('the response has no body');
    if (file.bodyUsed || file.body.locked) throw new Error('the response was read before: a model is read from a new one, or from its bytes');
    return file.body;
  }
  if (typeof file?.getReader !== 'function') wrong(what, 'given as bytes, or as a response or stream that brings them (`await load(await fetch(url))`)', file);
  if (file.locked) throw new Error('the stream is being read, or was: a model is read from a new one, or from its bytes');
  return file;
}

/** @param {'simd' | 'scalar'} build @param {Wasm} [wasm] */
function instance(build, wasm) {
  let found = instances.get(build);
  if (!found) {
    found = instantiate(build, wasm);
    instances.set(build, found);
    found.then(
      (instance) => ready.set(build, instance),
      // A failed download may be tried again.
      () => instances.delete(build),
    );
  }
  return found;
}

/** @param {{ build?: 'simd' | 'scalar', wasm?: Wasm }} [options] */
export async function prepare(options) {
  const { build = fastestBuild(), wasm, ...others } = options ?? {};
  noMore('prepare', others);
  await instance(build, wasm);
}

/**
 * @param {Uint8Array | ArrayBuffer | Blob | Response | ReadableStream<Uint8Array | ArrayBuffer>} file
 * @param {{ build?: 'simd' | 'scalar' }} [options]
 */
export async function load(file, options) {
  const { build = fastestBuild(), ...others } = options ?? {};
  noMore('load', others);
  const given = bytesOf(file);
  const there = ready.get(build);
  // A blob has far more bytes than a file: where nothing has to be waited for, the module's copy is the
  // only one.
  if (there && given instanceof Uint8Array && !isPacked(given)) {
    const incoming = new there.glue.IncomingModel();
    try {
      incoming.push(given);
      return new FaceModel(incoming.finish(true), there, null);
    } finally {
      release(incoming);
    }
  }
  const stream = opened('a model', given);
  // The file is kept as it was given, for the module that fits photos: should it come, it reads its own.
  /** @type {Uint8Array[]} */
  const kept = [];
  // The module may come while the file does. What is there of both is read.
  /** @type {import('./raw.js').IncomingModel | null} */
  let incoming = null;
  /** @type {Uint8Array[]} */
  let waiting = [];
  let isOver = false;
  const begun = instance(build).then((found) => {
    // Nobody would give it back.
    if (isOver) throw new Error('the model did not come');
    incoming = new found.glue.IncomingModel();
    for (const bytes of waiting) incoming.push(bytes);
    waiting = [];
    return { found, incoming };
  });
  const come = unpackTo(
    stream,
    (bytes) => {
      if (incoming) incoming.push(bytes);
      else waiting.push(bytes);
    },
    (bytes) => kept.push(bytes),
  );
  try {
    const [{ found, incoming: whole }] = await Promise.all([begun, come]);
    return new FaceModel(whole.finish(false), found, joined(kept));
  } finally {
    isOver = true;
    release(incoming);
    incoming = null;
  }
}

export class FaceModel {
  /** @type {RawFaceModel | null} */
  #raw;
  #memory;
  /**
   * Most of it is text, which takes as long as a face: made when it is first asked for.
   * @type {import('phiz').ModelInfo | null}
   */
  #known = null;
  /** @type {Set<WeakRef<Face>>} */
  #faces = new Set();
  /** Asking each of them would take longer with every face, and keep it until the caller's turn ends. @type {FinalizationRegistry<WeakRef<Face>>} */
  #gone = new FinalizationRegistry((entry) => this.#faces.delete(entry));
  /** @type {Pick<import('phiz').FaceModel, 'triangles' | 'uvs' | 'uvVertices' | 'colours' | 'regionOf' | 'mirror' | 'vertexCount'> | null} */
  #copied = null;
  #glue;
  /** @type {{ raw: RawExpressions, names: string[], packed: Uint8Array } | null} */
  #expressions = null;
  #packed;
  /**
   * What fits photos, with the expressions that there were.
   * @type {{ fitter: Promise<RawFitter>, expressions: Uint8Array | undefined } | null}
   */
  #photos = null;

  /**
   * @param {RawFaceModel} raw
   * @param {Instance} instance
   * @param {Uint8Array | null} packed the file; null when `raw` keeps the blob
   */
  constructor(raw, { memory, glue }, packed) {
    this.#packed = packed;
    this.#raw = raw;
    this.#memory = memory;
    this.#glue = glue;
  }

  get #info() {
    this.#known ??= this.#live.info();
    return this.#known;
  }

  get #live() {
    if (!this.#raw) throw new Error('this FaceModel was freed and cannot be used any more');
    return this.#raw;
  }

  /** @param {RawFace} raw */
  #adopt(raw) {
    const face = new Face(raw, this, this.#memory, {
      adopt: (clone) => this.#adopt(clone),
      expressions: () => this.#expressions,
    });
    const entry = new WeakRef(face);
    this.#gone.register(face, entry);
    this.#faces.add(entry);
    return face;
  }

  face() {
    return this.#adopt(this.#live.face());
  }

  /** @param {string} code */
  fromCode(code) {
    return this.#adopt(this.#live.from_code(string('a code', code)));
  }

  /** @param {Uint8Array | ArrayBuffer | Blob | Response | ReadableStream<Uint8Array | ArrayBuffer>} file */
  async loadExpressions(file) {
    /** @type {Uint8Array[]} */
    const blob = [];
    /** @type {Uint8Array[]} */
    const kept = [];
    await unpackTo(opened('a file of expressions', bytesOf(file)), (bytes) => blob.push(bytes), (bytes) => kept.push(bytes));
    const raw = this.#glue.Expressions.parse(joined(blob), this.#live);
    // Faces may show those that are there.
    if (this.#expressions) raw.free();
    else this.#expressions = { raw, names: raw.names(), packed: joined(kept) };
  }
  get expressions() {
    return this.#expressions?.names ?? [];
  }

  /** @param {{ wasm?: Wasm }} [options] */
  async preparePhotos(options) {
    const { wasm, ...others } = options ?? {};
    noMore('preparePhotos', others);
    await loadedPhotoModule(wasm);
    await this.#photoFitter();
  }

  /** @param {import('phiz').PhotoPoints} photo */
  async fitPhoto(photo) {
    if (typeof photo !== 'object' || !photo) wrong('a photo', 'an object of its width, height and points', photo);
    const { others = [], rgba, progress, ...own } = photo;
    const view = Float64Array.from(viewOf(own));
    if (!Array.isArray(others)) wrong('others', 'an array of photos', others);
    const besides = others.flatMap((other) => {
      if (typeof other !== 'object' || !other) return viewOf(other);
      const { rgba: _, ...view } = other;
      const numbers = viewOf(view);
      if (view.points.length !== 136) throw new Error(`${view.points.length / 2} points were given of another photo, a face has 68`);
      return numbers;
    });
    // What the caller does with them while the module comes is nobody's face.
    const image = rgba && rgbaOf('rgba', rgba).slice();
    // Without its own nobody asks for theirs, and what is not given has no bytes.
    const images = others.map(({ rgba }) => {
      const pixels = rgba && rgbaOf("another photo's rgba", rgba);
      return image && pixels ? pixels.slice() : new Uint8Array(0);
    });
    const fitter = await this.#photoFitter();
    // It may have been freed while the module came.
    this.#live;
    return fitter.fit(view, Float64Array.from(besides), image, images, progress);
  }

  /** @param {{ width: number, height: number, fit: import('phiz').PhotoFit, rgba?: Uint8Array | Uint8ClampedArray, others?: readonly import('phiz').PhotoOther[] }} photo */
  async editPhoto(photo) {
    if (typeof photo !== 'object' || !photo) wrong('a photo', 'an object of its width, height and fit', photo);
    const { width, height, fit, rgba, others = [], ...more } = photo;
    noMore('editPhoto', more);
    const size = sizeOf(width, height);
    checkFit(fit);
    const { camera, light, code, expression } = fit;
    const image = rgba && rgbaOf('rgba', rgba).slice();
    if (!Array.isArray(others)) wrong('others', 'an array of photos', others);
    const besides = others.map((other) => {
      const { width, height, shot, rgba, detail, ...none } = record('another photo', other);
      noMore('editPhoto', none);
      const finer = detail && { ...detail, rgba: rgbaOf("a detail's rgba", detail.rgba).slice() };
      return { size: sizeOf(width, height), shot, rgba: rgbaOf("another photo's rgba", rgba).slice(), detail: finer };
    });
    const checks = { pixels, string, number, rgbaOf };
    const [glue, { PhotoEdit, numbersOf, otherOf }] = await Promise.all([loadedPhotoModule(), import('./photoedit.js')]);
    const seen = besides.map((other) => otherOf(other, checks));
    // Those that the fitter is made for: others may come while it is.
    const names = this.expressions;
    const fitter = await this.#photoFitter();
    this.#live;
    const weigh = (/** @type {Readonly<Record<string, number>>} */ shown) => {
      const unknown = Object.keys(shown).find((name) => !names.includes(name));
      if (unknown !== undefined) {
        const isNew = this.expressions.includes(unknown);
        throw new Error(isNew ? 'the photo was opened before its model had expressions: open it again' : `the model has no expression "${unknown}"`);
      }
      return Float64Array.from(names, (name) => shown[name] ?? 0);
    };
    const raw = glue.PhotoEdit.open(
      fitter,
      size,
      numbersOf(camera),
      Float64Array.from(light?.coefficients.flat() ?? []),
      string('the code of a fit', code),
      weigh(expression),
    );
    try {
      if (image) raw.set_background(image);
      for (const { size, camera, expression, rgba, finer, place } of seen) raw.also(size, camera, code, weigh(expression), rgba, finer, place);
    } catch (error) {
      raw.free();
      throw error;
    }
    return new PhotoEdit(raw, weigh, checks);
  }

  /** Prepared for the expressions that there are; a failed download may be tried again. */
  #photoFitter() {
    this.#live;
    const expressions = this.#expressions?.packed;
    if (!this.#photos || this.#photos.expressions !== expressions) {
      const earlier = this.#photos;
      const photos = { fitter: this.#newFitter(expressions), expressions };
      photos.fitter.catch(() => {
        if (this.#photos === photos) this.#photos = null;
      });
      earlier?.fitter.then(release, () => {});
      this.#photos = photos;
    }
    return this.#photos.fitter;
  }

  /** @param {Uint8Array | undefined} expressions */
  async #newFitter(expressions) {
    const [glue, blob, more] = await Promise.all([
      loadedPhotoModule(),
      this.#packed ? unpack(this.#packed) : this.#live.blob(),
      expressions && unpack(expressions),
    ]);
    return glue.Fitter.parse(blob, more);
  }

  get controls() {
    return this.#info.controls;
  }
  get regions() {
    return this.#info.regions;
  }
  get regionNames() {
    return this.#info.regionNames;
  }
  get regionGroups() {
    return this.#info.regionGroups;
  }
  get blending() {
    return this.#info.blending;
  }
  get parts() {
    return this.#info.parts;
  }
  get landmarks() {
    return this.#info.landmarks;
  }
  get measures() {
    return this.#info.measures;
  }
  get attributes() {
    return this.#info.attributes;
  }
  get about() {
    return this.#info.about;
  }

  /** All of it is copied out of wasm memory at once: a copy takes room there, and where memory grows views are detached. */
  get #topology() {
    if (!this.#copied) {
      const raw = this.#live;
      this.#copied = {
        triangles: raw.uv_triangles(),
        uvs: raw.uvs(),
        uvVertices: raw.uv_vertices(),
        colours: raw.colours(),
        regionOf: raw.region_of(),
        mirror: raw.mirror(),
        vertexCount: raw.vertex_count(),
      };
    }
    return this.#copied;
  }

  get triangles() {
    return this.#topology.triangles;
  }
  get uvs() {
    return this.#topology.uvs;
  }
  get uvVertices() {
    return this.#topology.uvVertices;
  }
  get colours() {
    return this.#topology.colours;
  }
  get regionOf() {
    return this.#topology.regionOf;
  }
  get mirror() {
    return this.#topology.mirror;
  }
  get vertexCount() {
    return this.#topology.vertexCount;
  }

  free() {
    if (!this.#raw) return;
    for (const entry of this.#faces) entry.deref()?.free();
    this.#faces.clear();
    release(this.#expressions?.raw);
    this.#expressions = null;
    this.#photos?.fitter.then(release, () => {});
    this.#photos = null;
    release(this.#raw);
    this.#raw = null;
  }
}

export class Face {
  /** @type {RawFace | null} */
  #raw;
  #model;
  #memory;
  #family;
  /** What is shown, until that changes. @type {Readonly<Record<string, number>> | null} */
  #shown = null;

  /**
   * @param {RawFace} raw
   * @param {FaceModel} model
   * @param {WebAssembly.Memory} memory
   * @param {{
   *   adopt: (raw: RawFace) => Face,
   *   expressions: () => { raw: RawExpressions, names: string[] } | null,
   * }} family what only the model knows
   */
  constructor(raw, model, memory, family) {
    this.#raw = raw;
    this.#model = model;
    this.#memory = memory;
    this.#family = family;
  }

  get #live() {
    if (!this.#raw) throw new Error('this Face was freed and cannot be used any more');
    return this.#raw;
  }

  get model() {
    return this.#model;
  }
  get controls() {
    return this.#model.controls;
  }

  /** @param {string} control @param {number} value */
  set(control, value) {
    this.#live.set(string('a control', control), number('the value of a control', value));
  }
  /** @param {string} control */
  get(control) {
    return this.#live.get(string('a control', control));
  }
  /** @param {string} [region] */
  reset(region) {
    this.#live.reset(region === undefined ? region : string('a region', region));
  }
  /** @param {Face} other @param {number} t @param {{ regions?: readonly string[] }} [options] */
  blend(other, t, options) {
    const { regions, ...others } = options ?? {};
    noMore('blend', others);
    if (!(other instanceof Face)) wrong('the face to blend with', 'a Face', other);
    if (other.#memory !== this.#memory) throw new Error('faces of models that were loaded with different builds cannot be blended: take the code of one');
    // wasm-bindgen does not lend the same face twice; a copy makes the same checks.
    const source = other === this ? other.clone() : other;
    try {
      this.#live.blend(source.#live, number('t', t), strings('regions', regions));
    } finally {
      if (source !== other) source.free();
    }
  }
  /** @param {string} name */
  attribute(name) {
    return this.#live.attribute(string('an attribute', name));
  }
  /** @param {Readonly<Record<string, number>>} values */
  setAttributes(values) {
    const named = namedNumbers(values);
    this.#live.set_attributes(...named);
  }
  /** @param {{ seed?: number, spread?: number, regions?: readonly string[], attributes?: Readonly<Record<string, number>> }} [options] */
  randomize(options) {
    const { seed, spread, regions, attributes = {}, ...others } = record('what randomize is given', options ?? {});
    noMore('randomize', others);
    return this.#live.randomize(
      seed === undefined ? seed : number('a seed', seed),
      spread === undefined ? spread : number('spread', spread),
      strings('regions', regions),
      ...namedNumbers(attributes),
    );
  }
  /** @param {string} region */
  lock(region) {
    this.#live.lock(string('a region', region));
  }
  /** @param {string} region */
  unlock(region) {
    this.#live.unlock(string('a region', region));
  }
  get locked() {
    return this.#live.locked();
  }
  /** @param {string} name */
  measure(name) {
    return this.#live.measure(string('a measure', name));
  }
  /** @param {string} name @param {number} value */
  setMeasure(name, value) {
    this.#live.set_measure(string('a measure', name), number('the value of a measure', value));
  }
  /** @param {string} control */
  clear(control) {
    this.#live.clear(string('a control', control));
  }
  /** @param {string} name */
  lockMeasure(name) {
    this.#live.lock_measure(string('a measure', name));
  }
  /** @param {string} name */
  unlockMeasure(name) {
    this.#live.unlock_measure(string('a measure', name));
  }
  get lockedMeasures() {
    return this.#live.locked_measures();
  }
  /** @param {number} vertex @param {ArrayLike<number>} target */
  drag(vertex, target) {
    if (!Number.isInteger(vertex) || vertex < 0 || vertex >= this.#model.vertexCount) throw new Error(`there is no vertex ${String(vertex)}`);
    if (typeof target !== 'object' || target?.length !== 3) wrong('the target of a vertex', 'an array of three numbers', target);
    const [x, y, z] = [0, 1, 2].map((axis) => number('a coordinate', target[axis]));
    this.#live.drag(vertex, x, y, z);
  }
  /** @param {string} name @param {number} weight */
  express(name, weight) {
    const raw = this.#live;
    const expressions = this.#family.expressions();
    if (!expressions) throw new Error('the model has no expressions yet: see loadExpressions');
    this.#shown = null;
    raw.express(expressions.raw, string('an expression', name), number('the weight of an expression', weight));
  }
  get expression() {
    const raw = this.#live;
    if (this.#shown) return this.#shown;
    const weights = raw.weights();
    /** @type {Record<string, number>} */
    const shown = {};
    for (const [i, name] of this.#model.expressions.entries()) {
      if (weights[i] > 0) shown[name] = weights[i];
    }
    return (this.#shown = Object.freeze(shown));
  }
  #relax() {
    this.#shown = null;
    this.#live.relax();
  }
  set expression(shown) {
    record('an expression', shown);
    const before = this.expression;
    this.#relax();
    try {
      for (const [name, weight] of Object.entries(shown)) this.express(name, weight);
    } catch (error) {
      this.#relax();
      for (const [name, weight] of Object.entries(before)) this.express(name, weight);
      throw error;
    }
  }

  get code() {
    return this.#live.code();
  }
  set code(code) {
    this.#live.set_code(string('a code', code));
  }
  get coefficients() {
    return this.#live.coefficients();
  }
  set coefficients(coefficients) {
    if (typeof coefficients !== 'object' || !(coefficients?.length >= 0)) wrong('coefficients', 'an array of numbers', coefficients);
    if (Array.isArray(coefficients)) for (const value of coefficients) number('a coefficient', value);
    this.#live.set_coefficients(coefficients);
  }
  get alpha() {
    return this.#live.alpha();
  }
  set alpha(mm) {
    this.#live.set_alpha(number('alpha', mm));
  }

  /** The heap may have grown, and then old views are detached: views are made again each time. @param {number} pointer */
  #view(pointer) {
    // Before the view, which then outlives that all of the topology is read.
    const length = 3 * this.#model.vertexCount;
    return new Float32Array(this.#memory.buffer, pointer, length);
  }
  get positions() {
    return this.#view(this.#live.positions_ptr());
  }
  get normals() {
    return this.#view(this.#live.normals_ptr());
  }
  /** @returns {[number, number]} */
  get changed() {
    const raw = this.#live;
    return [raw.changed_first(), raw.changed_end()];
  }

  clone() {
    return this.#family.adopt(this.#live.duplicate());
  }
  free() {
    release(this.#raw);
    this.#raw = null;
  }
}
