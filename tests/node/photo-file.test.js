// What is read of a photo's file before its pixels.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';

import { headerOf } from '../../www/src/photo/exif.js';

/** 512 x 512; its width is made another. */
const PORTRAIT = await readFile(new URL('../../www/public/astronaut.jpg', import.meta.url));

/** An entry of EXIF: tag, type, and its value or values. @typedef {[tag: number, type: number, value: number | string]} Entry */
const [TEXT, SHORT, LONG] = [2, 3, 4];
const ORIENTATION = 0x0112;

/** An EXIF segment for a JPEG. @param {Entry[]} entries */
function exifOf(...entries) {
  const tiff = Buffer.alloc(8 + 2 + 12 * entries.length + 4);
  tiff.write('MM\0*', 0, 'latin1');
  tiff.writeUInt32BE(8, 4);
  tiff.writeUInt16BE(entries.length, 8);
  let rest = Buffer.alloc(0);
  entries.forEach(([tag, type, value], i) => {
    const at = 10 + 12 * i;
    tiff.writeUInt16BE(tag, at);
    tiff.writeUInt16BE(type, at + 2);
    tiff.writeUInt32BE(typeof value === 'string' ? Buffer.byteLength(value) : 1, at + 4);
    if (type === SHORT) tiff.writeUInt16BE(Number(value), at + 8);
    else if (typeof value === 'number') tiff.writeUInt32BE(value, at + 8);
    else if (Buffer.byteLength(value) <= 4) tiff.write(value, at + 8);
    else {
      tiff.writeUInt32BE(tiff.length + rest.length, at + 8);
      rest = Buffer.concat([rest, Buffer.from(value)]);
    }
  });
  const body = Buffer.concat([Buffer.from('Exif\0\0', 'latin1'), tiff, rest]);
  return Buffer.concat([Buffer.from([0xff, 0xe1, (body.length + 2) >> 8, (body.length + 2) & 255]), body]);
}
/** The portrait, 512 wide and 300 high as its header says, with segments before the others. @param {Buffer[]} segments */
function photoWith(...segments) {
  const { buffer, byteOffset, byteLength } = Buffer.concat([PORTRAIT.subarray(0, 2), ...segments, PORTRAIT.subarray(2)]);
  const bytes = new Uint8Array(buffer.slice(byteOffset, byteOffset + byteLength));
  const view = new DataView(bytes.buffer);
  for (let at = 2; ; at += 2 + view.getUint16(at + 2)) {
    if (![0xc0, 0xc2].includes(view.getUint8(at + 1))) continue;
    view.setUint16(at + 5, 300);
    return bytes.buffer;
  }
}

describe('a photo’s file', () => {
  test('says which way up it is, as browsers take it', () => {
    /** @param {Buffer[]} segments */
    const size = (...segments) => headerOf(photoWith(...segments)).size;
    assert.deepEqual(size(), [512, 300]);
    for (let orientation = 0; orientation <= 10; orientation += 1) {
      const lies = orientation >= 5 && orientation <= 8;
      assert.deepEqual(size(exifOf([ORIENTATION, SHORT, orientation])), lies ? [300, 512] : [512, 300], `${orientation}`);
    }
    // Of another type it is no orientation.
    assert.deepEqual(size(exifOf([ORIENTATION, LONG, 6])), [512, 300]);
    // The first segment counts.
    const [upright, turned] = [1, 6].map((value) => exifOf([ORIENTATION, SHORT, value]));
    assert.deepEqual(size(upright, turned), [512, 300]);
    assert.deepEqual(size(turned, upright), [300, 512]);
  });
});
