// What a GLB that left the page holds.

/** What was read, as a megabyte of it is asked for often. @type {WeakMap<Buffer, any>} */
const read = new WeakMap();

/** @param {Buffer} bytes */
export function glbJson(bytes) {
  const json = read.get(bytes) ?? JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
  read.set(bytes, json);
  return json;
}

/**
 * The vectors of an accessor, those of a sparse one as well.
 * @param {Buffer} bytes @param {number} index
 * @returns {Float32Array} three each
 */
export function readVectors(bytes, index) {
  const { accessors, bufferViews } = glbJson(bytes);
  const { bufferView, count, sparse } = accessors[index];
  const start = 28 + bytes.readUInt32LE(12);
  /** @param {number} view */
  const at = (view) => start + bufferViews[view].byteOffset;
  const out = new Float32Array(3 * count);
  if (bufferView !== undefined) for (let i = 0; i < out.length; i++) out[i] = bytes.readFloatLE(at(bufferView) + 4 * i);
  const wide = sparse?.indices.componentType === 5125;
  for (let i = 0; i < (sparse?.count ?? 0); i++) {
    const from = at(sparse.indices.bufferView) + (wide ? 4 : 2) * i;
    const vertex = wide ? bytes.readUInt32LE(from) : bytes.readUInt16LE(from);
    for (let k = 0; k < 3; k++) out[3 * vertex + k] = bytes.readFloatLE(at(sparse.values.bufferView) + 4 * (3 * i + k));
  }
  return out;
}

/**
 * The colours of a picture in it, as the browser shows it.
 * @param {import('playwright-core').Page} page with a face of the same model
 * @param {Buffer} bytes
 * @param {string} name the picture's
 * @param {(string | [number, number])[]} points landmarks, or between several of them, or parts of the picture's sides
 * @returns {Promise<[number, number, number][]>} sRGB, 0 to 255
 */
export function readPicture(page, bytes, name, points) {
  const { images, bufferViews } = glbJson(bytes);
  const { bufferView, mimeType } = images.find((one) => one.name === name);
  const { byteOffset, byteLength } = bufferViews[bufferView];
  const from = 28 + bytes.readUInt32LE(12) + byteOffset;
  const url = `data:${mimeType};base64,${bytes.subarray(from, from + byteLength).toString('base64')}`;
  return page.evaluate(
    async ([source, places]) => {
      const picture = new Image();
      picture.src = source;
      await picture.decode();
      const sheet = document.createElement('canvas');
      sheet.width = picture.naturalWidth;
      sheet.height = picture.naturalHeight;
      const draw = sheet.getContext('2d', { willReadFrequently: true });
      draw.drawImage(picture, 0, 0);
      const { model } = window.designer;
      return places.map((place) => {
        let [u, v] = Array.isArray(place) ? place : [0, 0];
        // No seams are where landmarks are: a vertex has one corner.
        const names = typeof place === 'string' ? place.split(' ') : [];
        for (const landmark of names) {
          const { stencil } = model.landmarks.find((one) => one.name === landmark);
          for (const [vertex, weight] of stencil) {
            u += (weight * model.uvs[2 * vertex]) / names.length;
            v += (weight * (1 - model.uvs[2 * vertex + 1])) / names.length;
          }
        }
        return [...draw.getImageData(u * sheet.width, v * sheet.height, 1, 1).data.slice(0, 3)];
      });
    },
    [url, points],
  );
}
