import { element } from '../frame/element.js';
import { FEELINGS, VISEMES } from './feelings.js';
import { createSlider } from './slider.js';
import { text } from '../text.js';

/** The least strength: with less, a light part of a preset would be none, and nobody could tell which it is. */
const LEAST = 0.1;

/** Where the eyes look is a choice of its own, which presets leave. @param {string} name */
const isGaze = (name) => name.startsWith('eyeLook');

/**
 * A preset so strong, as an editor keeps it: in whole per cents.
 * @param {import('./feelings.js').Weights} weights @param {number} strength
 */
const percentsOf = (weights, strength) => Object.entries(weights).map(([name, weight]) => /** @type {const} */ ([name, Math.round(100 * weight * strength)]));

/**
 * How strong a preset is, if the expression is that and nothing else.
 * @param {import('./feelings.js').Weights} weights
 * @param {Record<string, number>} expression
 * @param {number} likely this, if it may be several: they are rounded
 */
function strengthIn(weights, expression, likely) {
  const moved = Object.keys(expression).filter((name) => !isGaze(name) && expression[name] >= 0.005);
  if (moved.length !== Object.keys(weights).length || !moved.every((name) => name in weights)) return null;
  const strengths = [likely, ...Array.from({ length: 101 - 100 * LEAST }, (_, i) => 1 - i / 100)];
  return strengths.find((strength) => percentsOf(weights, strength).every(([name, percent]) => Math.round(100 * expression[name]) === percent)) ?? null;
}

/**
 * Expressions by their names, each a button, and how strong they are. One replaces the expression that is there,
 * but not where the eyes look; pressed again, it goes.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {(weights: Record<string, number>) => void} express one step: these weights and no others
 */
export function createExpressionPresets(editor, express) {
  const { face } = editor;
  let strength = 1;
  /** The one that the face wears. @type {string | null} */
  let worn = null;

  const gaze = () => Object.fromEntries(Object.entries(face.expression).filter(([name]) => isGaze(name)));
  /** @param {string} name */
  const weightsOf = (name) => Object.fromEntries(percentsOf(FEELINGS[name] ?? VISEMES[name], strength).map(([part, percent]) => [part, percent / 100]));

  const buttons = [...Object.entries(FEELINGS), ...Object.entries(VISEMES)].map(([name, weights]) => {
    const press = () => express({ ...gaze(), ...(worn === name ? {} : weightsOf(name)) });
    const button = element('button', { type: 'button', class: 'button small', 'aria-pressed': 'false', disabled: true, onclick: press }, text.presets.names[name]);
    return { name, weights, button };
  });
  /** @param {object} names @param {string} label */
  const row = (names, label) =>
    element('div', { class: 'row', role: 'group', 'aria-label': label }, ...buttons.filter(({ name }) => name in names).map(({ button }) => button));

  const slider = createSlider({
    name: text.presets.strength,
    label: text.presets.strength,
    id: 'expressions-strength',
    about: '',
    title: text.presets.strengthAbout,
    limits: [LEAST, 1],
    step: 0.01,
    key: 0.01,
    neutral: 1,
    words: (value) => text.percent(100 * value),
    typed: {
      label: text.presets.strengthTyped,
      unit: '%',
      min: 100 * LEAST,
      max: 100,
      step: 1,
      show: (value) => Math.round(100 * value),
      take: (percent) => {
        strengthen(percent / 100);
        finish();
      },
    },
    move: strengthen,
    finish,
  });
  /** @param {number} now */
  function strengthen(now) {
    strength = now;
    if (worn === null) slider.show(strength);
    else editor.moveExpression(weightsOf(worn));
  }
  function finish() {
    editor.finish('strength of the expression');
  }
  slider.show(strength);

  return {
    root: element(
      'div',
      { class: 'presets' },
      row(FEELINGS, text.presets.label),
      element('details', {}, element('summary', {}, text.presets.visemes), row(VISEMES, text.presets.visemes)),
      slider.root,
    ),
    /** The model has expressions now. */
    enable() {
      for (const { button } of buttons) button.disabled = false;
    },
    /** @param {Record<string, number>} expression */
    show(expression) {
      worn = null;
      for (const { name, weights, button } of buttons) {
        const found = strengthIn(weights, expression, strength);
        if (found !== null) [worn, strength] = [name, found];
        button.setAttribute('aria-pressed', String(found !== null));
      }
      slider.show(strength);
    },
  };
}
