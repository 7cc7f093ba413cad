import { element } from './element.js';

/** The pictures' size, pixels; shown at half of it. */
const WIDTH = 144;
const HEIGHT = 176;
/** How many are taken at a time, between two frames. */
const BATCH = 3;

/**
 * Pictures of faces, taken when they are first wanted.
 * @param {import('phiz').FaceModel} model
 * @param {import('./display.js').Display} display
 */
export function createPortraits(model, display) {
  const sitter = model.face();
  /** @type {Map<string, HTMLCanvasElement>} */
  const taken = new Map();
  /** @type {Map<string, HTMLCanvasElement[]>} */
  const waiting = new Map();
  let scheduled = false;

  function work() {
    scheduled = false;
    const codes = [...waiting.keys()].slice(0, BATCH);
    // One face sits for all: it becomes the next one just before its picture.
    for (const code of codes) {
      const picture = element('canvas', { width: WIDTH, height: HEIGHT });
      sitter.code = code;
      if (!display.portraits([{ face: sitter, into: picture }])) return void setTimeout(schedule, 1000);
      taken.set(code, picture);
      for (const copy of waiting.get(code) ?? []) copy.getContext('2d')?.drawImage(picture, 0, 0);
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
     * A picture of a face, which may come a moment later.
     * @param {string} code
     */
    of(code) {
      const copy = element('canvas', { class: 'portrait', width: WIDTH, height: HEIGHT, 'aria-hidden': 'true' });
      const picture = taken.get(code);
      if (picture) copy.getContext('2d')?.drawImage(picture, 0, 0);
      else {
        waiting.set(code, [...(waiting.get(code) ?? []), copy]);
        schedule();
      }
      return copy;
    },
  };
}

/** @typedef {ReturnType<typeof createPortraits>} Portraits */
