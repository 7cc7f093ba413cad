import { isBeyond, placeOfSigmas, sigmas } from './distribution.js';
import { element, say } from '../frame/element.js';
import { fading, reveal } from '../frame/fading.js';
import { icon } from '../frame/icons.js';
import { createMeasures } from './measures.js';
import { createPerson } from './person.js';
import { createSlider } from './slider.js';
import { standing, text, titleOf } from '../text.js';

const FIRST = 6;
/** Of so many sliders nobody reads all to find one. */
const MANY = 12;
/** What is chosen when no feature is: the whole person. */
const PERSON = 'person';
const ORDER = ['head', 'forehead', 'eyes', 'nose', 'mouth', 'chin'];

/** The features' names, from the head down. @param {import('phiz').FaceModel} model */
export function featuresOf(model) {
  const groups = [...new Set(model.controls.filter(({ measure }) => !measure).map(({ group }) => group))];
  return groups.sort((a, b) => (ORDER.indexOf(a) + 1 || 99) - (ORDER.indexOf(b) + 1 || 99));
}

/**
 * Whether the words below a slider, or its number, are among those that are sought: all of a phrase, any of several with commas between.
 * Beginnings of words will do, and one of several things is sought as all of them.
 * @param {import('phiz').Control} control @param {string} sought
 */
function fits({ name, description }, sought) {
  const words = `${name.split(' ').at(-1)} ${description}`.toLowerCase().split(/[\s,]+/);
  const phrases = sought.toLowerCase().split(',').map((phrase) => phrase.split(/\s+/).filter(Boolean));
  return phrases.some((phrase) => phrase.length > 0 && phrase.every((word) => words.some((known) => known.startsWith(word.replace(/(.)s$/, '$1')))));
}

/**
 * The list of features and the sliders of the chosen one, or of the whole person.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   distributions: ReturnType<typeof import('./distribution.js').createDistributions>,
 *   limits: import('./limits.js').Limits,
 *   random: ReturnType<typeof import('./random.js').createRandom>,
 *   preview: (group: string | null) => void,
 *   pick: (group: string | null) => void,
 * }} parts `pick` is told which feature was chosen here, by hand: none, for the whole person
 */
export function createFeatures(editor, { distributions, limits, random, preview, pick }) {
  const { model, face } = editor;
  const groups = featuresOf(model);
  const first = groups.includes('nose') ? 'nose' : groups[0];
  let chosen = first;
  /** @type {Set<string>} */
  const opened = new Set();

  const person = createPerson(editor, limits);
  /** In the order in which they stand. @type {Map<string, HTMLElement>} */
  const tabs = new Map();
  tabs.set(PERSON, element('button', { type: 'button', class: 'tab whole', onclick: () => pressed(PERSON) }, text.person.title));
  for (const group of groups) {
    const lockSign = icon('lock');
    lockSign.classList.add('lock-sign');
    const button = element(
      'button',
      {
        type: 'button',
        class: 'tab',
        'data-group': group,
        onclick: () => pressed(group),
        onpointerenter: () => preview(group),
        onpointerleave: () => preview(null),
        onfocus: () => button.matches(':focus-visible') && preview(group),
        onblur: () => preview(null),
      },
      titleOf(group),
      lockSign,
    );
    tabs.set(group, button);
  }

  const heading = element('h2', { id: 'feature-title' });
  const surprise = element('button', { type: 'button', class: 'tool', onclick: () => random.randomise([chosen]) }, icon('dice'));
  const reset = element('button', { type: 'button', class: 'tool', onclick: () => editor.reset(chosen) }, icon('reset'));
  const lock = element('button', { type: 'button', class: 'tool', onclick: () => editor.toggleLock(chosen) });
  const lockNote = element('p', { class: 'note', hidden: true }, text.locked);
  const measures = createMeasures(model, face);
  const sliders = element('div', { class: 'sliders', 'aria-labelledby': 'feature-title', role: 'group' });
  const more = element('button', {
    type: 'button',
    class: 'quiet',
    onclick: () => {
      if (!opened.delete(chosen)) opened.add(chosen);
      build();
    },
  });

  const sought = element('input', { type: 'text', id: 'find-slider', autocomplete: 'off', oninput: () => build() });
  const find = element('div', { class: 'field' }, element('label', { for: sought.id }, text.find), sought);
  const found = element('p', { class: 'note', role: 'status' });

  /** @type {{ control: import('phiz').Control, slider: import('./slider.js').Slider, distribution: import('./distribution.js').Distribution }[]} */
  let rows = [];
  /** Where the sliders stood when one of them was taken up. @type {number[] | null} */
  let before = null;

  function hold() {
    before = rows.map(({ distribution }) => distribution.of(face));
    measures.hold();
  }
  /** @param {string} what */
  function finish(what) {
    before = null;
    measures.release();
    editor.finish(what);
  }

  function build() {
    const all = model.controls.filter((control) => control.group === chosen && !control.measure);
    const open = opened.has(chosen);
    find.hidden = all.length <= MANY;
    sought.placeholder = text.findLike[chosen] ?? '';
    const seeks = !find.hidden && sought.value.trim() !== '';
    const fitting = seeks ? all.filter((control) => fits(control, sought.value)) : all;
    rows = (open || seeks ? fitting : all.slice(0, FIRST)).map((control, i) => {
      const id = `control-${control.name.replaceAll(/\W+/g, '-')}`;
      const distribution = distributions(control);
      /** @param {number} value */
      const move = (value) => {
        if (isBeyond(value)) editor.moveBy((present) => distribution.reach(present, value));
        else editor.move(control.name, value);
      };
      const done = () => finish(`move ${control.name}`);
      const slider = createSlider({
        name: control.name,
        label: control.name,
        id,
        about: [...new Set(control.description.split(', '))].join(', ') || text.finer(titleOf(chosen).toLowerCase()),
        title: text.resetControl,
        limits: limits.present,
        step: 0.001,
        key: 0.01,
        neutral: 0.5,
        distribution,
        words: (value) => standing(value, distribution.place(value)),
        typed: limits.beyond
          ? {
              label: text.typedSigmas(control.name),
              unit: 'σ',
              min: sigmas(limits.present[0]),
              max: sigmas(limits.present[1]),
              step: 0.01,
              show: (value) => Number(sigmas(distribution.place(value)).toFixed(2)),
              atRank: (percent) => sigmas(distribution.place(percent / 100)),
              take: (deviations) => {
                move(distribution.value(placeOfSigmas(deviations)));
                done();
              },
            }
          : {
              label: text.typed(control.name),
              unit: '',
              min: 100 * control.limits[0],
              max: 100 * control.limits[1],
              step: 0.1,
              atRank: (percent) => percent,
              show: (value) => Number((100 * Math.min(1, Math.max(0, value))).toFixed(1)),
              take: (percent) => editor.set(control.name, percent / 100),
              ended: (percent) => limits.ended(String(Math.round(percent)), id),
            },
        // What the number is, once for all of them.
        legend: i === 0 && !limits.beyond ? text.percentile : '',
        move,
        hold,
        cancel: editor.cancel,
        finish: done,
      });
      return { control, slider, distribution };
    });
    before = null;
    sliders.replaceChildren(...rows.map(({ slider }) => slider.root));
    more.hidden = all.length <= FIRST || seeks;
    say(found, seeks ? text.found(fitting.length, all.length) : '');
    more.textContent = open ? text.fewer : text.more(all.length - FIRST);
    refreshAll();
  }

  const [least, most] = model.blending.limits;
  const alpha = createSlider({
    name: text.alpha,
    label: text.alpha,
    id: 'alpha',
    about: text.alphaAbout,
    limits: [least, most],
    step: 0.1,
    key: 0.5,
    neutral: model.blending.alpha,
    words: text.millimetres,
    typed: {
      label: text.alphaTyped,
      unit: 'mm',
      min: least,
      max: most,
      step: 0.1,
      show: (mm) => Number(mm.toFixed(1)),
      take: (mm) => {
        editor.moveAlpha(mm);
        editor.finish('type alpha');
      },
    },
    move: (mm) => editor.moveAlpha(mm),
    cancel: editor.cancel,
    finish: () => editor.finish('move alpha'),
  });

  let visible = true;
  function refresh() {
    if (!visible) return;
    if (!feature.hidden) {
      rows.forEach(({ slider, distribution }, i) => {
        const value = distribution.of(face);
        slider.show(value);
        const was = before?.[i];
        slider.ghost(was !== undefined && Math.abs(was - value) > 0.005 ? was : null);
      });
      measures.refresh();
    }
    alpha.show(face.alpha);
  }
  /** What no gesture changes. */
  function refreshAll() {
    refresh();
    if (!visible) return;
    const locked = face.locked;
    for (const [group, tab] of tabs) {
      tab.setAttribute('aria-pressed', String(group === chosen));
      const isLocked = locked.includes(group);
      tab.classList.toggle('is-locked', isLocked);
      tab.title = isLocked ? text.isLocked : '';
    }
    const isLocked = locked.includes(chosen);
    if (lock.getAttribute('aria-pressed') !== String(isLocked)) {
      lock.setAttribute('aria-pressed', String(isLocked));
      lock.replaceChildren(icon(isLocked ? 'lock' : 'unlock'));
    }
    lockNote.hidden = !isLocked;
  }

  /** @param {string} group */
  function pressed(group) {
    choose(group);
    pick(group === PERSON ? null : group);
  }
  /** @param {string} group */
  function choose(group) {
    const tab = tabs.get(group);
    if (!tab) return;
    if (group !== chosen) {
      scroll.scrollTop = 0;
      sought.value = '';
    }
    chosen = group;
    reveal(tab);
    const isPerson = group === PERSON;
    feature.hidden = isPerson;
    person.root.hidden = !isPerson;
    person.shown(visible && isPerson);
    if (isPerson) return refreshAll();
    heading.textContent = titleOf(group);
    const name = titleOf(group).toLowerCase();
    for (const [button, words] of /** @type {const} */ ([
      [surprise, text.randomiseFeature(name)],
      [reset, text.resetFeature(name)],
      [lock, text.lockFeature(name)],
    ])) {
      button.setAttribute('aria-label', words);
      button.title = words;
    }
    measures.choose(group);
    build();
  }

  const feature = element(
    'div',
    { class: 'feature' },
    element('div', { class: 'feature-head' }, heading, surprise, reset, lock),
    lockNote,
    measures.root,
    find,
    found,
    sliders,
    more,
  );

  const scroll = element(
    'div',
    { class: 'scroll' },
    person.root,
    feature,
    random.root,
    element('details', { class: 'advanced' }, element('summary', {}, text.advanced), limits.box(), alpha.root, random.again),
  );
  const strip = fading(element('nav', { class: 'tabs', 'aria-label': text.features }, ...tabs.values()), () => tabs.get(chosen));
  const root = element('div', { class: 'features' }, strip, scroll);
  choose(chosen);
  limits.onChange(build);
  editor.onShape(refresh);
  editor.onStep(refreshAll);

  return {
    root,
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      person.shown(now && chosen === PERSON);
      refreshAll();
    },
    choose,
    /** A feature, where the whole person is chosen. */
    chooseFeature() {
      if (chosen === PERSON) choose(first);
    },
  };
}
