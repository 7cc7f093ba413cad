import './colours.css';
import { BROW_FORM, carriedOf, GLASSES, REST, wearsGlasses, whole } from '../head/colouring.js';
import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { frameColour, lensColour } from '../glasses/tint.js';
import { createSlider } from './slider.js';
import { someone } from '../head/someone.js';
import { text } from '../text.js';

const GROUPS = /** @type {const} */ ([
  ['skin', ['skin', 'blood', 'lips', 'lines', 'freckles']],
  ['hair', ['hair', 'red', 'grey']],
  ['style', ['crop', 'hairline', 'length', 'comb', 'parting', 'curl']],
  ['beard', ['beard', 'beardLength', 'moustache', 'chinBeard', 'cheekBeard', 'beardShade', 'beardRed', 'beardGrey']],
  ['brows', ['brows', ...BROW_FORM, 'browShade', 'browGrey']],
  ['eyes', ['iris']],
  ['glasses', ['lensForm', 'lensSize', 'lensHeight', 'lensSweep', 'rim', 'halfRim', 'noseBar', 'frameColour', 'tint']],
]);

/** Where to begin from: what a group's sliders have then. @type {Partial<Record<string, Record<string, import('../head/colouring.js').Colouring>>>} */
const STARTS = {
  style: {
    bald: { crop: 0, length: 0 },
    cropped: { crop: 0.9, length: 0.05, curl: 0.3 },
    short: { crop: 0.9, length: 0.22, comb: 0.3, curl: 0.15 },
    back: { crop: 0.9, length: 0.36, comb: 0, curl: 0.05 },
    fringe: { crop: 0.9, length: 0.4, comb: 0.95, curl: 0.1 },
    bob: { crop: 0.9, length: 0.66, comb: 0.5, parting: 0.35, curl: 0.05 },
    long: { crop: 0.9, length: 0.95, comb: 0.45, parting: 0.5, curl: 0.1 },
    wavy: { crop: 0.9, length: 0.85, comb: 0.45, parting: 0.4, curl: 0.5 },
    coiled: { crop: 0.9, length: 0.45, comb: 0.4, curl: 1 },
  },
  beard: {
    shaved: { beard: 0, beardLength: 0 },
    stubble: { beard: 0.35, beardLength: 0 },
    trimmed: { beard: 0.7, beardLength: 0.15 },
    full: { beard: 0.8, beardLength: 0.4 },
    flowing: { beard: 0.8, beardLength: 0.8 },
    moustache: { beard: 0.8, beardLength: 0.18, chinBeard: 0, cheekBeard: 0 },
    goatee: { beard: 0.8, beardLength: 0.3, cheekBeard: 0 },
    chin: { beard: 0.8, beardLength: 0.35, moustache: 0, cheekBeard: 0 },
  },
  brows: {
    fine: { brows: 0.45, browBreadth: 0.2, browArch: 0.65 },
    bushy: { brows: 0.85, browBreadth: 0.75 },
    straight: { brows: 0.6, browArch: 0.1, browRaise: 0.4 },
    arched: { brows: 0.55, browBreadth: 0.4, browArch: 0.9, browRaise: 0.6 },
    rising: { brows: 0.6, browSlant: 0.85 },
    drooping: { brows: 0.55, browSlant: 0.15 },
    joined: { brows: 0.8, browBreadth: 0.65, browApart: 0 },
  },
  glasses: {
    none: {},
    round: { glasses: 1, lensForm: 0, lensSize: 0.25, lensHeight: 0.9, rim: 0.22, frameColour: 0.14 },
    oval: { glasses: 1, lensForm: 0.05, lensSize: 0.5, lensHeight: 0.42, rim: 0.2, frameColour: 0 },
    rectangular: { glasses: 1, lensForm: 0.7, lensSize: 0.6, lensHeight: 0.38, rim: 0.6 },
    pilot: { glasses: 1, lensForm: 0.3, lensSize: 0.85, lensHeight: 0.66, lensSweep: 0.05, rim: 0.2, noseBar: 0.6, frameColour: 0.14, tint: 0.35 },
    catEye: { glasses: 1, lensForm: 0.3, lensSize: 0.55, lensHeight: 0.45, lensSweep: 0.92, rim: 0.62, frameColour: 0.88 },
    browline: { glasses: 1, lensForm: 0.3, lensSize: 0.45, lensHeight: 0.55, lensSweep: 0.55, rim: 0.7, halfRim: 0.9 },
    halfRim: { glasses: 1, lensForm: 0.55, lensSize: 0.6, lensHeight: 0.3, rim: 0.24, halfRim: 1, frameColour: 0.66 },
    rimless: { glasses: 1, lensForm: 0.4, lensSize: 0.55, lensHeight: 0.36, rim: 0, frameColour: 0.14 },
    sunglasses: { glasses: 1, lensForm: 0.5, lensSize: 0.75, lensHeight: 0.58, lensSweep: 0.6, rim: 0.68, tint: 0.85 },
  },
};

/** @param {readonly string[]} names */
const restOf = (names) => Object.fromEntries(names.map((name) => [name, REST[name]]));
/** What else a group's beginnings have. @type {Partial<Record<string, import('../head/colouring.js').Colouring>>} */
const BEGUN = { style: { thin: 0 }, beard: { beardThin: 0, moustache: 1, chinBeard: 1, cheekBeard: 1 }, brows: restOf(BROW_FORM), glasses: restOf(GLASSES) };

/** A group whose sliders are there only while they show something. @type {Partial<Record<string, (colouring: import('../head/colouring.js').Colouring) => boolean>>} */
const SHOWS = { glasses: wearsGlasses };

/** How dense hair is goes for what is cropped and for what has a length. @type {Record<string, { thin: string, long: string, at: 0 | 1 }>} */
const DENSE = { crop: { thin: 'thin', long: 'length', at: 0 }, beard: { thin: 'beardThin', long: 'beardLength', at: 1 } };

/** How many colours are shown along a track. */
const STOPS = 11;

/** @typedef {ReturnType<typeof import('../head/pigments.js').pigments>} Pigments */

/** What each slider paints, but for those that only lay hair otherwise. @type {Record<string, (paints: Pigments) => import('three').Color>} */
const PAINTED = {
  skin: ({ skin }) => skin,
  blood: ({ skin }) => skin,
  lips: ({ lips }) => lips,
  // Between hairs there is skin.
  brows: ({ skin, grown, bushy }) => skin.clone().lerp(grown.brows.young, 0.35 * bushy),
  hair: ({ grown }) => grown.hair.all,
  red: ({ grown }) => grown.hair.all,
  grey: ({ grown }) => grown.hair.all,
  crop: ({ skin, grown, dense }) => skin.clone().lerp(grown.hair.all, 0.9 * dense[0]),
  beard: ({ skin, grown, dense }) => skin.clone().lerp(grown.beard.all, 0.7 * dense[1]),
  beardShade: ({ grown }) => grown.beard.all,
  beardRed: ({ grown }) => grown.beard.all,
  beardGrey: ({ grown }) => grown.beard.all,
  browShade: ({ grown }) => grown.brows.all,
  browGrey: ({ grown }) => grown.brows.all,
  iris: ({ iris }) => iris.outer.clone().lerp(iris.inner, 0.3),
};
/** What a slider paints that is no pigment, by where it is. @type {Record<string, (at: number, paints: Pigments) => import('three').Color>} */
const MADE = {
  frameColour: (at) => frameColour(at).colour,
  tint: (at, { skin }) => skin.clone().lerp(lensColour(at).colour, lensColour(at).taken),
};

/**
 * The colours of skin, lips, brows and eyes, each a slider over what it gives.
 * @param {import('../editing/editor.js').Editor} editor
 * @param {(colouring: import('../head/colouring.js').Colouring) => Pigments} paints
 * @param {HTMLElement} ownSkin stands among what is of the skin
 * @param {{ root: HTMLElement, shown: (now: boolean) => void }} marks stand after that
 */
export function createColours(editor, paints, ownSkin, marks) {
  let visible = false;
  /** What changes with a slider. @param {string} name @param {number} value */
  function moved(name, value) {
    const dense = DENSE[name];
    if (!dense) return { [name]: value };
    // Where there is none at all, what grows next is whole.
    const none = value === 0 && whole(editor.colouring)[dense.long] === 0;
    return { [name]: value, [dense.thin]: none ? 0 : 1 - value };
  }
  const sliders = new Map(
    GROUPS.flatMap(([, names]) => [...names]).map((/** @type {string} */ name) => {
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
          take: (percent) => editor.paint({ ...editor.colouring, ...moved(name, percent / 100) }),
        },
        move: (value) => editor.moveColours(moved(name, value)),
        cancel: editor.cancel,
        finish: () => editor.finish(`paint ${name}`),
      });
      return [name, slider];
    }),
  );
  const own = element('button', { type: 'button', class: 'button', onclick: () => editor.paint({}) }, icon('reset'), text.ownColours);
  function paintSome() {
    // Marks were put on this face, and glasses, and it is still the same one.
    editor.paint({ ...someone(editor.face, Math.floor(2 ** 32 * Math.random())), ...carriedOf(editor.colouring) });
  }
  const some = element('button', { type: 'button', class: 'button', onclick: paintSome }, icon('dice'), text.someColours);

  /** @type {{ button: HTMLElement, values: import('../head/colouring.js').Colouring }[]} */
  const starts = [];
  /** @param {keyof typeof text.colourGroups} group */
  function startsOf(group) {
    const buttons = Object.entries(STARTS[group] ?? {}).map(([name, start]) => {
      const values = { ...BEGUN[group], ...start };
      const button = element('button', { type: 'button', class: 'button small', 'aria-pressed': 'false', onclick: () => editor.paint({ ...editor.colouring, ...values }) }, text.starts[group][name]);
      starts.push({ button, values });
      return button;
    });
    if (buttons.length === 0) return [];
    return [element('div', { class: 'row', role: 'group', 'aria-label': text.startFrom(text.colourGroups[group]) }, ...buttons)];
  }

  function refresh() {
    if (!visible) return;
    const { colouring } = editor;
    const values = whole(colouring);
    for (const start of starts) {
      start.button.setAttribute('aria-pressed', String(Object.entries(start.values).every(([name, value]) => values[name] === value)));
    }
    own.disabled = Object.keys(colouring).length === 0;
    for (const [group, names] of GROUPS) {
      for (const name of names) sliders.get(name)?.root.toggleAttribute('hidden', SHOWS[group]?.(colouring) === false);
    }
    for (const [name, slider] of sliders) {
      slider.show(DENSE[name] ? paints(colouring).dense[DENSE[name].at] : values[name]);
      if (!PAINTED[name] && !MADE[name]) continue;
      const ramp = Array.from({ length: STOPS }, (_, i) => {
        const at = i / (STOPS - 1);
        const pigments = paints({ ...colouring, ...moved(name, at) });
        const colour = MADE[name]?.(at, pigments) ?? PAINTED[name](pigments);
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
        ...GROUPS.flatMap(([group, names]) => [
          element(
            'section',
            { class: 'part', 'aria-label': text.colourGroups[group] },
            element('h3', {}, text.colourGroups[group]),
            ...startsOf(group),
            ...(group === 'skin' ? [ownSkin] : []),
            ...names.flatMap((name) => sliders.get(name)?.root ?? []),
          ),
          ...(group === 'skin' ? [marks.root] : []),
        ]),
      ),
    ),
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      marks.shown(now);
      refresh();
    },
  };
}
