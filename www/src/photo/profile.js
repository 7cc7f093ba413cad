// Whether a photo's colours are more than sRGB has, as those of phones are, in Display P3, and of cameras in Adobe RGB: of red and
// green they would be clipped on a canvas for sRGB. One for Display P3, the other that there is, has room for them, or nearly.

/** Where the primaries of sRGB are: XYZ, under D50, as profiles have them. */
const SRGB = [[0.436, 0.2225, 0.0139], [0.3851, 0.7169, 0.0971], [0.1431, 0.0606, 0.7141]];
/** Of whom they span this much more, there are more colours: screens that are measured differ from sRGB by less. */
const WIDER = 1.15;
/** The numbers of such primaries in ITU-T H.273, which cICP has: of ITU-R BT.2020, DCI-P3 and Display P3. */
const WIDE = [9, 11, 12];
/** Where an ICC profile has the number of its tags, and then each. */
const TAGS = 128;

/** Twice the area between three colours, whatever their brightness. @param {readonly (readonly number[])[]} primaries XYZ */
function spanOf(primaries) {
  const [[ax, ay], [bx, by], [cx, cy]] = primaries.map(([x, y, z]) => [x / (x + y + z), y / (x + y + z)]);
  return Math.abs((bx - ax) * (cy - ay) - (cx - ax) * (by - ay));
}

/** @param {Uint8Array} icc a profile, or its beginning */
function isWide(icc) {
  const view = new DataView(icc.buffer, icc.byteOffset, icc.byteLength);
  if (view.byteLength < TAGS + 4) return false;
  /** @type {Map<string, number[]>} */
  const primaries = new Map();
  for (let n = 0, at = TAGS + 4; n < view.getUint32(TAGS) && at + 12 <= view.byteLength; n += 1, at += 12) {
    const name = String.fromCharCode(...icc.subarray(at, at + 4));
    const place = view.getUint32(at + 4);
    if (!/^[rgb]XYZ$/.test(name) || place + 20 > view.byteLength) continue;
    primaries.set(name, [0, 1, 2].map((i) => view.getInt32(place + 8 + 4 * i) / 65536));
  }
  return primaries.size === 3 && spanOf([...primaries.values()]) > WIDER * spanOf(SRGB);
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
  if (primaries !== null) return WIDE.includes(primaries) ? 'display-p3' : 'srgb';
  try {
    return icc && isWide(isPacked ? await unpacked(icc) : icc) ? 'display-p3' : 'srgb';
  } catch {
    // A profile that is damaged is none.
    return 'srgb';
  }
}
