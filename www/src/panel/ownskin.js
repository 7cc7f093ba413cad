import { element } from '../frame/element.js';
import { Failure } from '../frame/failure.js';
import { icon } from '../frame/icons.js';
import { text } from '../text.js';

/** Texels a side of what is worn: more is not seen, and takes a graphics card's memory. */
const MOST = 2048;
/** Fewer are no skin. */
const LEAST = 64;
/** A side may be this much longer than the other: the layout is square. */
const SQUARE = 1.02;

/**
 * @param {File} file
 * @returns {Promise<{ size: number, rgba: Uint8ClampedArray }>}
 * @throws Failure with a sentence
 */
async function readSkin(file) {
  const bitmap = await createImageBitmap(file).catch(() => {
    throw new Failure(text.ownSkin.unreadable(file.name));
  });
  try {
    const { width, height } = bitmap;
    if (Math.max(width, height) > SQUARE * Math.min(width, height)) throw new Failure(text.ownSkin.oblong(file.name));
    const size = Math.min(MOST, Math.max(width, height));
    if (size < LEAST) throw new Failure(text.ownSkin.small(file.name, LEAST));
    const canvas = new OffscreenCanvas(size, size);
    const context = canvas.getContext('2d', { willReadFrequently: true });
    if (!context) throw new Failure(text.ownSkin.unreadable(file.name));
    context.imageSmoothingQuality = 'high';
    context.drawImage(bitmap, 0, 0, size, size);
    return { size, rgba: context.getImageData(0, 0, size, size).data };
  } finally {
    bitmap.close();
  }
}

/**
 * A picture of a skin in the head's layout of texture coordinates, as `phiz-fit register --texture` bakes a scan's and other programs
 * paint them: the head wears it until it is taken off, whoever is drawn.
 *
 * @param {{
 *   colouring: () => import('../head/colouring.js').Colouring,
 *   wear: (worn: import('../head/head.js').Worn | null) => void,
 *   say: (sentence: string) => void,
 * }} parts `colouring`: the looks in which it is shown as it is
 */
export function createOwnSkin({ colouring, wear, say }) {
  /** What was asked for last comes last, however long it takes to read. */
  let asked = 0;
  const picker = element('input', {
    type: 'file',
    accept: 'image/png, image/jpeg, image/webp',
    hidden: true,
    'aria-label': text.ownSkin.wear,
    onchange: async () => {
      const file = picker.files?.[0];
      picker.value = '';
      if (file) await put(file);
    },
  });
  const on = element('button', { type: 'button', class: 'button small', title: text.ownSkin.about, onclick: () => picker.click() }, icon('upload'), text.ownSkin.wear);
  const off = element('button', { type: 'button', class: 'button small', hidden: true, onclick: takeOff }, text.ownSkin.takeOff);

  /** @param {File} file */
  async function put(file) {
    const own = (asked += 1);
    try {
      const skin = await readSkin(file);
      if (own !== asked) return;
      wear({ ...skin, colouring: colouring() });
      off.hidden = false;
      say(text.ownSkin.worn(file.name));
    } catch (error) {
      if (own === asked) say(error instanceof Failure ? error.message : text.ownSkin.unreadable(file.name));
    }
  }
  function takeOff() {
    asked += 1;
    wear(null);
    // The focus would be nowhere.
    if (document.activeElement === off) on.focus();
    off.hidden = true;
  }

  return { root: element('div', { class: 'row' }, on, off, picker) };
}
