// What a saved photo says of itself: that it was edited, in the words of the IPTC, and what the photo said of
// who made it, as XMP. And what a photo says so.

/** https://cv.iptc.org/newscodes/digitalsourcetype: "edited by a human, with non-generative tools". */
const SOURCE_TYPE = 'http://cv.iptc.org/newscodes/digitalsourcetype/humanEdits';
/** What a model made, or helped to make, stays that whoever edits it. */
const BY_A_MODEL = /algorithmicMedia$/i;
/** Letters of each that are read: those of EXIF, and what was written under them here. */
const MOST = 1100;

const RDF = 'http://www.w3.org/1999/02/22-rdf-syntax-ns#';
const DC = 'http://purl.org/dc/elements/1.1/';
const IPTC = 'http://iptc.org/std/Iptc4xmpExt/2008-02-29/';

/**
 * What a packet says of a photo; what is damaged says nothing.
 * @param {string} packet
 * @returns {import('./exif.js').Credits & { source: string }} `source`: its IPTC digital source type
 */
export function saidIn(packet) {
  const xml = new DOMParser().parseFromString(packet.replaceAll('\0', '') || '<nothing/>', 'application/xml');
  const clean = (/** @type {string | null | undefined} */ words) => (words ?? '').trim().slice(0, MOST);
  const items = (/** @type {string} */ name) => {
    const all = xml.getElementsByTagNameNS(DC, name)[0]?.getElementsByTagNameNS(RDF, 'li') ?? [];
    return Array.from(all, ({ textContent }) => clean(textContent)).filter(Boolean);
  };
  // A property is an attribute, or an element, which may have its value as an attribute.
  const parts = [...xml.getElementsByTagNameNS(RDF, 'Description')].map((part) => part.getAttributeNS(IPTC, 'DigitalSourceType'));
  const own = xml.getElementsByTagNameNS(IPTC, 'DigitalSourceType')[0];
  return {
    artist: clean(items('creator').join('; ')),
    // The first is that of no language.
    copyright: items('rights')[0] ?? '',
    description: items('description')[0] ?? '',
    source: clean(parts.find(Boolean) ?? (own?.getAttributeNS(RDF, 'resource') || own?.textContent)),
  };
}

/** @param {string} words */
const escaped = (words) =>
  words
    // These are not in XML at all.
    .replace(/[\0-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]/g, '')
    .replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);

/**
 * @param {string} note what was done, a sentence; empty: nothing
 * @param {import('./exif.js').Credits & { source?: string }} credits `source`: the digital source type that the photo had
 */
export function xmpPacket(note, { artist, copyright, description, source = '' }) {
  const language = (/** @type {string} */ words) => `<rdf:Alt><rdf:li xml:lang="x-default">${escaped(words)}</rdf:li></rdf:Alt>`;
  const names = artist.split(';').map((name) => name.trim()).filter(Boolean);
  // What was done stands under what is seen.
  const seen = [description, note].filter(Boolean).join('\n');
  const parts = [
    names.length && `<dc:creator><rdf:Seq>${names.map((name) => `<rdf:li>${escaped(name)}</rdf:li>`).join('')}</rdf:Seq></dc:creator>`,
    copyright && `<dc:rights>${language(copyright)}</dc:rights>`,
    seen && `<dc:description>${language(seen)}</dc:description>`,
  ];
  const type = note && !BY_A_MODEL.test(source) ? SOURCE_TYPE : source;
  const said = [note && `photoshop:Instructions="${escaped(note)}"`, type && `Iptc4xmpExt:DigitalSourceType="${escaped(type)}"`];
  return `<?xpacket begin="\uFEFF" id="W5M0MpCehiHzreSzNTczkc9d"?>
<x:xmpmeta xmlns:x="adobe:ns:meta/">
 <rdf:RDF xmlns:rdf="${RDF}">
  <rdf:Description rdf:about=""
    xmlns:dc="${DC}"
    xmlns:photoshop="http://ns.adobe.com/photoshop/1.0/"
    xmlns:Iptc4xmpExt="${IPTC}"
    xmlns:xmp="http://ns.adobe.com/xap/1.0/"
    ${['xmp:CreatorTool="phiz"', ...said].filter(Boolean).join('\n    ')}>
   ${parts.filter(Boolean).join('\n   ')}
  </rdf:Description>
 </rdf:RDF>
</x:xmpmeta>
<?xpacket end="r"?>`;
}

const CRC = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; k++) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c;
});

/** @param {Uint8Array} bytes */
function crc32(bytes) {
  let c = 0xffffffff;
  for (const byte of bytes) c = CRC[(c ^ byte) & 0xff] ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

/** The signature of a PNG and its IHDR. */
const PNG_HEAD = 8 + 25;

/**
 * @param {string} keyword @param {string} words
 * @returns {Uint8Array<ArrayBuffer>} an iTXt chunk, not packed
 */
function iTXt(keyword, words) {
  // The keyword, its end; not packed (two bytes); no language; no translated keyword.
  const data = new TextEncoder().encode(`${keyword}\0\0\0\0\0${words}`);
  const chunk = new Uint8Array(12 + data.length);
  const view = new DataView(chunk.buffer);
  view.setUint32(0, data.length);
  chunk.set(new TextEncoder().encode('iTXt'), 4);
  chunk.set(data, 8);
  view.setUint32(8 + data.length, crc32(chunk.subarray(4, 8 + data.length)));
  return chunk;
}

/**
 * An APP1 segment of a JPEG.
 * @param {string} packet
 */
function app1(packet) {
  const data = new TextEncoder().encode(`http://ns.adobe.com/xap/1.0/\0${packet}`);
  const segment = new Uint8Array(4 + data.length);
  segment.set([0xff, 0xe1, (data.length + 2) >> 8, (data.length + 2) & 0xff]);
  segment.set(data, 4);
  return segment;
}

/**
 * The same picture with an XMP packet in it. The canvas that wrote it put no other metadata there, so
 * nothing of the photo's own, such as the place, goes along.
 * @param {Blob} picture a PNG or a JPEG
 * @param {string} packet
 */
export async function withXmp(picture, packet) {
  if (picture.type === 'image/png') {
    return new Blob([picture.slice(0, PNG_HEAD), iTXt('XML:com.adobe.xmp', packet), picture.slice(PNG_HEAD)], { type: picture.type });
  }
  if (picture.type !== 'image/jpeg') throw new Error(`a picture of type ${picture.type} takes no XMP here`);
  // After the start marker and JFIF's APP0, which wants to be the first.
  const start = new DataView(await picture.slice(0, 6).arrayBuffer());
  const at = start.getUint16(2) === 0xffe0 ? 4 + start.getUint16(4) : 2;
  return new Blob([picture.slice(0, at), app1(packet), picture.slice(at)], { type: picture.type });
}
