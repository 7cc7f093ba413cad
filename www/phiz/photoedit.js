/**
 * What the package checks what it is given by: imported they would be a third file, which the first face would wait for.
 * @typedef {{ pixels: (what: string, value: unknown) => number, string: (what: string, value: unknown) => string, number: (what: string, value: unknown) => number, rgbaOf: (what: string, value: unknown) => Uint8Array }} Checks
 */

/**
 * Finer pixels of a part of a photo, and their place: their size, corner and scale.
 * @param {import('phiz').PhotoDetail | undefined} detail @param {Checks} checks
 * @returns {[Uint8Array | undefined, Float64Array]}
 */
function finerOf(detail, { pixels, number, rgbaOf }) {
  if (!detail) return [undefined, new Float64Array()];
  const place = [pixels('width', detail.width), pixels('height', detail.height), number('left', detail.left), number('top', detail.top), number('scale', detail.scale)];
  return [rgbaOf("a detail's rgba", detail.rgba), Float64Array.from(place)];
}

/** @param {import('phiz').PhotoCamera} camera */
export const numbersOf = ({ focal, centre, rotation, translation }) => Float64Array.of(focal, ...centre, ...rotation, ...translation);

/**
 * Another photo of the person, as the module takes it.
 * @param {Pick<import('phiz').PhotoOther, 'shot' | 'detail'> & { size: Uint32Array, rgba: Uint8Array }} other @param {Checks} checks
 */
export function otherOf({ size, shot, rgba, detail }, checks) {
  const { camera, expression } = shot ?? {};
  if (camera?.rotation?.length !== 9 || typeof expression !== 'object' || !expression) throw new TypeError('the shot of another photo must be one of the `others` of what `fitPhoto` gave');
  const [finer, place] = finerOf(detail, checks);
  return { size, camera: numbersOf(camera), expression, rgba, finer, place };
}

/** A photo whose face can be changed. */
export class PhotoEdit {
  /** @type {import('./raw-photo.js').PhotoEdit | null} */
  #raw;
  #weigh;
  #checks;

  /**
   * @param {import('./raw-photo.js').PhotoEdit} raw
   * @param {(expression: Readonly<Record<string, number>>) => Float64Array} weigh
   * @param {Checks} checks
   */
  constructor(raw, weigh, checks) {
    this.#raw = raw;
    this.#weigh = weigh;
    this.#checks = checks;
  }

  get #live() {
    if (!this.#raw) throw new Error('this PhotoEdit was freed and cannot be used any more');
    return this.#raw;
  }

  /** @param {import('phiz').PhotoShape} shape */
  field(shape) {
    return this.#live.field(...this.#shape(shape));
  }
  /** @param {import('phiz').PhotoShape} shape @param {Uint8Array | Uint8ClampedArray} rgba */
  render(shape, rgba) {
    return new Uint8ClampedArray(this.#live.render(this.#checks.rgbaOf('rgba', rgba), ...this.#shape(shape)).buffer);
  }
  /** @param {Uint8Array | Uint8ClampedArray} rgba @param {number} [size] @param {import('phiz').PhotoDetail} [detail] */
  texture(rgba, size = 1024, detail) {
    const { pixels, rgbaOf } = this.#checks;
    return new Uint8ClampedArray(this.#live.texture(rgbaOf('rgba', rgba), pixels('texture', size), ...finerOf(detail, this.#checks)).buffer);
  }
  /** @param {Uint8Array | Uint8ClampedArray} rgba @param {ArrayLike<number>} [irises] */
  looks(rgba, irises) {
    const { rgbaOf, number } = this.#checks;
    if (irises !== undefined && irises?.length !== 4) throw new TypeError(`irises must be an array of x, y, x, y, not ${irises}`);
    return this.#live.looks(rgbaOf('rgba', rgba), Float64Array.from(irises ?? [], (value) => number('a place of an iris', value)));
  }
  /** @param {Uint8Array | Uint8ClampedArray} rgba @param {Uint32Array} corners @param {Float32Array} shares */
  albedos(rgba, corners, shares) {
    if (!(corners instanceof Uint32Array)) throw new TypeError(`corners must be a Uint32Array, not ${corners}`);
    if (!(shares instanceof Float32Array)) throw new TypeError(`shares must be a Float32Array, not ${shares}`);
    return this.#live.albedos(this.#checks.rgbaOf('rgba', rgba), corners, shares);
  }
  /** @param {import('phiz').PhotoShape} shape @returns {[string, Float64Array]} */
  #shape(shape) {
    if (typeof shape?.expression !== 'object' || !shape.expression) throw new TypeError('a shape is a code and an expression, as a Face or a fit has them');
    return [this.#checks.string('a code', shape.code), this.#weigh(shape.expression)];
  }
  free() {
    const raw = this.#raw;
    this.#raw = null;
    try {
      raw?.free();
    } catch {
      // What was at work when memory ran out is never given back: nobody is told a second time.
    }
  }
}
