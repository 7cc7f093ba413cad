// Whether a photo's colours are those of Display P3, which phones take photos in. More than sRGB has of red and green would be
// clipped on a canvas for sRGB.

/** Its primaries as profiles have them: XYZ, under D50. @type {Record<string, number[]>} */
const PRIMARIES = { rXYZ: [0.5151, 0.2412, -0.0011], gXYZ: [0.292, 0.6922, 0.0419], bXYZ: [0.1571, 0.0666, 0.7841] };
/** Whose numbers are rounded otherwise are the same. */
const NEAR = 0.002;
/** Their number in ITU-T H.273, which PNG's cICP has. */
const P3 = 12;
/** Where an ICC profile has the number of its tags, and then each. */
const TAGS = 128;

/** @param {Uint8Array} icc a profile, or its beginning */
function hasPrimaries(icc) {
  const view = new DataView(icc.buffer, icc.byteOffset, icc.byteLength);
  if (view.byteLength < TAGS + 4) return false;
  let found = 0;
  for (let n = 0, at = TAGS + 4; n < view.getUint32(TAGS) && at + 12 <= view.byteLength; n += 1, at += 12) {
    const wanted = PRIMARIES[String.fromCharCode(...icc.subarray(at, at + 4))];
    const place = view.getUint32(at + 4);
    if (!wanted || place + 20 > view.byteLength) continue;
    if (wanted.every((value, i) => Math.abs(view.getInt32(place + 8 + 4 * i) / 65536 - value) < NEAR)) found += 1;
  }
  return found === 3;
}

/** What PNG packs. @param {Uint8Array<ArrayBuffer>} packed */
async function unpacked(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * @param {{ icc: Uint8Array<ArrayBuffer> | null, isPacked: boolean, primaries: number | null }} profile of `headerOf`
 * @returns {Promise<PredefinedColorSpace>} the canvas that takes its colours
 */
export async function spaceOf({ icc, isPacked, primaries }) {
  // As browsers do, the number counts before the profile.
  if (primaries !== null) return primaries === P3 ? 'display-p3' : 'srgb';
  try {
    return icc && hasPrimaries(isPacked ? await unpacked(icc) : icc) ? 'display-p3' : 'srgb';
  } catch {
    // A profile that is damaged is none.
    return 'srgb';
  }
}
