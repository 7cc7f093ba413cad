// What is wanted of a photo's file before its pixels: how large it is, which way up, in which colours, of
// whom, and the focal length as if for film. A library for all of EXIF is many times this, and what it would read besides is of no
// use here.

/** Types of EXIF 3. */
const ASCII = 2;
const SHORT = 3;
const UTF8 = 129;
/** Its tags. */
const ORIENTATION = 0x0112;
const DESCRIPTION = 0x010e;
const ARTIST = 0x013b;
const COPYRIGHT = 0x8298;
const EXIF_IFD = 0x8769;
const FOCAL_35 = 0xa405;

/** What stands before an XMP packet in a JPEG, and in a PNG, where it is not packed and has no language. */
const XMP = { jpeg: 'http://ns.adobe.com/xap/1.0/\0', png: 'XML:com.adobe.xmp\0\0\0' };

/** The first letter of `colr`. */
const C = 0x63;

/** Letters of each that are kept: a note in a JPEG has no room for whole books. */
const MOST = 1000;
/** What cameras have, mm; anything else is a mistake. */
const FOCALS = [8, 800];

/**
 * The shapes of what sensors give, and of which each is: what is seen in 16 : 9 is cut from 4 : 3, as wide. Anything else was cut
 * otherwise, and then its focal length is another's.
 */
const SHAPES = [[4 / 3, 4 / 3], [3 / 2, 3 / 2], [16 / 9, 4 / 3]];
/** Of film, mm, by which focal lengths are told as if for it (CIPA DCG-001). */
const DIAGONAL = Math.hypot(36, 24);

/** @typedef {Parameters<typeof import('./profile.js').spaceOf>[0]} Profile */
/** What a photo says of itself and of who made it; empty: nothing. @typedef {{ artist: string, copyright: string, description: string }} Credits */
/** @type {Credits} */
const NOTHING = { artist: '', copyright: '', description: '' };

/** @param {DataView} view @param {number} at @param {number} length */
function nameAt(view, at, length) {
  return at + length > view.byteLength ? '' : String.fromCharCode(...new Uint8Array(view.buffer, view.byteOffset + at, length));
}

/**
 * What a file's parts say: its size as stored, where the TIFF of its EXIF begins, or -1, its XMP packet and its ICC profile.
 * @param {DataView<ArrayBuffer>} view
 */
function partsOf(view) {
  /** @type {{ kind: string | null, size: [number, number] | null, tiff: number, xmp: Uint8Array | null, profile: Profile }} */
  const parts = { kind: null, size: null, tiff: -1, xmp: null, profile: { icc: null, isPacked: false, primaries: null } };
  const { profile } = parts;
  const bytes = (/** @type {number} */ at, /** @type {number} */ end) => new Uint8Array(view.buffer).subarray(at, end);
  if (view.byteLength < 16) return parts;
  if (view.getUint16(0) === 0xffd8) {
    parts.kind = 'jpeg';
    for (let at = 2; at + 10 < view.byteLength && view.getUint8(at) === 0xff; at += 2 + view.getUint16(at + 2)) {
      // A marker may have more of these before it, which fill.
      while (at + 10 < view.byteLength && view.getUint8(at + 1) === 0xff) at += 1;
      const marker = view.getUint8(at + 1);
      // Of several the first counts, as in browsers.
      if (marker === 0xe1 && parts.tiff < 0 && nameAt(view, at + 4, 6) === 'Exif\0\0') parts.tiff = at + 10;
      if (marker === 0xe1 && nameAt(view, at + 4, XMP.jpeg.length) === XMP.jpeg) parts.xmp ??= bytes(at + 4 + XMP.jpeg.length, at + 2 + view.getUint16(at + 2));
      // A long profile goes on in others; what is wanted stands at its beginning.
      if (marker === 0xe2 && !profile.icc && nameAt(view, at + 4, 12) === 'ICC_PROFILE\0') {
        profile.icc = bytes(at + 18, at + 2 + view.getUint16(at + 2));
      }
      // A start of frame; three of the sixteen are something else.
      if (marker >= 0xc0 && marker <= 0xcf && ![0xc4, 0xc8, 0xcc].includes(marker)) {
        parts.size = [view.getUint16(at + 7), view.getUint16(at + 5)];
      }
      // The picture itself begins.
      if (marker === 0xda) break;
    }
  } else if (nameAt(view, 1, 3) === 'PNG') {
    parts.kind = 'png';
    for (let at = 8; at + 16 <= view.byteLength; at += 12 + view.getUint32(at)) {
      const name = nameAt(view, at + 4, 4);
      if (name === 'IHDR') parts.size = [view.getUint32(at + 8), view.getUint32(at + 12)];
      if (name === 'eXIf') parts.tiff = at + 8;
      if (name === 'iTXt' && nameAt(view, at + 8, XMP.png.length) === XMP.png) {
        // A language has an end, and the name in it.
        const rest = bytes(at + 8 + XMP.png.length, at + 8 + view.getUint32(at));
        parts.xmp = rest.subarray(rest.indexOf(0, rest.indexOf(0) + 1) + 1);
      }
      if (name === 'cICP') profile.primaries = view.getUint8(at + 8);
      if (name === 'iCCP') {
        // A name of at most 79 letters, its end, and the way it is packed, of which there is one.
        const named = bytes(at + 8, at + 8 + 80).indexOf(0);
        profile.icc = bytes(at + 8 + named + 2, at + 8 + view.getUint32(at));
        profile.isPacked = true;
      }
      if (name === 'IDAT') break;
    }
  } else if (nameAt(view, 0, 4) === 'RIFF' && nameAt(view, 8, 4) === 'WEBP') {
    parts.kind = 'webp';
    for (let at = 12; at + 8 <= view.byteLength; ) {
      if (nameAt(view, at, 4) === 'EXIF') parts.tiff = at + (nameAt(view, at + 8, 6) === 'Exif\0\0' ? 14 : 8);
      const length = view.getUint32(at + 4, true);
      if (nameAt(view, at, 4) === 'XMP ') parts.xmp = bytes(at + 8, at + 8 + length);
      if (nameAt(view, at, 4) === 'ICCP') profile.icc = bytes(at + 8, at + 8 + length);
      at += 8 + length + (length & 1);
    }
  } else if (nameAt(view, 0, 4) === 'GIF8') {
    parts.kind = 'gif';
    parts.size = [view.getUint16(6, true), view.getUint16(8, true)];
  } else if (nameAt(view, 4, 4) === 'ftyp') {
    parts.kind = 'avif or heif';
    // A property of the picture, in boxes of boxes: a number, or a profile, which counts first.
    const all = new Uint8Array(view.buffer);
    for (let at = all.indexOf(C, 16); at > 0 && at + 12 <= all.length && !profile.icc; at = all.indexOf(C, at + 1)) {
      if (nameAt(view, at, 4) !== 'colr') continue;
      const how = nameAt(view, at + 4, 4);
      if (how === 'nclx' && at + 10 <= all.length) profile.primaries ??= view.getUint16(at + 8);
      if (how === 'prof' || how === 'rICC') [profile.icc, profile.primaries] = [bytes(at + 8, at - 4 + view.getUint32(at - 4)), null];
    }
  }
  return parts;
}

/**
 * @param {number} width px @param {number} height px @param {number | null} focal35 of `headerOf`
 * @returns {number | undefined} px; undefined: the photo does not say
 */
export function focalOf(width, height, focal35) {
  const longer = Math.max(width, height);
  const ratio = longer / Math.min(width, height);
  const [, whole] = SHAPES.find(([shape]) => Math.abs(ratio / shape - 1) < 0.02) ?? [];
  return whole && focal35 !== null ? (longer * Math.hypot(1, 1 / whole) * focal35) / DIAGONAL : undefined;
}

/**
 * @param {ArrayBuffer} bytes the file, or its beginning
 * @returns {{ kind: string | null, size: [number, number] | null, focal35: number | null, profile: Profile, credits: Credits, xmp: string }} `kind` null: it is no
 *   picture that is known here; `size`, px, as it is seen, null: it is known after decoding; `focal35`, mm, as if
 *   for film, null: the file does not say; `profile` of its colours, as `spaceOf` takes it; `credits` of its
 *   EXIF; `xmp`, a packet, which may say more of them
 */
export function headerOf(bytes) {
  const view = new DataView(bytes);
  const { kind, size, tiff, profile, ...parts } = partsOf(view);
  const xmp = parts.xmp ? new TextDecoder().decode(parts.xmp) : '';
  if (tiff < 0 || tiff + 8 > view.byteLength) return { kind, size, focal35: null, profile, credits: NOTHING, xmp };
  const little = view.getUint16(tiff) === 0x4949;
  /** @param {number} ifd @param {number} wanted @returns {number} where its entry is; 0 when there is none */
  const entryOf = (ifd, wanted) => {
    const first = tiff + ifd;
    if (first + 2 > view.byteLength) return 0;
    const count = view.getUint16(first, little);
    for (let entry = first + 2; entry < first + 2 + 12 * count && entry + 12 <= view.byteLength; entry += 12) {
      if (view.getUint16(entry, little) === wanted) return entry;
    }
    return 0;
  };
  /** @param {number} ifd @param {number} wanted @returns {number} its value; 0 when there is none */
  const find = (ifd, wanted) => {
    const entry = entryOf(ifd, wanted);
    if (!entry) return 0;
    return view.getUint16(entry + 2, little) === SHORT ? view.getUint16(entry + 8, little) : view.getUint32(entry + 8, little);
  };
  /** @param {number} ifd @param {number} wanted @returns {string} what it says; empty when there is none */
  const wordsOf = (ifd, wanted) => {
    const entry = entryOf(ifd, wanted);
    if (!entry || ![ASCII, UTF8].includes(view.getUint16(entry + 2, little))) return '';
    const length = view.getUint32(entry + 4, little);
    const place = length > 4 ? tiff + view.getUint32(entry + 8, little) : entry + 8;
    if (place + length > view.byteLength) return '';
    const letters = new Uint8Array(bytes, place, length);
    let words;
    try {
      words = new TextDecoder('utf-8', { fatal: true }).decode(letters);
    } catch {
      words = new TextDecoder('windows-1252').decode(letters);
    }
    // An end stands between the copyrights of who took and who edited it, too.
    return words.split('\0').map((part) => part.trim()).filter(Boolean).join('; ').slice(0, MOST);
  };
  const main = view.getUint32(tiff + 4, little);
  const exif = find(main, EXIF_IFD);
  const focal = exif && find(exif, FOCAL_35);
  // Of eight orientations the last four lie on their side. Browsers take no other numbers, and none of another type.
  const turned = entryOf(main, ORIENTATION);
  const isOne = turned > 0 && view.getUint16(turned + 2, little) === SHORT && view.getUint32(turned + 4, little) === 1;
  const orientation = isOne ? view.getUint16(turned + 8, little) : 1;
  if (size && orientation >= 5 && orientation <= 8) size.reverse();
  const credits = { artist: wordsOf(main, ARTIST), copyright: wordsOf(main, COPYRIGHT), description: wordsOf(main, DESCRIPTION) };
  return { kind, size, focal35: focal >= FOCALS[0] && focal <= FOCALS[1] ? focal : null, profile, credits, xmp };
}
