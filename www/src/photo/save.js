import { save } from '../save.js';
import { text } from '../text.js';
import { withXmp, xmpPacket } from './xmp.js';

/** As cameras write it; below, skin shows blocks. */
const QUALITY = 0.95;

/** @typedef {(pixels: ImageData, x: number, y: number) => void} Take */

/**
 * The whole photo with what was changed over it, as a file that says that it was edited.
 * @param {{ bitmap: ImageBitmap, width: number, height: number, name: string }} photo
 * @param {((take: Take) => Promise<void>) | null} change draws what is changed, part by part
 * @param {'image/png' | 'image/jpeg'} type
 */
export async function savePhoto({ bitmap, width, height, name }, change, type) {
  // In the processor's memory: on the card it would be there once more.
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext('2d', { alpha: type === 'image/png', willReadFrequently: true });
  if (!context) throw new Error(text.photo.noRoom);
  if (type === 'image/jpeg') {
    // JPEG has no transparency; paper is white.
    context.fillStyle = '#fff';
    context.fillRect(0, 0, width, height);
  }
  context.drawImage(bitmap, 0, 0);
  await change?.((pixels, x, y) => context.putImageData(pixels, x, y));
  const plain = await canvas.convertToBlob({ type, quality: QUALITY });
  const file = `${name.replace(/\.[^.]*$/, '') || 'photo'}-phiz.${type === 'image/png' ? 'png' : 'jpg'}`;
  const blob = change ? await withXmp(plain, xmpPacket(text.photo.editedNote)) : plain;
  save(blob, file);
  return { file, bytes: blob.size };
}
