import { isBeyond } from './distribution.js';
import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { groupOfMeasure } from './measures.js';
import { createSlider } from './slider.js';
import { spoken, standing, text, titleOf } from '../text.js';

/** Lengths that a face may be asked for, mm; whether it can have them is the model's to say. */
const LENGTHS = /** @type {const} */ ([0.1, 400]);

/**
 * The controls that mean a length: its slider, its number, its lock.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   distributions: ReturnType<typeof import('./distribution.js').createDistributions>,
 *   limits: import('./limits.js').Limits,
 * }} parts
 */
export function createMeanings(editor, { distributions, limits }) {
  const { model, face } = editor;
  let visible = false;
  /** Where the sliders stood when one of them was taken up. @type {number[] | null} */
  let before = null;

  /** @type {{ measure: string, distribution: import('./distribution.js').Distribution, slider: import('./slider.js').Slider, lock: HTMLButtonElement }[]} */
  let rows = [];
  /** @param {import('phiz').Control} control @param {string} measure */
  function row(control, measure) {
    const { name, description } = control;
    const words = spoken(name);
    const distribution = distributions(control);
    /** @param {Parameters<typeof icon>[0]} sign @param {string} said @param {() => void} onclick */
    const tool = (sign, said, onclick) =>
      element('button', { type: 'button', class: 'tool small', 'aria-label': said, title: said, onclick }, icon(sign));
    const lock = tool('unlock', text.lockMeasure(spoken(measure)), () => editor.toggleMeasureLock(measure));
    const clear = tool('reset', text.clearMeasure(words), () => editor.clear(name));
    const slider = createSlider({
      name: words,
      label: words,
      id: `meaning-${name.replaceAll(/\W+/g, '-')}`,
      about: description,
      title: text.resetLength,
      limits: limits.present,
      // Where the part has no room to go on, and would crumple, unless people ask for more.
      ends: limits.beyond ? undefined : control.limits,
      step: 0.001,
      key: 0.01,
      neutral: distribution.start,
      distribution,
      words: (value) => text.lengthAndRank(face.measure(measure), standing(value, distribution.place(value))),
      typed: {
        label: text.typedLength(spoken(measure)),
        unit: 'mm',
        min: LENGTHS[0],
        max: LENGTHS[1],
        step: 0.1,
        show: () => Number(face.measure(measure).toFixed(1)),
        take: (mm) => editor.setMeasure(measure, mm),
      },
      move: (value) => {
        if (isBeyond(value)) editor.moveBy((present) => distribution.reach(present, value));
        else editor.move(name, value);
      },
      hold: () => {
        before = rows.map((entry) => entry.distribution.of(face));
      },
      finish: () => {
        before = null;
        editor.finish(`move ${name}`);
      },
      extra: [element('span', { class: 'row-tools' }, clear, lock)],
    });
    rows.push({ measure, distribution, slider, lock });
    return slider.root;
  }

  function refresh() {
    if (!visible) return;
    const held = face.lockedMeasures;
    rows.forEach(({ measure, distribution, slider, lock }, i) => {
      const value = distribution.of(face);
      slider.show(value);
      const was = before?.[i];
      slider.ghost(was !== undefined && Math.abs(was - value) > 0.005 ? was : null);
      const isHeld = held.includes(measure);
      if (lock.getAttribute('aria-pressed') !== String(isHeld)) {
        lock.setAttribute('aria-pressed', String(isHeld));
        lock.replaceChildren(icon(isHeld ? 'lock' : 'unlock'));
      }
    });
  }
  editor.onShape(refresh);
  editor.onStep(refresh);

  const list = element('div', {});
  let built = false;
  function build() {
    built = true;
    rows = [];
    list.replaceChildren();
    /** @type {Map<string, HTMLElement>} */
    const parts = new Map();
    for (const control of model.controls) {
      if (!control.measure) continue;
      const group = groupOfMeasure(control.measure);
      let part = parts.get(group);
      if (!part) {
        part = element('section', { class: 'part' }, element('h3', {}, titleOf(group)));
        parts.set(group, part);
        list.append(part);
      }
      part.append(row(control, control.measure));
    }
  }

  limits.onChange(() => {
    if (!built) return;
    build();
    refresh();
  });

  return {
    /** Whether the model has such controls. */
    any: model.controls.some(({ measure }) => measure),
    root: element(
      'div',
      {},
      element('div', { class: 'scroll' }, element('p', { class: 'note' }, text.meaningsAbout), list, limits.box()),
    ),
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      if (now && !built) build();
      refresh();
    },
  };
}
