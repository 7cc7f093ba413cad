import { createCaricature } from './caricature.js';
import { createCircle } from './circle.js';
import { mixture } from '../head/colouring.js';
import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { shows } from '../head/expression.js';
import { createMorph } from './morph.js';
import { createSlider } from '../panel/slider.js';
import { createTray } from './tray.js';
import { tapping, text, titleOf } from '../text.js';

/**
 * Other faces and what they lend to this one: a feature, an amount, a place between several, or
 * a way from one to another.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   groups: string[],
 *   limits: import('../panel/limits.js').Limits,
 *   library: import('../keep/library.js').Library,
 *   portraits: import('../stage/portraits.js').Portraits,
 *   display: import('../stage/display.js').Display,
 *   canvas: HTMLCanvasElement,
 *   groupUnder: (event: PointerEvent) => string | null,
 *   preview: (group: string | null) => void,
 *   wearsPhoto: () => boolean,
 *   reveal: () => void,
 *   say: (sentence: string) => void,
 * }} parts
 */
export function createMix(editor, { groups, limits, library, portraits, display, canvas, groupUnder, preview, wearsPhoto, reveal, say }) {
  const { model, face } = editor;
  // The chosen face, as a face.
  const other = model.face();
  /** @type {import('../keep/library.js').Entry | null} */
  let chosen = null;
  /** Where the amount counts from. @type {import('../editing/history.js').State | null} */
  let base = null;
  let amount = 0;
  let ownStep = false;

  /** @param {string} group @param {string} name */
  const where = (group, name) => (group === '' ? text.tookAll(name) : text.took(titleOf(group).toLowerCase(), name));

  /** @param {import('../keep/library.js').Entry} entry @param {string} group */
  function takeOver(entry, group) {
    if (group !== '' && face.locked.includes(group)) return say(text.lockedAgainst(titleOf(group).toLowerCase()));
    other.code = entry.code;
    const became = editor.become(other, group === '' ? { colours: entry.colouring } : { regions: [group] });
    if (became) say(where(group, entry.name));
  }

  const tray = createTray({
    library,
    portraits,
    groupUnder,
    preview,
    choose,
    drop: (entry, group) => takeOver(entry, group),
  });

  const heading = element('h3', {});
  const portrait = element('span', { class: 'chosen-portrait' });
  const aside = element('p', { class: 'note', hidden: true }, text.expressionStays);
  const region = element(
    'select',
    { id: 'mix-region', onchange: start },
    element('option', { value: '' }, text.wholeFace),
    ...groups.map((group) => element('option', { value: group }, titleOf(group))),
  );
  const slider = createSlider({
    name: text.amount,
    label: text.amount,
    id: 'mix-amount',
    about: text.amountAbout,
    limits: [0, 100],
    step: 1,
    key: 1,
    neutral: 0,
    words: text.percent,
    typed: {
      label: text.amountTyped,
      unit: '%',
      min: 0,
      max: 100,
      step: 1,
      show: (value) => Math.round(value),
      take: (value) => {
        towards(value);
        finish();
      },
    },
    move: towards,
    finish,
  });
  function finish() {
    ownStep = true;
    editor.finish(`amount ${chosen?.id} ${region.value}`);
    ownStep = false;
  }
  /** @param {number} percent */
  function towards(percent) {
    if (!chosen) return;
    if (face.locked.includes(region.value)) {
      say(text.lockedAgainst(titleOf(region.value).toLowerCase()));
      return slider.show(amount);
    }
    other.code = chosen.code;
    base ??= editor.state;
    amount = percent;
    const t = percent / 100;
    // A feature has no colours of its own.
    const colours = region.value || !chosen.colouring ? base.colouring : mixture([[base.colouring, 1 - t], [chosen.colouring, t]]);
    editor.moveFrom(base, (present) => present.blend(other, t, region.value ? { regions: [region.value] } : {}), colours);
    slider.show(amount);
  }
  /** Whatever comes next counts from the face as it is now. */
  function start() {
    base = null;
    amount = 0;
    slider.show(0);
  }
  editor.onStep(() => {
    if (!ownStep && base) start();
  });

  const take = element('button', { type: 'button', class: 'button', onclick: () => chosen && takeOver(chosen, region.value) }, text.takeOver);
  const encircle = element('button', { type: 'button', class: 'button', onclick: () => chosen && circle.add(chosen) }, icon('plus'), text.intoCircle);
  // Its slider says itself what it does.
  const detailHead = element('div', { class: 'chosen-head', 'aria-live': 'polite' }, portrait, element('div', {}, heading, element('p', { class: 'note' }, text.chosenAbout), aside));
  const detail = element(
    'section',
    { class: 'part chosen', hidden: true },
    detailHead,
    element('div', { class: 'field' }, element('label', { for: 'mix-region' }, text.where), region),
    slider.root,
    element('div', { class: 'row' }, take, encircle),
  );
  const nobody = element('p', { class: 'note' }, tapping(text.trayAbout));

  /** @param {import('../keep/library.js').Entry | null} entry */
  function choose(entry) {
    chosen = entry;
    tray.mark(entry);
    detail.hidden = !entry;
    nobody.hidden = Boolean(entry);
    if (entry) {
      heading.textContent = entry.name;
      aside.hidden = !shows(entry.expression);
      portrait.replaceChildren(portraits.of(entry));
      // Where the tray fills what is in sight, nothing would be seen to happen.
      detailHead.scrollIntoView({ block: 'nearest' });
    }
    start();
  }

  library.onChange(() => {
    const now = chosen && library.find(chosen.id);
    if (!now) return;
    chosen = now;
    heading.textContent = now.name;
  });

  const caricature = createCaricature(editor, limits);
  const circle = createCircle(editor, { library, portraits, say });
  const morph = createMorph(editor, { library, display, canvas, wearsPhoto, reveal, say });

  const root = element(
    'div',
    { class: 'mix' },
    element(
      'div',
      { class: 'scroll' },
      element(
        'div',
        { class: 'feature-head' },
        element('h2', {}, text.tray),
        element(
          'button',
          {
            type: 'button',
            class: 'tool',
            'aria-label': text.addThis,
            title: text.addThis,
            onclick: () => {
              const name = library.freeName;
              say(library.add({ name, ...editor.likeness }) ? text.saved(name) : text.notKept);
            },
          },
          icon('plus'),
        ),
      ),
      tray.root,
      nobody,
      detail,
      caricature.root,
      circle.root,
      morph.root,
    ),
  );
  return {
    root,
    /** @param {boolean} now */
    shown(now) {
      tray.shown(now);
      if (!now) morph.leave();
    },
  };
}
