import { element } from '../frame/element.js';
import { among, shows } from '../head/expression.js';
import { batchOf } from './batch.js';
import { createRemembered } from './remembered.js';

/** The pictures' size, pixels; shown at half of it. */
const WIDTH = 144;
const HEIGHT = 176;
/** How many are remembered, of some 40 kB each: each face that was ever listed has one. */
const MOST = 200;
/** How long to wait for a graphics card that was lost, ms. */
const PATIENCE = 1000;

/**
 * Pictures of faces, taken when they are first wanted.
 * @param {import('phiz').FaceModel} model
 * @param {import('./display.js').Display} display
 */
export function createPortraits(model, display) {
  const sitter = model.face();
  const sheet = element('canvas', { width: WIDTH, height: HEIGHT });
  /** Picture by face. @type {ReturnType<typeof createRemembered<string>>} */
  const taken = createRemembered(MOST);
  /** @type {Map<string, HTMLImageElement[]>} */
  const waiting = new Map();
  let scheduled = false;

  function work() {
    scheduled = false;
    const sheets = batchOf(waiting.keys()).map(([code, { code: shape, expression = {}, colouring = {} }]) => ({
      code,
      into: /** @type {HTMLCanvasElement} */ (sheet.cloneNode()),
      pose() {
        sitter.code = shape;
        // Before the expressions are there it is at rest; when they come, it is taken again.
        sitter.expression = among(expression, model.expressions);
        return { face: sitter, colouring };
      },
    }));
    if (!display.portraits(sheets)) return void setTimeout(schedule, PATIENCE);
    for (const { code, into } of sheets) {
      const picture = into.toDataURL();
      taken.set(code, picture);
      for (const image of waiting.get(code) ?? []) image.src = picture;
      waiting.delete(code);
    }
    schedule();
  }
  function schedule() {
    if (scheduled || waiting.size === 0) return;
    scheduled = true;
    requestAnimationFrame(work);
  }

  return {
    /**
     * A picture of a face, which may come a moment later. It says nothing to a reader: what shows
     * it has the face's name.
     * @param {import('../keep/library.js').Likeness} face
     */
    of({ code: shape, expression, colouring }) {
      const code = JSON.stringify({ code: shape, ...(shows(expression) && { expression }), ...(shows(colouring) && { colouring }) });
      const image = element('img', { class: 'portrait', 'data-code': code, alt: '', width: WIDTH / 2, height: HEIGHT / 2, draggable: 'false' });
      const picture = taken.get(code);
      if (picture) image.src = picture;
      else {
        waiting.set(code, [...(waiting.get(code) ?? []), image]);
        schedule();
      }
      return image;
    },
    /** Takes those on the page again: the light has changed. */
    retake() {
      taken.clear();
      for (const image of document.querySelectorAll('img.portrait')) {
        if (!(image instanceof HTMLImageElement)) continue;
        const code = image.dataset.code ?? '';
        waiting.set(code, [...(waiting.get(code) ?? []).filter((other) => other !== image), image]);
      }
      schedule();
    },
  };
}

/** @typedef {ReturnType<typeof createPortraits>} Portraits */
