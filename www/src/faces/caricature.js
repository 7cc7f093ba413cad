import { element } from '../frame/element.js';
import { sigmas } from '../panel/distribution.js';
import { createSlider } from '../panel/slider.js';
import { text } from '../text.js';

/** Per cent of what makes a face differ from the average. */
const ITSELF = 100;
const MOST = 200;

/**
 * A face so much like itself: 0 is the average, 1 the face, more its caricature, whose coefficients end where sliders
 * do. What is beyond already stays there.
 * @param {Float32Array} coefficients @param {number} share @param {number} end standard deviations
 */
export function exaggerated(coefficients, share, end) {
  return coefficients.map((own) => {
    const most = Math.max(end, Math.abs(own));
    return Math.min(most, Math.max(-most, share * own));
  });
}

/**
 * How much the face differs from the average: less is anybody, more is nobody else (Brennan 1985).
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {import('../panel/limits.js').Limits} limits
 */
export function createCaricature(editor, limits) {
  const drawn = editor.model.face();
  /** Where it counts from. @type {import('../editing/history.js').State | null} */
  let base = null;
  /** @type {Float32Array} */
  let coefficients = drawn.coefficients;
  let ownStep = false;

  const slider = createSlider({
    name: text.caricature,
    label: text.caricature,
    id: 'caricature',
    about: text.caricatureAbout,
    limits: [0, MOST],
    step: 1,
    key: 1,
    neutral: ITSELF,
    words: text.percent,
    typed: {
      label: text.caricatureTyped,
      unit: '%',
      min: 0,
      max: MOST,
      step: 1,
      show: (value) => Math.round(value),
      take: (percent) => {
        exaggerate(percent);
        finish();
      },
    },
    move: exaggerate,
    finish,
  });
  /** @param {number} percent */
  function exaggerate(percent) {
    if (!base) {
      base = editor.state;
      // With its way of blending.
      drawn.code = base.code;
      coefficients = drawn.coefficients;
    }
    if (percent === ITSELF) drawn.code = base.code;
    else drawn.coefficients = exaggerated(coefficients, percent / ITSELF, sigmas(limits.present[1]));
    editor.moveFrom(base, (present) => present.blend(drawn, 1));
    slider.show(percent);
  }
  function finish() {
    ownStep = true;
    editor.finish('caricature');
    ownStep = false;
  }
  editor.onStep(() => {
    if (ownStep) return;
    base = null;
    slider.show(ITSELF);
  });
  slider.show(ITSELF);

  return { root: element('section', { class: 'part', 'aria-label': text.caricature }, slider.root) };
}
