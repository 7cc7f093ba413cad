import { element, say } from '../frame/element.js';
import { meant, spoken, text } from '../text.js';

/** Which measures belong to which feature, by the words in their names; the rest are the head's. */
const WORDS = /** @type {const} */ ([
  ['eyes', /\b(eye|brow)/],
  ['nose', /\bnose/],
  ['mouth', /\b(mouth|lip)/],
  ['chin', /\bchin/],
  ['forehead', /\bforehead/],
]);

/** @param {string} measure */
export function groupOfMeasure(measure) {
  return WORDS.find(([, words]) => words.test(measure))?.[0] ?? 'head';
}

/**
 * Lengths of the face, those of one feature at a time, and what a gesture does to them.
 * @param {import('phiz').FaceModel} model
 * @param {import('phiz').Face} face
 */
export function createMeasures(model, face) {
  const root = element('dl', { class: 'measures', 'aria-label': text.measures });
  /** @type {{ name: string, value: HTMLElement, change: HTMLElement }[]} */
  let rows = [];
  /** @type {Map<string, number> | null} */
  let before = null;

  function refresh() {
    for (const { name, value, change } of rows) {
      const mm = face.measure(name);
      const was = before?.get(name) ?? mm;
      const differs = Math.abs(mm - was) >= 0.05;
      say(value, text.millimetres(mm));
      say(change, differs ? text.change(mm - was) : '');
    }
  }

  return {
    root,
    refresh,
    /** @param {string} group */
    choose(group) {
      rows = [];
      root.replaceChildren(
        ...model.measures
          .filter(({ name }) => groupOfMeasure(name) === group)
          .map((measure) => {
            const { name } = measure;
            const value = element('span', {});
            const change = element('span', { class: 'change' });
            rows.push({ name, value, change });
            return element('div', { title: meant(measure) }, element('dt', {}, spoken(name)), element('dd', {}, change, value));
          }),
      );
      root.hidden = rows.length === 0;
      refresh();
    },
    /** A gesture starts: what changes from here on is shown. */
    hold() {
      before = new Map(rows.map(({ name }) => [name, face.measure(name)]));
    },
    release() {
      before = null;
      refresh();
    },
  };
}
