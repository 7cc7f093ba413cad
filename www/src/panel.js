import { element } from './element.js';
import { icon } from './icons.js';
import { ordinal, text } from './text.js';

const FIRST = 8;

/** @param {string} group */
function title(group) {
  return text.groups[group] ?? group.charAt(0).toUpperCase() + group.slice(1);
}

/**
 * The list of features and the sliders of the chosen one.
 *
 * @param {import('./editor.js').Editor} editor
 * @param {{ preview: (group: string | null) => void, say: (sentence: string) => void }} on
 */
export function createPanel(editor, { preview, say }) {
  const { model, face } = editor;
  const groups = [...new Set(model.controls.map((control) => control.group))];
  const order = ['head', 'forehead', 'eyes', 'nose', 'mouth', 'chin'];
  groups.sort((a, b) => (order.indexOf(a) + 1 || 99) - (order.indexOf(b) + 1 || 99));
  let chosen = groups.includes('nose') ? 'nose' : groups[0];
  /** @type {Set<string>} */
  const opened = new Set();
  /** @type {number} */
  let spread = 1;

  const tabs = new Map(
    groups.map((group) => {
      const lockSign = icon('lock');
      lockSign.classList.add('lock-sign');
      const button = element(
        'button',
        {
          type: 'button',
          class: 'tab',
          'data-group': group,
          onclick: () => choose(group),
          onpointerenter: () => preview(group),
          onpointerleave: () => preview(null),
        },
        title(group),
        lockSign,
      );
      return [group, button];
    }),
  );

  const heading = element('h2', { id: 'feature-title' });
  const random = element('button', { type: 'button', class: 'tool', onclick: () => randomise([chosen]) }, icon('dice'));
  const reset = element('button', { type: 'button', class: 'tool', onclick: () => editor.reset(chosen) }, icon('reset'));
  const lock = element('button', { type: 'button', class: 'tool', onclick: () => editor.toggleLock(chosen) });
  const lockNote = element('p', { class: 'note', hidden: true }, text.locked);
  const sliders = element('div', { class: 'sliders', 'aria-labelledby': 'feature-title', role: 'group' });
  const more = element('button', {
    type: 'button',
    class: 'quiet',
    onclick: () => {
      if (!opened.delete(chosen)) opened.add(chosen);
      build();
    },
  });

  /** @type {{ control: import('phiz').Control, input: HTMLInputElement, output: HTMLOutputElement }[]} */
  let rows = [];

  /**
   * A native range input that is one gesture from the first `input` to `change`.
   * @param {{ name: string, id: string, min: number, max: number, step: number,
   *   describedby?: string, move: (value: number) => void, neutral: number }} spec
   */
  function slider({ name, id, min, max, step, describedby, move, neutral }) {
    const input = element('input', {
      type: 'range',
      id,
      min,
      max,
      step,
      'aria-describedby': describedby,
      oninput: () => {
        move(input.valueAsNumber);
        refresh();
      },
      onchange: () => editor.finish(`move ${name}`),
      ondblclick: () => {
        input.valueAsNumber = neutral;
        move(neutral);
        editor.finish(`median ${name}`);
      },
    });
    return input;
  }

  /** Shows a value as text, as the filled part of the track, and to assistive technology. */
  function show(/** @type {HTMLInputElement} */ input, /** @type {HTMLOutputElement} */ output, /** @type {string} */ words, /** @type {number} */ neutral) {
    const [min, max] = [Number(input.min), Number(input.max)];
    const at = (/** @type {number} */ value) => (100 * (value - min)) / (max - min);
    const [a, b] = [at(neutral), at(input.valueAsNumber)];
    input.style.setProperty('--from', `${Math.min(a, b)}%`);
    input.style.setProperty('--to', `${Math.max(a, b)}%`);
    input.setAttribute('aria-valuetext', words);
    output.value = words;
  }

  function build() {
    const all = model.controls.filter((control) => control.group === chosen);
    const open = opened.has(chosen);
    const shown = open ? all : all.slice(0, FIRST);
    rows = [];
    sliders.replaceChildren(
      ...shown.map((control) => {
        const id = `control-${control.name.replaceAll(/\W+/g, '-')}`;
        const output = element('output', { for: id });
        const input = slider({
          name: control.name,
          id,
          min: control.limits[0],
          max: control.limits[1],
          step: 0.001,
          describedby: `${id}-about`,
          neutral: 0.5,
          move: (value) => editor.move(control.name, value),
        });
        input.title = text.resetControl;
        rows.push({ control, input, output });
        return element(
          'div',
          { class: 'control' },
          element('label', { for: id }, control.name),
          output,
          input,
          element('p', { class: 'about', id: `${id}-about` }, control.description || text.finer(title(chosen).toLowerCase())),
        );
      }),
    );
    more.hidden = all.length <= FIRST;
    more.textContent = open ? text.fewer : text.more(all.length - FIRST);
    refresh();
  }

  const [least, most] = model.blending.limits;
  const alphaOut = element('output', { for: 'alpha' });
  const alpha = slider({
    name: 'alpha',
    id: 'alpha',
    min: least,
    max: most,
    step: 0.1,
    describedby: 'alpha-about',
    neutral: model.blending.alpha,
    move: (mm) => editor.moveAlpha(mm),
  });
  const seed = element('input', { type: 'number', id: 'seed', min: 0, step: 1, inputmode: 'numeric' });
  const spreadOut = element('output', { for: 'spread' });
  const spreadIn = element('input', {
    type: 'range',
    id: 'spread',
    min: 0.2,
    max: 2,
    step: 0.05,
    value: 1,
    'aria-describedby': 'spread-about',
    oninput: () => {
      spread = spreadIn.valueAsNumber;
      refresh();
    },
  });
  const advanced = element(
    'details',
    { class: 'advanced' },
    element('summary', {}, text.advanced),
    element(
      'div',
      { class: 'control' },
      element('label', { for: 'alpha' }, text.alpha),
      alphaOut,
      alpha,
      element('p', { class: 'about', id: 'alpha-about' }, text.alphaAbout),
    ),
    element(
      'div',
      { class: 'control' },
      element('label', { for: 'spread' }, text.spread),
      spreadOut,
      spreadIn,
      element('p', { class: 'about', id: 'spread-about' }, text.spreadAbout),
    ),
    element(
      'form',
      {
        class: 'control seed',
        onsubmit: (/** @type {SubmitEvent} */ event) => {
          event.preventDefault();
          if (seed.value !== '') randomise(undefined, seed.valueAsNumber);
        },
      },
      element('label', { for: 'seed' }, text.seed),
      element('span', { class: 'seed-row' }, seed, element('button', { class: 'button' }, text.useSeed)),
      element('p', { class: 'about' }, text.seedAbout),
    ),
  );

  /** @param {string[]} [regions] @param {number} [withSeed] */
  function randomise(regions, withSeed) {
    /** @type {{ seed?: number, spread?: number, regions?: string[] }} */
    const options = { spread };
    if (regions) options.regions = regions;
    if (withSeed !== undefined) options.seed = withSeed;
    const used = editor.randomise(options);
    seed.value = String(used);
    say(text.randomised(used));
  }

  function refresh() {
    for (const { control, input, output } of rows) {
      const value = face.get(control.name);
      input.valueAsNumber = value;
      show(input, output, ordinal(value), 0.5);
    }
    alpha.valueAsNumber = face.alpha;
    show(alpha, alphaOut, text.millimetres(face.alpha), model.blending.alpha);
    show(spreadIn, spreadOut, `× ${spread.toFixed(2)}`, 1);
    const locked = face.locked;
    for (const [group, tab] of tabs) {
      tab.setAttribute('aria-pressed', String(group === chosen));
      tab.classList.toggle('is-locked', locked.includes(group));
    }
    const isLocked = locked.includes(chosen);
    lock.setAttribute('aria-pressed', String(isLocked));
    lock.replaceChildren(icon(isLocked ? 'lock' : 'unlock'));
    lockNote.hidden = !isLocked;
  }

  /** @param {string} group */
  function choose(group) {
    if (!tabs.has(group)) return;
    chosen = group;
    heading.textContent = title(group);
    const name = title(group).toLowerCase();
    for (const [button, words] of /** @type {const} */ ([
      [random, text.randomiseFeature(name)],
      [reset, text.resetFeature(name)],
      [lock, text.lockFeature(name)],
    ])) {
      button.setAttribute('aria-label', words);
      button.title = words;
    }
    build();
    const tab = /** @type {HTMLElement} */ (tabs.get(group));
    const strip = /** @type {HTMLElement} */ (tab.parentElement);
    strip?.scrollTo({ left: tab.offsetLeft - strip.clientWidth / 2 + tab.clientWidth / 2 });
  }

  const root = element(
    'aside',
    { class: 'panel', 'aria-label': text.features },
    element('nav', { class: 'tabs', 'aria-label': text.features }, ...tabs.values()),
    element(
      'div',
      { class: 'feature' },
      element('div', { class: 'feature-head' }, heading, random, reset, lock),
      lockNote,
      sliders,
      more,
      advanced,
    ),
  );
  choose(chosen);
  editor.onShape(refresh);
  editor.onStep(refresh);

  return {
    root,
    choose,
    randomise: () => randomise(),
    get chosen() {
      return chosen;
    },
  };
}
