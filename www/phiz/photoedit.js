/** A photo whose face can be changed. */
export class PhotoEdit {
  /** @type {import('./raw-photo.js').PhotoEdit | null} */
  #raw;
  #weigh;
  #checks;

  /**
   * @param {import('./raw-photo.js').PhotoEdit} raw
   * @param {(expression: Readonly<Record<string, number>>) => Float64Array} weigh
   * @param {{ pixels: (what: string, value: unknown) => number, string: (what: string, value: unknown) => string }} checks
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
  field({ code, expression }) {
    return this.#live.field(this.#checks.string('a code', code), this.#weigh(expression));
  }
  /** @param {import('phiz').PhotoShape} shape @param {Uint8Array | Uint8ClampedArray} rgba */
  render({ code, expression }, rgba) {
    return new Uint8ClampedArray(this.#live.render(rgba, this.#checks.string('a code', code), this.#weigh(expression)).buffer);
  }
  /** @param {Uint8Array | Uint8ClampedArray} rgba @param {number} [size] @param {import('phiz').PhotoDetail} [detail] */
  texture(rgba, size = 1024, detail) {
    const place = detail ? [this.#checks.pixels('width', detail.width), this.#checks.pixels('height', detail.height), detail.left, detail.top, detail.scale] : [];
    const finer = detail && new Uint8Array(detail.rgba.buffer, detail.rgba.byteOffset, detail.rgba.byteLength);
    return new Uint8ClampedArray(this.#live.texture(rgba, this.#checks.pixels('texture', size), finer, Float64Array.from(place)).buffer);
  }
  /** @param {Uint8Array | Uint8ClampedArray} rgba */
  looks(rgba) {
    return this.#live.looks(rgba);
  }
  free() {
    this.#raw?.free();
    this.#raw = null;
  }
}
