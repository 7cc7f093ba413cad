import { save } from '../keep/save.js';
import { text } from '../text.js';
import { decodeAgain } from './read.js';
import { withXmp, xmpPacket } from './xmp.js';

/** As cameras write it; below, skin shows blocks. */
const QUALITY = 0.95;

/**
 * The whole photo with what was changed over it, as a file that says that it was edited, and whose it is.
 * @param {import('./read.js').Photo} photo
 * @param {((context: OffscreenCanvasRenderingContext2D) => void) | null} change changes all its pixels on a canvas
 * @param {'image/png' | 'image/jpeg'} type
 */
export async function savePhoto(photo, change, type) {
  const { width, height, name, colorSpace, credits, edited } = photo;
  // In the processor's memory: on the card it would be there once more.
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext('2d', { alpha: type === 'image/png', willReadFrequently: true, colorSpace });
  if (!context) throw new Error(text.photo.noRoom);
  // JPEG has no transparency; paper is white.
  context.fillStyle = '#fff';
  context.fillRect(0, 0, width, height);
  // Where a canvas is too large for them some browsers give one that takes nothing.
  if (!context.getImageData(0, 0, 1, 1).data[0]) throw new Error(text.photo.noRoom);
  if (type === 'image/png') context.clearRect(0, 0, width, height);
  const whole = await decodeAgain(photo);
  context.drawImage(whole, 0, 0);
  // It takes as much as the canvas.
  whole.close();
  change?.(context);
  const plain = await canvas.convertToBlob({ type, quality: QUALITY });
  // Its memory goes now, not when somebody collects it.
  canvas.width = canvas.height = 1;
  const file = `${name.replace(/\.[^.]*$/, '') || 'photo'}-phiz.${type === 'image/png' ? 'png' : 'jpg'}`;
  // Whoever changes nothing more does not undo that.
  const note = change || edited ? text.photo.editedNote : '';
  const isSaid = note || Object.values(credits).some(Boolean);
  const blob = isSaid ? await withXmp(plain, xmpPacket(note, credits)) : plain;
  save(blob, file);
  return { file, bytes: blob.size };
}
