import { drawnByProcessor } from '../rendering/graphics.js';

/** The stage's picture has at most so many pixels a side; the file has all. A processor draws fewer. */
const LONGEST_SHOWN = drawnByProcessor() ? 2048 : 4096;

/** px of the stage's picture for one of a photo. @param {{ width: number, height: number }} of */
export const shownOf = ({ width, height }) => Math.min(1, LONGEST_SHOWN / Math.max(width, height));

/** The stage has a copy, which it may need again. @param {import('./read.js').Photo} of */
export async function pictureOf(of) {
  const scale = shownOf(of);
  const scaled = await createImageBitmap(of.bitmap, {
    resizeWidth: Math.max(1, Math.round(scale * of.width)),
    resizeHeight: Math.max(1, Math.round(scale * of.height)),
    resizeQuality: 'high',
  });
  // Only then: what is half seen would be scaled with the colour of what is not seen.
  return createImageBitmap(scaled, { premultiplyAlpha: 'none' }).finally(() => scaled.close());
}
