import { element } from '../frame/element.js';
import { coloursAlong, told } from '../head/someone.js';
import { text } from '../text.js';
import { createSlider } from './slider.js';
import { createSymmetry } from './symmetry.js';
import { changeIn, numberAndRest } from './typed.js';
import { ETHNICITY, ORDER } from './wishes.js';

// What labels say of the person, as sliders: the face becomes older, or more of a man's, and stays as like itself as it can.

const BARS = 61;

/**
 * The model's people behind a track, of which a label is normal; the highest is 1.
 * @param {readonly [number, number]} limits of the track @param {number} mean @param {number} deviation
 */
function bellOf([least, most], mean, deviation) {
  const bars = Array.from({ length: BARS }, (_, i) => Math.exp(-0.5 * ((least + (i / (BARS - 1)) * (most - least) - mean) / deviation) ** 2));
  const highest = Math.max(...bars);
  return bars.map((bar) => bar / highest);
}

/**
 * How much of a man's a face is, per cent, that is said to be so much of a woman's or a man's, or so much more. A number alone is of what the
 * face is said to be.
 * @param {string} typed @param {number} present
 */
function maleness(typed, present) {
  const change = changeIn(typed, 0, '%');
  const [percent, rest] = numberAndRest(change ?? typed);
  const said = rest.replace(/^%\s*/, '');
  const sex = said ? text.person.sexes.findIndex((word) => word.startsWith(said)) : Number(present >= 50);
  if (change !== null) return present + ([-percent, percent][sex] ?? NaN);
  return [100 - percent, percent][sex] ?? NaN;
}

/**
 * @param {import('../editing/editor.js').Editor} editor
 * @param {import('./limits.js').Limits} limits
 */
export function createPerson(editor, limits) {
  const { model, face } = editor;
  const symmetry = createSymmetry(editor, limits);
  const median = model.face();
  const shares = model.attributes.filter(({ name }) => ETHNICITY.includes(name));
  const place = (/** @type {string} */ name) => ORDER.indexOf(ETHNICITY.includes(name) ? 'ethnicity' : name) + 1 || 99;
  const ordered = [...model.attributes].sort((a, b) => place(a.name) - place(b.name));

  const along = element('input', { type: 'checkbox', id: 'person-colours', checked: true });
  /** @typedef {{ state: import('../editing/history.js').State, told: ReturnType<typeof told>, reads: Map<string, number> }} Start */
  /** What the face was when a slider was taken up. @type {Start | null} */
  let start = null;

  function hold() {
    start ??= { state: editor.state, told: told(face), reads: new Map(model.attributes.map(({ name }) => [name, face.attribute(name)])) };
  }

  /**
   * What is asked for so that one attribute is at a value: of shares of one whole the others are as much less, each in its proportion.
   * @param {string} name @param {number} value @param {Map<string, number>} reads of the face before
   */
  function asked(name, value, reads) {
    if (!ETHNICITY.includes(name)) return { [name]: value };
    const others = shares.filter((share) => share.name !== name);
    const had = others.map((share) => Math.max(0.001, reads.get(share.name) ?? 0));
    const sum = had.reduce((total, one) => total + one, 0);
    const left = others.map((share, i) => [share.name, ((1 - value) * had[i]) / sum]);
    return { [name]: value, ...Object.fromEntries(left) };
  }

  const rows = ordered.map(({ name, unit, limits, deviation }) => {
    const [least, most] = limits;
    const mean = median.attribute(name);
    const valueAt = (/** @type {number} */ at) => least + at * (most - least);
    // What is beyond the labels stands at their end.
    const placeOf = (/** @type {number} */ value) => Math.min(1, Math.max(0, (value - least) / (most - least)));
    const isAge = unit === 'years';
    /** What was last asked for since it was taken up. @type {((face: import('phiz').Face) => void) | null} */
    let last = null;
    /** @param {number} at */
    function move(at) {
      hold();
      const from = start;
      if (!from) return;
      const values = asked(name, valueAt(at), from.reads);
      // What labels say of the face that it becomes is what is asked: it is not there yet.
      const colours = along.checked ? coloursAlong(from.state.colouring, from.told, toldWith(from, values)) : undefined;
      last = (present) => present.setAttributes(values);
      editor.moveBy(last, colours);
    }
    function done() {
      // Where coefficients met their limits, the way there tells in what was met: the face is that of one step.
      if (start && last) editor.moveFrom(start.state, last, editor.colouring);
      [start, last] = [null, null];
      editor.finish(`become ${name}`);
    }
    const title = text.person.names[name] ?? name;
    const slider = createSlider({
      name: title,
      label: title,
      id: `person-${name.replaceAll(/\W+/g, '-')}`,
      about: text.person.abouts[name] ?? '',
      title: text.person.reset,
      limits: [0, 1],
      step: 0.001,
      key: isAge ? 1 / (most - least) : 0.02,
      neutral: placeOf(mean),
      distribution: { place: (value) => value, value: (at) => at, density: bellOf(limits, mean, deviation) },
      words: (at) => (isAge ? text.person.years(valueAt(at)) : text.person.share(name, valueAt(at))),
      typed: {
        label: title,
        unit: isAge ? unit : '%',
        min: isAge ? least : 100 * least,
        max: isAge ? most : 100 * most,
        step: 1,
        show: (at) => (name === 'sex' ? 100 * valueAt(at) : Math.round(isAge ? valueAt(at) : 100 * valueAt(at))),
        ...(name === 'sex' && { write: (shown) => text.person.share(name, shown / 100), read: maleness }),
        take: (shown) => {
          move(placeOf(isAge ? shown : shown / 100));
          done();
        },
        ...(isAge && { ended: (years) => (years === least ? text.person.adults(years) : text.ended(String(years))) }),
      },
      move,
      hold,
      cancel() {
        last = null;
        editor.cancel();
      },
      finish: done,
    });
    return { name, placeOf, slider, isAsked: () => last !== null };
  });
  median.free();

  /** @param {Start} from @param {Record<string, number>} values that are asked for */
  const toldWith = ({ reads }, values) => told({ model, attribute: (name) => values[name] ?? reads.get(name) ?? 0 });

  let visible = false;
  function refresh() {
    if (!visible) return;
    for (const { name, placeOf, slider, isAsked } of rows) {
      const at = placeOf(face.attribute(name));
      const was = start && placeOf(start.reads.get(name) ?? 0);
      const isMoved = was !== null && Math.abs(was - at) > 0.005;
      // What one slider moves of the others by what nobody sees is not shown anew with each event.
      slider.show(Math.round(1e4 * (was === null || isMoved || isAsked() ? at : was)) / 1e4);
      slider.ghost(isMoved ? was : null);
    }
  }
  editor.onShape(refresh);
  editor.onStep(() => {
    // Another step ended what was under way, and may have taken it back: what follows starts from there.
    start = null;
    refresh();
  });

  return {
    root: element(
      'div',
      { class: 'person', role: 'group', 'aria-label': text.person.title },
      element('h2', {}, text.person.title),
      // Not every model has labels.
      ...(rows.length === 0
        ? []
        : [
            element('p', { class: 'note' }, text.person.about),
            element('div', { class: 'sliders' }, ...rows.map(({ slider }) => slider.root)),
            element('label', { class: 'check', for: along.id }, along, text.person.colours),
          ]),
      symmetry.root,
    ),
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      symmetry.shown(now);
      refresh();
    },
  };
}
