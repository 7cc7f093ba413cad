import assert from 'node:assert/strict';

/** A number as wasm writes it, in as many bytes as it takes. @param {number} value */
function leb(value) {
  const bytes = [];
  do bytes.push((value & 0x7f) | (value > 0x7f ? 0x80 : 0));
  while ((value >>>= 7));
  return bytes;
}

/** A wasm module with a limit to its memory. @param {Uint8Array} module @param {number} pages of 64 KiB */
export function limited(module, pages) {
  let at = 8;
  const number = () => {
    for (let value = 0, shift = 0; ; shift += 7) {
      const byte = module[at++];
      value |= (byte & 0x7f) << shift;
      if (byte < 0x80) return value;
    }
  };
  while (at < module.length) {
    const start = at;
    const section = module[at++];
    const size = number();
    const end = at + size;
    if (section === 5) {
      assert.equal(number(), 1, 'one memory');
      number();
      const content = [1, 1, ...leb(number()), ...leb(pages)];
      return Buffer.concat([module.subarray(0, start), Uint8Array.from([5, ...leb(content.length), ...content]), module.subarray(end)]);
    }
    at = end;
  }
  throw new Error('no memory in the module');
}
