/**
 * Little-endian numbers one after the other: what PLY, STL and GLB are made of.
 */
export class ByteWriter {
  #view;
  #at = 0;

  /** @param {number} length in bytes, all of which will be written */
  constructor(length) {
    this.#view = new DataView(new ArrayBuffer(length));
  }

  /** @param {number} value */
  u8(value) {
    this.#view.setUint8(this.#at, value);
    this.#at += 1;
  }
  /** @param {number} value */
  u16(value) {
    this.#view.setUint16(this.#at, value, true);
    this.#at += 2;
  }
  /** @param {number} value */
  u32(value) {
    this.#view.setUint32(this.#at, value, true);
    this.#at += 4;
  }
  /** @param {number} value */
  f32(value) {
    this.#view.setFloat32(this.#at, value, true);
    this.#at += 4;
  }
  /** @param {Uint8Array} bytes */
  bytes(bytes) {
    new Uint8Array(this.#view.buffer).set(bytes, this.#at);
    this.#at += bytes.length;
  }

  /** Everything, once all of it was written. */
  finish() {
    if (this.#at !== this.#view.byteLength) {
      throw new RangeError(`${this.#at} of ${this.#view.byteLength} bytes were written`);
    }
    return new Uint8Array(this.#view.buffer);
  }
}
