import { mirroredColouring, mirroredExpression, mirrorOf } from '../editing/mirror.js';
import { element } from '../frame/element.js';
import { text } from '../text.js';
import { sigmas } from './distribution.js';
import { createSlider } from './slider.js';
import { createTimeslices } from './timeslice.js';

// How unlike each other the two sides of the face are: from a mask to more than anybody's.

/** So many random faces tell a percentile to 2.5; what the last of them has is the most that anybody has. */
const PEOPLE = 400;
const BARS = 61;
/** The width of the density's smoothing, of the track. */
const BANDWIDTH = 0.04;
/** How far the track goes beyond people, of what anybody has. */
const BEYOND = 2;
/** Sides that differ by less are alike, mm: to differ more they get somebody else's difference. */
const ALIKE = 0.02;

/**
 * @param {import('../editing/editor.js').Editor} editor
 * @param {import('./limits.js').Limits} limits
 */
export function createSymmetry(editor, limits) {
  const { model, face } = editor;
  const root = element('section', { class: 'part', 'aria-label': text.symmetry.title, hidden: true });
  /** @type {ReturnType<typeof withMirror> | null} */
  let part = null;
  let asked = false;
  let visible = false;

  async function prepare() {
    const pause = createTimeslices();
    const mirror = await mirrorOf(model, pause);
    if (!mirror) return; // one that knows sides apart was learned from people of one side
    const somebody = model.face();
    /** @type {number[]} */
    const amounts = [];
    for (let seed = 1; seed <= PEOPLE; seed++) {
      await pause();
      somebody.randomize({ seed });
      amounts.push(mirror.differ(somebody.coefficients));
    }
    amounts.sort((a, b) => a - b);
    const build = () => {
      part = withMirror(mirror, somebody, amounts);
      root.replaceChildren(...part.rows);
      part.refresh();
    };
    build();
    limits.onChange(build);
    root.hidden = false;
  }

  /**
   * @param {import('../editing/mirror.js').Mirror} mirror
   * @param {import('phiz').Face} drawn a face to draw on
   * @param {readonly number[]} amounts of people, increasing
   */
  function withMirror(mirror, drawn, amounts) {
    // A slider's value is a part of what anybody has, which is 1.
    const most = amounts[amounts.length - 1];
    const end = limits.beyond ? BEYOND : 1;
    const rank = (/** @type {number} */ at) => amounts.filter((one) => one < at * most).length / amounts.length;
    const bars = Array.from({ length: BARS }, (_, i) =>
      amounts.reduce((sum, one) => sum + Math.exp(-0.5 * ((one / most - (end * i) / (BARS - 1)) / BANDWIDTH) ** 2), 0),
    );
    const highest = Math.max(...bars);

    /** What is drawn next is of a state, with its way of blending. @param {import('../editing/history.js').State} state @returns {Float32Array} its coefficients */
    function drawFrom({ code }) {
      drawn.code = code;
      const { coefficients, alpha } = drawn;
      // What earlier locks took back is not in them, and may be of one side alone: it goes.
      drawn.reset();
      drawn.alpha = alpha;
      return coefficients;
    }
    /** What the gesture counts from. @type {{ state: import('../editing/history.js').State, coefficients: Float32Array, differ: number } | null} */
    let start = null;
    function hold() {
      if (start) return;
      const { state } = editor;
      let coefficients = drawFrom(state);
      if (mirror.differ(coefficients) < ALIKE) coefficients = withSidesOf(coefficients);
      start = { state, coefficients, differ: mirror.differ(coefficients) };
    }
    /** Whose sides are alike gets those of somebody, always the same. @param {Float32Array} coefficients */
    function withSidesOf(coefficients) {
      const somebody = model.face();
      somebody.randomize({ seed: 1 });
      const theirs = somebody.coefficients;
      somebody.free();
      const alike = mirror.withSides(theirs, 0);
      return coefficients.map((own, k) => own + theirs[k] - alike[k]);
    }
    /** @param {number} at */
    function move(at) {
      hold();
      if (!start) return;
      const { state, coefficients, differ } = start;
      const far = sigmas(limits.present[1]);
      const moved = mirror.withSides(coefficients, (at * most) / differ);
      drawn.coefficients = moved.map((to, k) => {
        const farthest = Math.max(far, Math.abs(coefficients[k]));
        return Math.min(farthest, Math.max(-farthest, to));
      });
      editor.moveFrom(state, (present) => present.blend(drawn, 1), editor.colouring);
    }
    function finish() {
      start = null;
      editor.finish('asymmetry');
    }
    const slider = createSlider({
      name: text.symmetry.slider,
      label: text.symmetry.slider,
      id: 'asymmetry',
      about: text.symmetry.about,
      title: text.symmetry.reset,
      limits: [0, end],
      step: 0.001,
      key: 0.02,
      neutral: 0,
      distribution: { place: (value) => value, value: (at) => at, density: bars.map((bar) => bar / highest) },
      words: (at) => text.lengthAndRank(at * most, text.symmetry.rank(rank(at))),
      typed: {
        label: text.symmetry.typed,
        unit: 'mm',
        min: 0,
        max: Math.floor(10 * end * most) / 10,
        step: 0.1,
        show: (at) => Math.round(100 * at * most) / 100,
        take: (mm) => {
          move(mm / most);
          finish();
        },
        atRank: (percent) => amounts[Math.min(amounts.length - 1, Math.floor((percent / 100) * amounts.length))],
        ended: (mm) => limits.ended(text.millimetres(mm), 'asymmetry'),
      },
      move,
      hold,
      cancel: editor.cancel,
      finish,
    });
    function flip() {
      const { state } = editor;
      drawn.coefficients = mirror.image(drawFrom(state));
      editor.part();
      editor.moveFrom(
        state,
        (present) => {
          present.blend(drawn, 1);
          if (present.locked.length === 0) present.expression = mirroredExpression(present.expression);
        },
        mirroredColouring(editor.colouring, model),
      );
      editor.finish('mirror');
    }
    return {
      rows: [
        slider.root,
        element('div', { class: 'row' }, element('button', { type: 'button', class: 'button', title: text.symmetry.flipAbout, onclick: flip }, text.symmetry.flip)),
      ],
      // What another slider moves of it by what nobody sees is not shown anew.
      refresh: () => slider.show(Math.round((1000 * mirror.differ(face.coefficients)) / most) / 1000),
    };
  }

  function refresh() {
    if (visible) part?.refresh();
  }
  editor.onShape(refresh);
  editor.onStep(refresh);

  return {
    root,
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      refresh();
      if (!now || asked) return;
      asked = true;
      void prepare();
    },
  };
}
