// What a GLB that left the page holds.

/** @param {Buffer} bytes */
export const glbJson = (bytes) => JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));

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
