import './expressions.css';
import { createBlinking } from './blinking.js';
import { element } from '../frame/element.js';
import { createExpressionPresets } from './expressionpresets.js';
import { createGaze } from './gaze.js';
import { icon } from '../frame/icons.js';
import { createSlider } from './slider.js';
import { text } from '../text.js';

/** The groups in the order of the panel, and the beginnings of the names in them. */
const GROUPS = /** @type {const} */ ([
  ['eyes', /^eye/],
  ['brows', /^brow/],
  ['mouth', /^mouth/],
  ['jaw', /^jaw/],
  ['cheeks', /^(cheek|nose)/],
]);

/**
 * Slides to a side, and glances: their other side is not their mirror image, or both together are a
 * squint.
 */
const ONE_SIDED = /^(jaw|mouth)(Left|Right)$|^eyeLook/;

/**
 * The names in rows: a row is an expression, or one that is on both sides.
 * @param {readonly string[]} names
 */
function rowsOf(names) {
  /** @type {Map<string, string[]>} */
  const rows = new Map();
  for (const name of names) {
    const base = ONE_SIDED.test(name) ? name : name.replace(/(Left|Right)$/, '');
    rows.set(base, [...(rows.get(base) ?? []), name]);
  }
  return [...rows].map(([base, members]) => ({ base, members }));
}

/**
 * What the face does: sliders by ARKit's names, glances, a blink. The file comes when it is wanted.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{ load: () => Promise<void> }} file
 * @param {import('../stage/display.js').Display} display
 */
export function createExpressions(editor, file, display) {
  const { model, face } = editor;
  let visible = false;
  let linked = true;
  /** That an expression with two different sides made two of each slider, and nobody asked for it. */
  let parted = false;
  /** A slider in hand that passes what the other side has stays what it is. */
  let ownStep = false;
  let built = false;
  /** @type {{ members: string[], slider: import('./slider.js').Slider }[]} */
  let rows = [];

  const state = element('p', { class: 'note', role: 'status' });
  const retry = element('button', { type: 'button', class: 'button', hidden: true, onclick: come }, text.tryAgain);
  const neutral = element(
    'button',
    { type: 'button', class: 'button', onclick: () => editor.express({}) },
    icon('reset'),
    text.neutral,
  );
  const blink = element(
    'button',
    {
      type: 'button',
      class: 'button',
      'aria-pressed': 'false',
      onclick: () => {
        const shut = blink.getAttribute('aria-pressed') !== 'true' ? 1 : 0;
        editor.express({ ...face.expression, eyeBlinkLeft: shut, eyeBlinkRight: shut });
      },
    },
    text.blink,
  );
  const gaze = createGaze({
    move: (weights) => editor.moveExpression(weights),
    cancel: editor.cancel,
    finish: () => editor.finish('gaze'),
  });
  const together = element('input', {
    type: 'checkbox',
    id: 'expressions-linked',
    checked: true,
    onchange: () => {
      parted = false;
      link(together.checked);
      if (linked) editor.express(evened());
    },
  });
  const presets = createExpressionPresets(editor, editor.express);
  const blinking = createBlinking(display);
  const alone = element('input', { type: 'checkbox', id: 'expressions-blinking', onchange: () => blinking.set(alone.checked) });
  const body = element('div', {});

  /** The expression with both sides as strong as the stronger. */
  function evened() {
    const expression = { ...face.expression };
    for (const { members } of rowsOf(model.expressions)) {
      const most = Math.max(...members.map((name) => expression[name] ?? 0));
      for (const name of members) expression[name] = most;
    }
    return expression;
  }
  function isEven() {
    const { expression } = face;
    return rowsOf(model.expressions).every(({ members }) => members.every((name) => expression[name] === expression[members[0]]));
  }

  /** @param {() => void} step */
  function byOne(step) {
    ownStep = true;
    step();
    ownStep = false;
  }
  /** @param {string[]} members @param {string} name */
  function row(members, name) {
    const [, base, side] = /^(.*?)(Left|Right)?$/.exec(ONE_SIDED.test(name) ? '' : name) ?? [];
    const label = text.expression(base || name, side);
    const slider = createSlider({
      name: label,
      label: element('span', {}, label, ' ', element('small', { class: 'arkit' }, name)),
      id: `expression-${name}`,
      about: '',
      title: text.resetExpression,
      limits: [0, 1],
      step: 0.01,
      key: 0.01,
      neutral: 0,
      words: (weight) => text.percent(100 * weight),
      typed: {
        label: text.typedExpression(label),
        unit: '%',
        min: 0,
        max: 100,
        step: 1,
        show: (weight) => Math.round(100 * weight),
        take: (percent) => byOne(() => editor.express({ ...face.expression, ...weigh(percent / 100) })),
      },
      move: (weight) => editor.moveExpression(weigh(weight)),
      cancel: editor.cancel,
      finish: () => byOne(() => editor.finish(`express ${name}`)),
    });
    const weigh = (/** @type {number} */ weight) => Object.fromEntries(members.map((member) => [member, weight]));
    rows.push({ members, slider });
    return slider.root;
  }

  function build() {
    built = true;
    rows = [];
    const { id = '' } = body.contains(document.activeElement) ? /** @type {Element} */ (document.activeElement) : {};
    const all = rowsOf(model.expressions);
    body.replaceChildren(
      ...GROUPS.map(([group, pattern]) => {
        const here = all.filter(({ base }) => pattern.test(base));
        const sliders = (/** @type {typeof here} */ some) =>
          some.flatMap(({ base, members }) => (linked ? [row(members, base)] : members.map((name) => row([name], name))));
        const glances = here.filter(({ base }) => base.startsWith('eyeLook'));
        return element(
          'section',
          { class: 'part', 'aria-label': text.expressionGroups[group] },
          element('h3', {}, text.expressionGroups[group]),
          ...(group === 'eyes' ? [gaze.root] : []),
          ...sliders(here.filter((one) => !glances.includes(one))),
          ...(glances.length
            ? [element('details', { class: 'advanced' }, element('summary', {}, text.eachEye), ...sliders(glances))]
            : []),
        );
      }),
    );
    // Of two that were one, or of one that was two, it is either.
    const base = id.replace(/(Left|Right)$/, '');
    if (id) [id, base, `${base}Left`].map((name) => document.getElementById(name)).find((slider) => slider)?.focus();
    refresh();
  }
  /** @param {boolean} now */
  function link(now) {
    if (now === linked) return;
    linked = now;
    if (now) parted = false;
    together.checked = now;
    build();
  }

  function refresh() {
    if (!visible || !built) return;
    // A wink that came from elsewhere is not one slider.
    if (linked && !isEven()) {
      parted = true;
      return link(false);
    }
    const { expression } = face;
    for (const { members, slider } of rows) slider.show(Math.max(...members.map((name) => expression[name] ?? 0)));
    gaze.show(expression);
    presets.show(expression);
    blink.setAttribute('aria-pressed', String((expression.eyeBlinkLeft ?? 0) > 0.99 && (expression.eyeBlinkRight ?? 0) > 0.99));
    neutral.disabled = Object.keys(expression).length === 0;
  }

  async function come() {
    if (built) return refresh();
    state.textContent = text.loadingExpressions;
    retry.hidden = true;
    try {
      await file.load();
      state.textContent = '';
      together.disabled = alone.disabled = blink.disabled = false;
      presets.enable();
      if (!built) build();
    } catch (error) {
      state.textContent = text.noExpressions(error instanceof Error ? error.message : String(error));
      retry.hidden = false;
    }
  }
  together.disabled = alone.disabled = blink.disabled = neutral.disabled = true;
  editor.onShape(refresh);
  editor.onStep(() => {
    // A wink that is over, or taken back, leaves the panel as it was.
    if (parted && !ownStep && isEven()) link(true);
    else refresh();
  });

  return {
    root: element(
      'div',
      { class: 'expressions' },
      element(
        'div',
        { class: 'scroll' },
        element('div', { class: 'row' }, neutral, blink),
        presets.root,
        element('label', { class: 'check' }, together, text.bothSides),
        element('label', { class: 'check', title: text.blinkingAbout }, alone, text.blinking),
        state,
        retry,
        body,
      ),
    ),
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      if (now) come();
    },
  };
}
