// The one thing that is wanted of a photo's EXIF: the focal length as if for film. A library for all of
// EXIF is many times this, and what it would read besides is of no use here.

/** IFD tags of EXIF 2.3. */
const EXIF_IFD = 0x8769;
const FOCAL_35 = 0xa405;

/** What cameras have; anything else is a mistake. */
const FOCALS = [8, 800];

/**
 * Where the TIFF of a file begins, or -1: in the APP1 of a JPEG, the eXIf of a PNG, the EXIF of a WebP.
 * @param {DataView} view
 */
function tiffOf(view) {
  const name = (/** @type {number} */ at, /** @type {number} */ length) =>
    at + length > view.byteLength ? '' : String.fromCharCode(...new Uint8Array(view.buffer, view.byteOffset + at, length));
  if (view.byteLength < 16) return -1;
  if (view.getUint16(0) === 0xffd8) {
    for (let at = 2; at + 10 < view.byteLength && view.getUint8(at) === 0xff; at += 2 + view.getUint16(at + 2)) {
      if (view.getUint8(at + 1) === 0xe1 && name(at + 4, 6) === 'Exif\0\0') return at + 10;
      // The picture itself begins.
      if (view.getUint8(at + 1) === 0xda) break;
    }
  } else if (name(1, 3) === 'PNG') {
    for (let at = 8; at + 12 <= view.byteLength; at += 12 + view.getUint32(at)) if (name(at + 4, 4) === 'eXIf') return at + 8;
  } else if (name(0, 4) === 'RIFF' && name(8, 4) === 'WEBP') {
    for (let at = 12; at + 8 <= view.byteLength; at += 8 + view.getUint32(at + 4, true) + (view.getUint32(at + 4, true) & 1)) {
      if (name(at, 4) === 'EXIF') return at + (name(at + 8, 6) === 'Exif\0\0' ? 14 : 8);
    }
  }
  return -1;
}

/**
 * The focal length, mm, as if the longer side of the sensor were 36 mm; null where the file does not say.
 * @param {ArrayBuffer} bytes the file, or its beginning
 */
export function focal35(bytes) {
  const view = new DataView(bytes);
  const tiff = tiffOf(view);
  if (tiff < 0 || tiff + 8 > view.byteLength) return null;
  const little = view.getUint16(tiff) === 0x4949;
  /** @param {number} ifd @param {number} wanted @returns {number | null} its value */
  const find = (ifd, wanted) => {
    const first = tiff + ifd;
    if (first + 2 > view.byteLength) return null;
    const count = view.getUint16(first, little);
    for (let entry = first + 2; entry < first + 2 + 12 * count && entry + 12 <= view.byteLength; entry += 12) {
      if (view.getUint16(entry, little) !== wanted) continue;
      return view.getUint16(entry + 2, little) === 3 ? view.getUint16(entry + 8, little) : view.getUint32(entry + 8, little);
    }
    return null;
  };
  const exif = find(view.getUint32(tiff + 4, little), EXIF_IFD);
  const focal = exif && find(exif, FOCAL_35);
  return focal && focal >= FOCALS[0] && focal <= FOCALS[1] ? focal : null;
}
