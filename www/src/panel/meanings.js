import { isBeyond } from './distribution.js';
import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { createLengths } from './lengths.js';
import { groupOfMeasure } from './measures.js';
import { createSlider } from './slider.js';
import { createTimeslices } from './timeslice.js';
import { meant, spoken, standing, text, titleOf } from '../text.js';

/** What of a length is seen, mm: it is shown with one digit after the point. */
const SEEN = 0.05;
/** Steps after which a length that is as it was typed may be so by chance, unless it is to this, mm, as where its part stayed. */
const ANOTHER = new Set(['random', 'reset', 'take', 'blend']);
const THE_SAME = 0.001;

/** @typedef {import('./distribution.js').Distribution} Distribution */

/**
 * The lengths of a face: of each its slider, its number, its lock. The model has controls for most of them.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   distributions: ReturnType<typeof import('./distribution.js').createDistributions>,
 *   limits: import('./limits.js').Limits,
 * }} parts
 */
export function createMeanings(editor, { distributions, limits }) {
  const { model, face } = editor;
  const others = createLengths(model);
  let visible = false;
  /** Where the sliders stood when one of them was taken up. @type {number[] | null} */
  let before = null;
  /** What of the present face was typed, as it then was: others move it, as in people lengths go together. @type {Map<string, number>} */
  let typed = new Map();
  /** That of each face that was, by its code, for steps back and forth. @type {Map<string, Map<string, number>>} */
  const typedOf = new Map();
  /** What the length that was typed last did to others that were. */
  let aside = '';

  /** @type {{ measure: string, distribution: Distribution, slider: import('./slider.js').Slider, lock: HTMLButtonElement }[]} */
  let rows = [];
  /** @param {Parameters<typeof icon>[0]} sign @param {string} said @param {() => void} onclick */
  const tool = (sign, said, onclick) =>
    element('button', { type: 'button', class: 'tool small', 'aria-label': said, title: said, onclick }, icon(sign));

  /**
   * @param {{
   *   name: string, measure: string, about: string, distribution: Distribution, ends: readonly [number, number],
   *   back: HTMLElement, hold?: () => void, move: (value: number) => void, take: (mm: number) => void,
   * }} of `back` undoes it, `move` is a part of a gesture, `take` is a whole one
   */
  function row({ name, measure, about, distribution, ends, back, hold, move, take }) {
    const words = spoken(name);
    const id = `meaning-${name.replaceAll(/\W+/g, '-')}`;
    const lock = tool('unlock', text.lockMeasure(spoken(measure)), () => editor.toggleMeasureLock(measure));
    const [least, most] = ends.map(distribution.reading);
    const slider = createSlider({
      name: words,
      label: words,
      id,
      about,
      title: text.resetLength,
      limits: limits.present,
      ends,
      step: 0.001,
      key: 0.01,
      neutral: distribution.start,
      distribution,
      words: (value) => text.lengthAndRank(face.measure(measure), standing(value, distribution.place(value))),
      typed: {
        label: text.typedLength(spoken(measure)),
        unit: 'mm',
        min: least,
        max: most,
        step: 0.1,
        show: () => Number(face.measure(measure).toFixed(1)),
        atRank: (percent) => distribution.reading(percent / 100),
        take: (mm) => type(measure, () => take(mm)),
        ended: (mm) => limits.ended(text.millimetres(mm), id),
        also: () => aside,
      },
      move,
      hold: () => {
        before = rows.map((entry) => entry.distribution.of(face));
        hold?.();
      },
      cancel: editor.cancel,
      finish: () => {
        before = null;
        editor.finish(`move ${name}`);
      },
      extra: [element('span', { class: 'row-tools' }, back, lock)],
    });
    rows.push({ measure, distribution, slider, lock });
    return slider.root;
  }

  /** Who types several is told of each that is no longer what they typed. @param {string} measure @param {() => void} take */
  function type(measure, take) {
    const known = [...typed.keys()].filter((name) => name !== measure).map((name) => /** @type {const} */ ([name, face.measure(name)]));
    take();
    const moved = known
      .map(([name, mm]) => /** @type {const} */ ([name, face.measure(name) - mm]))
      .filter(([, by]) => Math.abs(by) >= SEEN)
      .sort(([, a], [, b]) => Math.abs(b) - Math.abs(a));
    for (const name of [measure, ...moved.map(([name]) => name)]) typed.set(name, face.measure(name));
    typedOf.set(face.code, typed);
    aside = moved.length > 0 ? text.typedMoved(moved.map(([name, by]) => [spoken(name), by])) : '';
  }

  /** @param {Length} length @param {import('phiz').Control} control @param {Distribution} distribution */
  function controlled({ name, measure, about }, control, distribution) {
    return row({
      name,
      measure,
      about,
      distribution,
      // Where the part has no room to go on, and would crumple, unless people ask for more.
      ends: limits.beyond ? limits.present : control.limits,
      back: tool('reset', text.clearMeasure(spoken(name)), () => editor.clear(name)),
      move: (value) => {
        if (isBeyond(value)) editor.moveBy((present) => distribution.reach(present, value));
        else editor.move(name, value);
      },
      take: (mm) => editor.setMeasure(measure, mm),
    });
  }

  /** @param {Length} length @param {Distribution} distribution */
  function uncontrolled({ name, about }, distribution) {
    /** @type {import('../editing/history.js').State | null} */
    let from = null;
    const take = (/** @type {number} */ mm) => {
      editor.part();
      editor.moveBy((present) => others.set(present, name, mm));
      editor.finish(`set ${name}`);
    };
    return row({
      name,
      measure: name,
      about,
      distribution,
      ends: limits.present,
      back: tool('reset', text.resetMeasure(spoken(name)), () => take(distribution.reading(distribution.start))),
      hold: () => {
        from = editor.state;
      },
      // There and back again is the face that it was.
      move: (value) => editor.moveFrom(from ?? editor.state, (present) => distribution.reach(present, value)),
      take,
    });
  }

  function refresh() {
    if (!visible) return;
    const held = face.lockedMeasures;
    rows.forEach((row, i) => show(row, i, held));
  }
  /** @param {typeof rows[number]} row @param {number} i @param {readonly string[]} held */
  function show({ measure, distribution, slider, lock }, i, held) {
    const value = distribution.of(face);
    slider.show(value);
    const was = before?.[i];
    slider.ghost(was !== undefined && Math.abs(was - value) > 0.005 ? was : null);
    const isHeld = held.includes(measure);
    if (lock.getAttribute('aria-pressed') !== String(isHeld)) {
      lock.setAttribute('aria-pressed', String(isHeld));
      lock.replaceChildren(icon(isHeld ? 'lock' : 'unlock'));
    }
  }
  editor.onShape(refresh);
  editor.onStep((what) => {
    const { code } = face;
    const near = ANOTHER.has(what) ? THE_SAME : SEEN;
    typed = typedOf.get(code) ?? new Map([...typed].filter(([name, mm]) => Math.abs(face.measure(name) - mm) < near));
    if (typed.size > 0) typedOf.set(code, typed);
    for (const { slider } of rows) slider.hush();
    refresh();
  });

  const list = element('div', {});
  let built = false;
  /** @typedef {{ name: string, measure: string, about: string, control?: import('phiz').Control }} Length */
  /** In the order in which they stand in each part. @type {Length[]} */
  const lengths = model.controls.flatMap((control) => {
    const measure = model.measures.find(({ name }) => name === control.measure);
    return measure ? [{ name: control.name, measure: measure.name, about: meant(measure), control }] : [];
  });
  const without = others.measures.map((measure) => ({ name: measure.name, measure: measure.name, about: meant(measure) }));
  lengths.unshift(...without.filter(({ name }) => groupOfMeasure(name) === 'head'));
  lengths.push(...without.filter(({ name }) => groupOfMeasure(name) !== 'head'));
  /** How people differ in each, once that is known. @type {Map<Length, Distribution>} */
  const known = new Map();
  /** Where there will be a row then. @type {Map<Length, HTMLElement>} */
  const awaited = new Map();

  function build() {
    built = true;
    rows = [];
    awaited.clear();
    list.replaceChildren();
    /** @type {Map<string, HTMLElement>} */
    const parts = new Map();
    /** @param {string} measure */
    const partOf = (measure) => {
      const group = groupOfMeasure(measure);
      let part = parts.get(group);
      if (!part) {
        part = element('section', { class: 'part' }, element('h3', {}, group === 'head' ? text.wholeFace : titleOf(group)));
        parts.set(group, part);
        list.append(part);
      }
      return part;
    };
    for (const length of lengths) {
      const distribution = known.get(length);
      const made = distribution ? rowOf(length, distribution) : roomFor(length);
      if (!distribution) awaited.set(length, made);
      partOf(length.measure).append(made);
    }
  }
  /** @param {Length} length @param {Distribution} distribution */
  const rowOf = (length, distribution) => (length.control ? controlled(length, length.control, distribution) : uncontrolled(length, distribution));
  /** Nothing moves when the row comes. @param {Length} length */
  const roomFor = ({ name, about }) =>
    element('div', { class: 'control' }, element('p', { class: 'awaited' }, spoken(name)), element('div', { class: 'track' }), element('p', { class: 'about' }, about));

  /** @param {Length} length @param {Distribution} distribution */
  function put(length, distribution) {
    known.set(length, distribution);
    awaited.get(length)?.replaceWith(rowOf(length, distribution));
    awaited.delete(length);
    const last = rows.length - 1;
    if (visible) show(rows[last], last, face.lockedMeasures);
  }
  /** All that can be seen comes first: a control takes 10 ms, and all lengths without one together 200. */
  async function fill() {
    const pause = createTimeslices();
    const seen = lengths.filter((length) => (awaited.get(length)?.getBoundingClientRect().top ?? 0) < window.innerHeight);
    /** @param {Length[]} some */
    const putControls = async (some) => {
      for (const length of some) {
        if (!length.control || known.has(length)) continue;
        put(length, distributions(length.control));
        await pause();
      }
    };
    await putControls(seen);
    const found = await others.distributions(pause);
    for (const length of lengths) {
      const distribution = found.get(length.name);
      if (distribution) put(length, distribution);
    }
    await putControls(lengths);
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
      if (now && !built) {
        build();
        void fill();
      }
      refresh();
    },
  };
}
