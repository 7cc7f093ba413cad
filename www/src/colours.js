import './colours.css';
import { COLOURS, REST, whole } from './colouring.js';
import { element } from './element.js';
import { icon } from './icons.js';
import { createSlider } from './slider.js';
import { someone } from './someone.js';
import { text } from './text.js';

const GROUPS = /** @type {const} */ ([
  ['skin', ['skin', 'blood', 'lips', 'lines', 'freckles']],
  ['hair', ['hair', 'red', 'grey', 'brows', 'beard', 'beardLength']],
  ['style', ['crop', 'length', 'comb', 'parting', 'curl']],
  ['eyes', ['iris']],
]);

/** How many colours are shown along a track. */
const STOPS = 11;

/** @typedef {ReturnType<typeof import('./pigments.js').pigments>} Pigments */

/** What each slider paints, but for those that only lay hair otherwise. @type {Record<string, (paints: Pigments) => import('three').Color>} */
const PAINTED = {
  skin: ({ skin }) => skin,
  blood: ({ skin }) => skin,
  lips: ({ lips }) => lips,
  // Between hairs there is skin.
  brows: ({ skin, brows, bushy }) => skin.clone().lerp(brows, 0.35 * bushy),
  hair: ({ brows }) => brows,
  red: ({ brows }) => brows,
  grey: ({ brows }) => brows,
  crop: ({ skin, brows, dense }) => skin.clone().lerp(brows, 0.9 * dense[0]),
  beard: ({ skin, brows, dense }) => skin.clone().lerp(brows, 0.7 * dense[1]),
  iris: ({ iris }) => iris.outer.clone().lerp(iris.inner, 0.3),
};

/**
 * The colours of skin, lips, brows and eyes, each a slider over what it gives.
 * @param {import('./editor.js').Editor} editor
 * @param {(colouring: import('./colouring.js').Colouring) => Pigments} paints
 */
export function createColours(editor, paints) {
  let visible = false;
  const sliders = new Map(
    COLOURS.map((name) => {
      const label = text.colours[name];
      const slider = createSlider({
        name: label,
        label,
        id: `colour-${name}`,
        about: '',
        title: text.resetColour,
        limits: [0, 1],
        step: 0.01,
        key: 0.01,
        neutral: REST[name],
        words: (value) => text.percent(100 * value),
        typed: {
          label: text.typedColour(label),
          unit: '%',
          min: 0,
          max: 100,
          step: 1,
          show: (value) => Math.round(100 * value),
          take: (percent) => editor.paint({ ...editor.colouring, [name]: percent / 100 }),
        },
        move: (value) => editor.moveColours({ [name]: value }),
        finish: () => editor.finish(`paint ${name}`),
      });
      return [name, slider];
    }),
  );
  const own = element('button', { type: 'button', class: 'button', onclick: () => editor.paint({}) }, icon('reset'), text.ownColours);
  const some = element('button', { type: 'button', class: 'button', onclick: () => editor.paint(someone(editor.face, Math.floor(2 ** 32 * Math.random()))) }, icon('dice'), text.someColours);

  function refresh() {
    if (!visible) return;
    const { colouring } = editor;
    const values = whole(colouring);
    own.disabled = Object.keys(colouring).length === 0;
    for (const [name, slider] of sliders) {
      slider.show(values[name]);
      if (!PAINTED[name]) continue;
      const ramp = Array.from({ length: STOPS }, (_, i) => {
        const colour = PAINTED[name](paints({ ...colouring, [name]: i / (STOPS - 1) }));
        return `#${colour.getHexString()}`;
      });
      slider.root.style.setProperty('--ramp', `linear-gradient(90deg, ${ramp.join(', ')})`);
    }
  }
  editor.onColours(refresh);

  return {
    root: element(
      'div',
      { class: 'colours' },
      element(
        'div',
        { class: 'scroll' },
        element('div', { class: 'row' }, own, some),
        ...GROUPS.map(([group, names]) =>
          element(
            'section',
            { class: 'part', 'aria-label': text.colourGroups[group] },
            element('h3', {}, text.colourGroups[group]),
            ...names.flatMap((name) => sliders.get(name)?.root ?? []),
          ),
        ),
      ),
    ),
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      refresh();
    },
  };
}
