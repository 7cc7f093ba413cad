/** A photo whose face can be changed. */
export class PhotoEdit {
  /** @type {import('./raw-photo.js').PhotoEdit | null} */
  #raw;
  #weigh;
  #checks;

  /**
   * @param {import('./raw-photo.js').PhotoEdit} raw
   * @param {(expression: Readonly<Record<string, number>>) => Float64Array} weigh
   * @param {{ pixels: (what: string, value: unknown) => number, string: (what: string, value: unknown) => string, number: (what: string, value: unknown) => number, rgbaOf: (what: string, value: unknown) => Uint8Array }} checks
   *   of the package: imported they would be a third file, which the first face would wait for
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
    const { pixels, number, rgbaOf } = this.#checks;
    const at = detail && [number('left', detail.left), number('top', detail.top), number('scale', detail.scale)];
    const place = detail && at ? [pixels('width', detail.width), pixels('height', detail.height), ...at] : [];
    const finer = detail && rgbaOf("a detail's rgba", detail.rgba);
    return new Uint8ClampedArray(this.#live.texture(rgbaOf('rgba', rgba), pixels('texture', size), finer, Float64Array.from(place)).buffer);
  }
  /** @param {Uint8Array | Uint8ClampedArray} rgba */
  looks(rgba) {
    return this.#live.looks(this.#checks.rgbaOf('rgba', rgba));
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
