import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { encodeMarks, FIRST, KINDS, marksOf, MOST, SIZES } from '../head/marks.js';
import { createPins } from '../stage/pins.js';
import { markColour } from '../head/marking.js';
import { tapping, text } from '../text.js';
import { createSlider } from './slider.js';

/** A scar is longer than this when it is put on, mm. */
const SHORTEST = 2;
/** How many colours are shown along a track. */
const STOPS = 7;

const PARTS = /** @type {const} */ (['size', 'tone', 'form', 'strength']);

/** @typedef {import('../head/marks.js').Mark} Mark */
/** @typedef {import('../head/marks.js').Kind} Kind */

/**
 * Marks of the skin: which kinds there are to put on, those that the face has, and sliders for the one that is chosen.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   canvas: HTMLCanvasElement,
 *   spotting: import('../stage/spotting.js').Spotting,
 *   beforeFrame: Set<() => void>,
 *   paints: (colouring: import('../head/colouring.js').Colouring) => { skin: import('three').Color },
 *   say: (sentence: string) => void,
 * }} parts
 */
export function createMarks(editor, { canvas, spotting, beforeFrame, paints, say }) {
  let visible = false;
  /** Which of them is chosen; -1 is none. */
  let chosen = -1;
  /** What is to be put somewhere, and where it begins if that is known and it has an end. @type {{ kind: Kind, at: import('../head/marks.js').Place | null } | null} */
  let placing = null;

  const present = () => marksOf(editor.colouring);
  /** Part of a gesture: the face has these. @param {readonly Mark[]} marks */
  const set = (marks) => editor.moveColours({ marks: encodeMarks(marks) });
  /** A step. @param {readonly Mark[]} marks @param {string} what */
  function step(marks, what) {
    editor.part();
    set(marks);
    editor.finish(what);
  }
  /** @param {number} i @param {Partial<Mark>} how */
  const changed = (i, how) => present().map((mark, j) => (j === i ? { ...mark, ...how } : mark));

  /** A mark's pins are called by its number and by which end of it they are. @param {string} id @returns {[number, 'at' | 'to']} */
  const read = (id) => [parseInt(id, 10), id.endsWith('to') ? 'to' : 'at'];
  const pins = createPins(canvas, spotting, {
    choose: (id) => choose(read(id)[0]),
    move(id, place) {
      const [i, end] = read(id);
      set(changed(i, { [end]: place }));
    },
    drop: (id) => editor.finish(`mark ${id}`),
    cancel: editor.cancel,
    grow(id, steps) {
      const [i] = read(id);
      const { kind, size } = present()[i];
      const { least, most, step: by } = SIZES[kind];
      set(changed(i, { size: Math.min(most, Math.max(least, size + steps * by)) }));
      editor.finish(`mark size ${i}`);
    },
    remove: (id) => remove(read(id)[0]),
    leave,
    put,
  });
  beforeFrame.add(pins.draw);

  /** What each is called: those of a kind are counted where there are several. @param {readonly Mark[]} marks */
  function namesOf(marks) {
    return marks.map(({ kind }, i) => {
      const alike = marks.filter((mark) => mark.kind === kind);
      return text.marks.called(text.marks.kinds[kind], alike.length > 1 ? marks.slice(0, i + 1).filter((mark) => mark.kind === kind).length : 0);
    });
  }
  const add = new Map(
    KINDS.map((kind) => [
      kind,
      element('button', { type: 'button', class: 'button small', 'aria-pressed': 'false', onclick: () => (placing?.kind === kind ? leave() : begin(kind)) }, icon('plus'), text.marks.kinds[kind]),
    ]),
  );
  const told = element('p', { class: 'note', role: 'status' });
  const list = element('div', { class: 'row', role: 'group', 'aria-label': text.marks.list, hidden: true });
  const where = element('p', { class: 'note' });
  const heading = element('h4', {});
  const sliders = new Map(KINDS.map((kind) => [kind, slidersOf(kind)]));
  const hold = element('button', { type: 'button', class: 'button small', title: text.marks.moveAbout, onclick: () => pins.focus(`${chosen} at`) }, text.marks.move);
  const bin = element('button', { type: 'button', class: 'button small', onclick: () => remove(chosen) }, icon('bin'), text.marks.remove);
  const detail = element('div', { class: 'mark', role: 'group', hidden: true }, heading, where, ...[...sliders.values()].flatMap((some) => some.map(({ slider }) => slider.root)), element('div', { class: 'row' }, hold, bin));

  /** @param {Kind} kind */
  function slidersOf(kind) {
    return PARTS.map((part) => {
      const isSize = part === 'size';
      const { least, most, step: by } = isSize ? SIZES[kind] : { least: 0, most: 1, step: 0.01 };
      const label = text.marks.parts[kind][part];
      const words = isSize ? text.millimetres : (/** @type {number} */ value) => text.percent(100 * value);
      const move = (/** @type {number} */ value) => {
        if (chosen >= 0) set(changed(chosen, { [part]: value }));
      };
      const finish = () => editor.finish(`mark ${part} ${chosen}`);
      const slider = createSlider({
        name: label,
        label,
        id: `mark-${kind}-${part}`,
        about: '',
        title: text.marks.reset,
        limits: [least, most],
        step: by,
        key: by,
        neutral: FIRST[kind][part],
        words,
        typed: {
          label: isSize ? text.marks.typedSize(label) : text.typedColour(label),
          unit: isSize ? 'mm' : '%',
          min: isSize ? least : 0,
          max: isSize ? most : 100,
          step: isSize ? by : 1,
          show: (value) => (isSize ? Number(value.toFixed(1)) : Math.round(100 * value)),
          take: (shown) => {
            editor.part();
            move(isSize ? shown : shown / 100);
            finish();
          },
        },
        move,
        cancel: editor.cancel,
        finish,
      });
      return { part, slider };
    });
  }

  /** @param {number} i */
  function choose(i) {
    if (i === chosen) return;
    chosen = i;
    refresh();
  }
  /** @param {Kind} kind */
  function begin(kind) {
    if (present().length >= MOST) return say(text.marks.full(MOST));
    placing = { kind, at: null };
    chosen = -1;
    refresh();
    pins.aim(text.marks.aim(text.marks.kinds[kind]));
  }
  /** What is to be put somewhere is not, or nothing is chosen any more. */
  function leave() {
    if (placing) {
      const button = add.get(placing.kind);
      placing = null;
      const had = pins.rest();
      refresh();
      if (had) button?.focus();
      return;
    }
    const before = list.children[chosen];
    choose(-1);
    if (before instanceof HTMLElement) before.focus();
  }
  /** @param {import('../head/marks.js').Place | null} place */
  function put(place) {
    if (!placing) return;
    if (!place) return say(text.marks.beside);
    const { kind, at } = placing;
    if (kind === 'scar' && !at) {
      placing.at = place;
      refresh();
      return pins.aim(text.marks.aimEnd(text.marks.kinds[kind]));
    }
    // A double click is no scar.
    if (at && spotting.apart(at, place) < SHORTEST) return say(tapping(text.marks.putEnd));
    const marks = present();
    placing = null;
    pins.rest();
    chosen = marks.length;
    step([...marks, kind === 'scar' && at ? { kind, at, to: place, ...FIRST[kind] } : { kind, at: place, ...FIRST[kind] }], 'mark');
    refresh();
    // Its keys are there for who wants it a little further on.
    pins.focus(`${chosen} at`);
  }
  /** @param {number} i */
  function remove(i) {
    const marks = present();
    if (i < 0 || i >= marks.length) return;
    chosen = -1;
    step(marks.filter((_, j) => j !== i), 'no mark');
    refresh();
    const next = list.children[Math.min(i, marks.length - 2)] ?? add.get(marks[i].kind);
    if (next instanceof HTMLElement) next.focus();
  }

  function refresh() {
    const marks = visible ? present() : [];
    if (chosen >= marks.length) chosen = -1;
    const names = namesOf(marks);
    pins.show([
      ...marks.flatMap(({ kind, at, to, size }, i) => {
        const across = kind === 'birthmark' ? 0 : size;
        const ends = to ? /** @type {const} */ ([['at', at, text.marks.begins(names[i])], ['to', to, text.marks.ends(names[i])]]) : /** @type {const} */ ([['at', at, names[i]]]);
        return ends.map(([end, place, label]) => ({ id: `${i} ${end}`, label, place, across, isChosen: i === chosen }));
      }),
      ...(placing?.at ? [{ id: 'first', label: text.marks.begins(text.marks.kinds[placing.kind]), place: placing.at, across: 0, isChosen: true, still: true }] : []),
    ]);
    for (const [kind, button] of add) button.setAttribute('aria-pressed', String(placing?.kind === kind));
    const asked = placing ? (placing.kind === 'scar' ? (placing.at ? text.marks.putEnd : text.marks.putBegin) : text.marks.put(text.marks.kinds[placing.kind].toLowerCase())) : marks.length === 0 ? text.marks.none : '';
    told.textContent = tapping(asked);
    told.hidden = !asked;
    list.hidden = marks.length === 0;
    while (list.children.length > marks.length) list.lastChild?.remove();
    while (list.children.length < marks.length) {
      const i = list.children.length;
      list.append(element('button', { type: 'button', class: 'button small', onclick: () => pick(i) }));
    }
    for (const [i, button] of [...list.children].entries()) {
      if (button.textContent !== names[i]) button.textContent = names[i];
      button.setAttribute('aria-pressed', String(i === chosen));
    }
    const mark = marks[chosen];
    detail.hidden = !mark;
    if (!mark) return;
    detail.setAttribute('aria-label', names[chosen]);
    heading.textContent = names[chosen];
    where.textContent = text.marks.where(spotting.whereabouts(mark.at));
    for (const [kind, some] of sliders) {
      for (const { part, slider } of some) {
        slider.root.hidden = kind !== mark.kind;
        if (kind !== mark.kind) continue;
        slider.show(mark[part]);
        if (part !== 'tone') continue;
        const { skin } = paints(editor.colouring);
        const ramp = Array.from({ length: STOPS }, (_, i) => `#${markColour(kind, i / (STOPS - 1), skin).getHexString()}`);
        slider.root.style.setProperty('--ramp', `linear-gradient(90deg, ${ramp.join(', ')})`);
      }
    }
  }
  /** @param {number} i */
  function pick(i) {
    if (i === chosen) return choose(-1);
    if (placing) leave();
    choose(i);
    spotting.turnTo(present()[i].at);
  }
  editor.onColours(refresh);

  return {
    root: element('section', { class: 'part', 'aria-label': text.marks.title, onkeydown: (/** @type {KeyboardEvent} */ event) => event.key === 'Escape' && placing && leave() }, element('h3', {}, text.marks.title), element('div', { class: 'row', role: 'group', 'aria-label': text.marks.add }, ...add.values()), told, list, detail),
    /** Lies over the stage. */
    pins: pins.root,
    /** Whether a click on the head is for a mark. */
    get isPlacing() {
      return placing !== null;
    },
    /** Nothing is put anywhere. */
    leave,
    /** Puts what is to be put somewhere there. @param {number} x @param {number} y CSS px */
    putAt: (x, y) => put(spotting.under(x, y)),
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      if (!now) {
        placing = null;
        chosen = -1;
        pins.rest();
      }
      refresh();
    },
  };
}
