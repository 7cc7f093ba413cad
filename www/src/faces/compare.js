import { element } from '../frame/element.js';
import { createAngles } from './angles.js';
import { createFaceList } from './facelist.js';
import { OUTLINE } from '../stage/display.js';
import { gradient } from '../stage/heat.js';
import { createHold } from '../frame/hold.js';
import { icon } from '../frame/icons.js';
import { decimal, meant, spoken, text } from '../text.js';

/**
 * The face beside another: held for a moment, split by a line, as distances in colour, as numbers.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   library: import('../keep/library.js').Library,
 *   display: import('../stage/display.js').Display,
 *   stage: HTMLElement,
 *   wears: () => boolean,
 *   reveal: () => void,
 *   say: (sentence: string) => void,
 * }} parts `wears` tells whether the face wears a photo; `reveal` brings the head to the stage, where a photo may be
 */
export function createCompare(editor, { library, display, stage, wears, reveal, say }) {
  const { model, face } = editor;
  const reference = model.face();
  const average = model.face();
  const angles = createAngles(model.landmarks, average.positions);
  average.coefficients = new Float32Array(average.coefficients.length);
  /** Angles are of faces at rest, as lengths are. */
  const rested = model.face();
  /** The face that was there first, or that was made the start. */
  const present = () => ({ code: face.code, looks: { colours: editor.colouring, worn: wears() } });
  let start = present();
  /** How the reference looks. @type {import('../stage/display.js').Looks} */
  let looks = {};
  let visible = false;
  let line = 0.5;

  const list = createFaceList(library, {
    id: 'compare-with',
    label: text.compareWith,
    first: [
      { id: 'start', name: text.startFace },
      { id: 'average', name: text.averageFace },
    ],
    onchange: changed,
  });
  const startNow = element(
    'button',
    {
      type: 'button',
      class: 'link',
      onclick: () => {
        start = present();
        list.select.value = 'start';
        changed();
      },
    },
    text.startNow,
  );

  // Held: the other face for as long as the button is down.
  const { button: hold } = createHold(text.hold, {
    changed(down) {
      stage.classList.toggle('shows-other', down);
      display.show(down ? reference : null, down ? { ...looks, uncoloured: true } : {});
    },
  });

  const split = element('input', { type: 'checkbox', id: 'compare-split', onchange: () => asked(split, applySplit) });
  const outline = element('input', { type: 'checkbox', id: 'compare-outline', onchange: () => asked(outline, () => void applyOutline()) });
  const heat = element('input', { type: 'checkbox', id: 'compare-heat', onchange: () => asked(heat, applyHeat) });
  /** @param {HTMLInputElement} what @param {() => void} apply */
  function asked(what, apply) {
    if (what.checked) reveal();
    apply();
  }

  const leftName = element('span', { class: 'side left' });
  const rightName = element('span', { class: 'side right' }, text.thisFace);
  const divider = element(
    'div',
    {
      class: 'divider',
      role: 'slider',
      tabindex: 0,
      hidden: true,
      'aria-label': text.divider,
      'aria-orientation': 'horizontal',
      'aria-valuemin': 0,
      'aria-valuemax': 100,
      onkeydown: (/** @type {KeyboardEvent} */ event) => {
        /** @type {Record<string, number>} */
        const to = { ArrowLeft: line - 0.02, ArrowRight: line + 0.02, Home: 0, End: 1 };
        if (!(event.key in to)) return;
        event.preventDefault();
        moveLine(to[event.key]);
      },
    },
    leftName,
    rightName,
  );
  // The split stays while another section changes one of the faces: what ends it is where they are.
  const endSplit = element(
    'button',
    {
      type: 'button',
      class: 'tool small split-end',
      hidden: true,
      'aria-label': text.endSplit,
      title: text.endSplit,
      onclick: () => {
        split.checked = false;
        applySplit();
        stage.querySelector('canvas')?.focus();
      },
    },
    icon('close'),
  );
  /** @param {number} to */
  function moveLine(to) {
    line = Math.min(0.98, Math.max(0.02, to));
    applySplit();
  }
  divider.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    divider.focus();
    divider.setPointerCapture(event.pointerId);
  });
  divider.addEventListener('pointermove', (event) => {
    if (!divider.hasPointerCapture(event.pointerId)) return;
    const box = stage.getBoundingClientRect();
    moveLine((event.clientX - box.left) / box.width);
  });

  const scale = element('span', { class: 'scale' });
  scale.style.background = gradient;
  const scaleEnd = element('span', { class: 'most' });
  const bar = element(
    'figure',
    { class: 'colour-bar', hidden: true },
    element('figcaption', {}),
    scale,
    element('span', { class: 'least' }, '0'),
    scaleEnd,
    element(
      'button',
      {
        type: 'button',
        class: 'tool small',
        'aria-label': text.closeHeat,
        title: text.closeHeat,
        onclick: () => {
          heat.checked = false;
          applyHeat();
        },
      },
      icon('close'),
    ),
  );
  const outlineName = element('figcaption', {});
  const stroke = element('span', { class: 'stroke' });
  stroke.style.background = OUTLINE;
  const key = element(
    'figure',
    { class: 'outline-key', hidden: true },
    stroke,
    outlineName,
    element(
      'button',
      {
        type: 'button',
        class: 'tool small',
        'aria-label': text.closeOutline,
        title: text.closeOutline,
        onclick: () => {
          outline.checked = false;
          void applyOutline();
          stage.querySelector('canvas')?.focus();
        },
      },
      icon('close'),
    ),
  );
  // How much room the names have beside the line.
  new ResizeObserver(() => divider.style.setProperty('--wide', `${stage.clientWidth}px`)).observe(stage);
  // Under the buttons that stand on the stage.
  stage.querySelector('canvas')?.after(divider, endSplit, bar, key);

  /** @param {string} caption @param {readonly { name: string, description: string }[]} measures */
  function createTable(caption, measures) {
    const rows = measures.map(({ name, description }) => {
      const cells = [0, 1, 2].map(() => element('td', {}));
      return { row: element('tr', { title: description }, element('th', { scope: 'row' }, spoken(name)), ...cells), cells };
    });
    const columns = [text.measure, text.thisShort, text.otherShort, text.difference].map((words) => element('th', { scope: 'col' }, words));
    return {
      root: element(
        'table',
        { class: 'lengths', hidden: rows.length === 0 },
        element('caption', {}, caption),
        element('thead', {}, element('tr', {}, ...columns)),
        element('tbody', {}, ...rows.map(({ row }) => row)),
      ),
      /** @param {readonly number[]} here @param {readonly number[]} there */
      fill(here, there) {
        for (const [i, { cells }] of rows.entries()) {
          cells[0].textContent = decimal(here[i]);
          cells[1].textContent = decimal(there[i]);
          const apart = here[i] - there[i];
          cells[2].textContent = Math.abs(apart) < 0.05 ? '0.0' : text.change(apart);
          cells[2].classList.toggle('differs', Math.abs(apart) >= 0.05);
        }
      },
    };
  }
  const lengths = createTable(text.lengths, model.measures.map((measure) => ({ name: measure.name, description: meant(measure) })));
  const degrees = createTable(text.angles, angles.names.map((name) => ({ name, description: text.anglesAre[name] ?? '' })));

  /** @param {import('phiz').Face} of */
  function anglesIn(of) {
    rested.code = of.code;
    return angles.of(rested.positions);
  }
  function refresh() {
    if (!visible) return;
    const of = (/** @type {import('phiz').Face} */ one) => model.measures.map(({ name }) => one.measure(name));
    lengths.fill(of(face), of(reference));
    degrees.fill(anglesIn(face), anglesIn(reference));
  }
  function nameOf() {
    return list.select.selectedOptions[0]?.textContent ?? '';
  }
  function load() {
    const { value } = list.select;
    const kept = library.find(value);
    // The average has no colours of its own, as what was saved before those were kept.
    looks = kept ? { colours: kept.colouring, worn: false } : value === 'start' ? start.looks : {};
    if (value === 'average') reference.code = average.code;
    else reference.code = kept?.code ?? start.code;
  }
  function applySplit() {
    const on = split.checked;
    divider.hidden = endSplit.hidden = !on;
    for (const part of [divider, endSplit]) part.style.setProperty('--at', String(line));
    divider.setAttribute('aria-valuenow', String(Math.round(100 * line)));
    name();
    stage.classList.toggle('is-split', on);
    display.split(on ? reference : null, line, looks);
  }
  function applyHeat() {
    bar.hidden = !heat.checked;
    name();
    display.heat(heat.checked ? reference : null);
  }
  async function applyOutline() {
    key.hidden = !outline.checked;
    name();
    try {
      await display.outline(outline.checked ? reference : null);
    } catch (error) {
      outline.checked = false;
      key.hidden = true;
      say(error instanceof Error ? error.message : String(error));
    }
  }
  function changed() {
    load();
    if (split.checked) applySplit();
    if (outline.checked) void applyOutline();
    if (heat.checked) applyHeat();
    refresh();
  }
  load();
  editor.onShape(refresh);
  function name() {
    leftName.textContent = nameOf();
    outlineName.textContent = nameOf();
    bar.firstElementChild?.replaceChildren(text.distanceFrom(nameOf()));
  }
  library.onChange(name);

  const isBeside = () => split.checked || outline.checked || heat.checked;

  const root = element(
    'div',
    {},
    element(
      'div',
      { class: 'scroll' },
      list.root,
      element('p', { class: 'note' }, startNow),
      hold,
      element('label', { class: 'check' }, split, text.split),
      element('label', { class: 'check' }, outline, text.outline),
      element('label', { class: 'check' }, heat, text.heat),
      element('p', { class: 'note' }, text.heatAbout),
      lengths.root,
      degrees.root,
    ),
  );
  return {
    root,
    /** What a picture of the stage has to say, as the stage does; null when it shows this face alone. @returns {import('../keep/legend.js').Legend | null} */
    get legend() {
      if (!isBeside()) return null;
      const other = nameOf();
      return {
        other,
        outline: outline.checked ? other : null,
        split: split.checked ? { aside: ((line - 0.5) * stage.clientWidth) / stage.clientHeight, left: other, right: text.thisFace } : null,
        heat: heat.checked ? { title: text.distanceFrom(other), least: '0', most: scaleEnd.textContent ?? '' } : null,
      };
    },
    /** Who is on the stage beside this face, or as a distance from it; null when it is there alone. */
    get other() {
      if (!isBeside()) return null;
      return { name: nameOf(), lengthOf: (/** @type {string} */ measure) => reference.measure(measure) };
    },
    /** @param {number} millimetres */
    setScale(millimetres) {
      scaleEnd.textContent = `≥ ${millimetres} mm`;
    },
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      refresh();
    },
  };
}
