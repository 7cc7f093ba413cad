// What is read of a photo's file before its pixels.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { deflateSync } from 'node:zlib';

import { focalOf, headerOf } from '../../www/src/photo/exif.js';
import { spaceOf } from '../../www/src/photo/profile.js';
import { xmpPacket } from '../../www/src/photo/xmp.js';

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
/** A segment of XMP for a JPEG. @param {string} packet */
function app1(packet) {
  const body = Buffer.from(`http://ns.adobe.com/xap/1.0/\0${packet}`);
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

/** As profiles have them. */
const DISPLAY_P3 = [[0.5151, 0.2412, -0.0011], [0.292, 0.6922, 0.0419], [0.1571, 0.0666, 0.7841]];
const ADOBE_RGB = [[0.6097, 0.3111, 0.0195], [0.2053, 0.6257, 0.0609], [0.1492, 0.0632, 0.7446]];
const SRGB = [[0.436, 0.2225, 0.0139], [0.3851, 0.7169, 0.0971], [0.1431, 0.0606, 0.7141]];
/** What of an ICC profile says where its primaries are. @param {number[][]} primaries */
function profileOf(primaries) {
  const profile = Buffer.alloc(132 + 3 * (12 + 20));
  profile.writeUInt32BE(3, 128);
  primaries.forEach((xyz, i) => {
    const place = 132 + 3 * 12 + 20 * i;
    profile.write(`${'rgb'[i]}XYZ`, 132 + 12 * i);
    profile.writeUInt32BE(place, 132 + 12 * i + 4);
    xyz.forEach((value, axis) => profile.writeInt32BE(Math.round(65536 * value), place + 8 + 4 * axis));
  });
  return profile;
}
/** A PNG's beginning, without sums, which nobody checks here. @param {[name: string, data: Buffer][]} chunks */
function pngWith(...chunks) {
  const parts = [Buffer.from('\x89PNG\r\n\x1a\n', 'latin1')];
  for (const [name, data] of [['IHDR', Buffer.alloc(13)], ...chunks, ['IDAT', Buffer.alloc(8)]]) {
    const length = Buffer.alloc(4);
    length.writeUInt32BE(data.length);
    parts.push(length, Buffer.from(name), data, Buffer.alloc(4));
  }
  return Uint8Array.from(Buffer.concat(parts)).buffer;
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
    // Bytes that fill stand before a marker.
    const whole = Buffer.from(photoWith(turned));
    const filled = Buffer.concat([whole.subarray(0, 2), Buffer.from([0xff, 0xff]), whole.subarray(2)]);
    assert.deepEqual(headerOf(Uint8Array.from(filled).buffer).size, [300, 512]);
  });

  test('says through which lens, by the diagonal of film, unless it was cut', () => {
    const focal = (/** @type {number} */ width, /** @type {number} */ height, focal35 = 26) => focalOf(width, height, focal35);
    const near = (/** @type {number | undefined} */ px, /** @type {number} */ wanted) => assert.ok(px && Math.abs(px / wanted - 1) < 0.001, `${px} is not ${wanted}`);
    // Film is as wide as high as 3 : 2; telephones are as 4 : 3, and show parts of that as 16 : 9.
    near(focal(6000, 4000, 85), (6000 * 85) / 36);
    near(focal(4000, 3000), (5000 * 26) / 43.27);
    near(focal(3000, 4000), (5000 * 26) / 43.27);
    near(focal(4000, 2250), (5000 * 26) / 43.27);
    assert.equal(focal(3000, 3000), undefined);
    assert.equal(focalOf(4000, 3000, null), undefined);
  });

  test('says whose it is, and so does the note in the file that is saved', () => {
    const credits = (/** @type {Entry[]} */ ...entries) => headerOf(photoWith(exifOf(...entries))).credits;
    const [ARTIST, COPYRIGHT, DESCRIPTION] = [0x013b, 0x8298, 0x010e];
    const named = credits([ARTIST, TEXT, 'Ann; Zoë \0'], [COPYRIGHT, TEXT, '© <Ann> & Co.\0Zoë\0'], [DESCRIPTION, TEXT, 'me\0']);
    assert.deepEqual(named, { artist: 'Ann; Zoë', copyright: '© <Ann> & Co.; Zoë', description: 'me' });
    const none = { artist: '', copyright: '', description: '' };
    assert.deepEqual(headerOf(photoWith()).credits, none);
    assert.deepEqual(credits([ARTIST, SHORT, 3], [COPYRIGHT, TEXT, '\0\0\0\0']), none);
    // Of one that says that it is longer than the file nothing is taken; of a book its beginning.
    const long = exifOf([ARTIST, TEXT, 'Somebody']);
    long.writeUInt32BE(0xffff0000, long.indexOf('Somebody') - 4 - 4 - 4);
    assert.equal(headerOf(photoWith(long)).credits.artist, '');
    assert.equal(credits([DESCRIPTION, TEXT, 'word '.repeat(5000)]).description.length, 1000);
    // Before UTF-8.
    assert.equal(headerOf(photoWith(Buffer.from(exifOf([ARTIST, TEXT, 'Zo_ and others']).toString('latin1').replace('_', 'ë'), 'latin1'))).credits.artist, 'Zoë and others');

    const packet = xmpPacket('Edited', named);
    assert.match(packet, /<dc:creator><rdf:Seq><rdf:li>Ann<\/rdf:li><rdf:li>Zoë<\/rdf:li><\/rdf:Seq><\/dc:creator>/);
    assert.match(packet, /<dc:rights><rdf:Alt><rdf:li xml:lang="x-default">© &#60;Ann&#62; &#38; Co\.; Zoë<\/rdf:li><\/rdf:Alt><\/dc:rights>/);
    assert.match(packet, /<dc:description><rdf:Alt><rdf:li xml:lang="x-default">me\nEdited<\/rdf:li>/);
    assert.ok(!/creator|rights/.test(xmpPacket('Edited', none)));
    const unedited = xmpPacket('', { ...none, description: 'a\x01b' });
    assert.ok(!/humanEdits|Instructions/.test(unedited));
    assert.match(unedited, />ab<\/rdf:li>/);
    // What a model made stays that, and what nobody edits stays what it was.
    const type = (/** @type {string} */ name) => `http://cv.iptc.org/newscodes/digitalsourcetype/${name}`;
    for (const [note, was, is] of [['Edited', 'digitalCapture', 'humanEdits'], ['Edited', 'trainedAlgorithmicMedia', 'trainedAlgorithmicMedia'], ['', 'digitalCapture', 'digitalCapture']]) {
      assert.ok(xmpPacket(note, { ...none, source: type(was) }).includes(`DigitalSourceType="${type(is)}"`), `${note} ${was}`);
    }
    // The packet is found again.
    for (const file of [photoWith(app1(packet)), pngWith(['iTXt', Buffer.from(`XML:com.adobe.xmp\0\0\0\0\0${packet}`)])]) assert.equal(headerOf(file).xmp, packet);
    assert.equal(headerOf(photoWith()).xmp, '');
  });

  test('says whether it has more colours than sRGB', async () => {
    const space = (/** @type {ArrayBuffer} */ bytes) => spaceOf(headerOf(bytes).profile);
    const inJpeg = (/** @type {Buffer} */ profile) => {
      const body = Buffer.concat([Buffer.from('ICC_PROFILE\0\x01\x01', 'latin1'), profile]);
      return photoWith(Buffer.concat([Buffer.from([0xff, 0xe2, (body.length + 2) >> 8, (body.length + 2) & 255]), body]));
    };
    const inPng = (/** @type {Buffer} */ profile) => pngWith(['iCCP', Buffer.concat([Buffer.from('its name\0\0', 'latin1'), deflateSync(profile)])]);
    for (const file of [inJpeg, inPng]) {
      for (const wide of [DISPLAY_P3, ADOBE_RGB]) assert.equal(await space(file(profileOf(wide))), 'display-p3');
      assert.equal(await space(file(profileOf(SRGB))), 'srgb');
      assert.equal(await space(file(profileOf(DISPLAY_P3).subarray(0, 160))), 'srgb', 'half of one is none');
    }
    assert.equal(await space(pngWith(['iCCP', Buffer.from('its name\0\0what is not packed', 'latin1')])), 'srgb');
    for (const primaries of [9, 12]) assert.equal(await space(pngWith(['cICP', Buffer.from([primaries, 13, 0, 1])])), 'display-p3');
    assert.equal(await space(pngWith(['cICP', Buffer.from([1, 13, 0, 1])])), 'srgb');
    assert.equal(await space(pngWith()), 'srgb');
    // As telephones save it: a property with a number or a profile, which counts before it, in boxes of boxes.
    const box = (/** @type {string} */ name, /** @type {Buffer[]} */ ...inside) => {
      const head = Buffer.alloc(8);
      head.writeUInt32BE(8 + Buffer.concat(inside).length);
      head.write(name, 4);
      return Buffer.concat([head, ...inside]);
    };
    const numbers = (/** @type {number} */ primaries) => box('colr', Buffer.from('nclx'), Buffer.from([0, primaries, 0, 13, 0, 6, 0x80]));
    const profiled = (/** @type {number[][]} */ primaries) => box('colr', Buffer.from('prof'), profileOf(primaries));
    const heif = (/** @type {Buffer[]} */ ...properties) =>
      Uint8Array.from(Buffer.concat([box('ftyp', Buffer.from('heic\0\0\0\0')), box('meta', Buffer.alloc(4), box('iprp', box('ipco', ...properties)))])).buffer;
    assert.equal(await space(heif(numbers(12))), 'display-p3');
    assert.equal(await space(heif(numbers(1))), 'srgb');
    assert.equal(await space(heif(profiled(DISPLAY_P3))), 'display-p3');
    for (const both of [[numbers(12), profiled(SRGB)], [profiled(SRGB), numbers(12)]]) assert.equal(await space(heif(...both)), 'srgb');
    assert.equal(await space(heif()), 'srgb');
    assert.equal(await space(photoWith()), 'srgb', 'the portrait is of sRGB');
  });
});
