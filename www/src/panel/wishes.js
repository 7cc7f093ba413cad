import { element } from '../frame/element.js';
import { text } from '../text.js';

/** Labels that are shares of one whole: one choice for all of them. */
export const ETHNICITY = ['african', 'asian', 'caucasian'];
/** From young adults on, in years. */
const AGES = [20, 30, 40, 50, 60, 70, 80];
export const ORDER = ['sex', 'age', 'ethnicity', 'weight'];

/**
 * What random faces should be like, where the model knows labels: a choice for each, `any` to begin
 * with. `root` is null for a model without labels.
 *
 * @param {import('phiz').FaceModel} model
 */
export function createWishes(model) {
  /** @typedef {{ words: string, values: Record<string, number> }} Choice */
  /** @type {Map<string, Choice[]>} */
  const offered = new Map();
  const shares = model.attributes.filter(({ name }) => ETHNICITY.includes(name));
  for (const { name, limits } of model.attributes) {
    const [least, most] = limits;
    const at = (/** @type {number} */ value) => ({ [name]: Math.min(most, Math.max(least, value)) });
    if (ETHNICITY.includes(name)) {
      const others = shares.map((share) => [share.name, share.limits[share.name === name ? 1 : 0]]);
      const choices = offered.get('ethnicity') ?? [];
      offered.set('ethnicity', [...choices, { words: text.wishes.ethnicities[name], values: Object.fromEntries(others) }]);
    } else if (name === 'age') {
      const inReach = AGES.filter((years) => years > least - 5 && years < most + 5);
      offered.set(name, inReach.map((years) => ({ words: text.wishes.years(years), values: at(years) })));
    } else {
      const words = text.wishes.levels[name] ?? text.wishes.levels.other;
      const level = (/** @type {number} */ i) => least + (i / (words.length - 1)) * (most - least);
      offered.set(name, words.map((word, i) => ({ words: word, values: at(level(i)) })));
    }
  }
  const names = [...offered.keys()].sort((a, b) => (ORDER.indexOf(a) + 1 || 99) - (ORDER.indexOf(b) + 1 || 99));
  const rows = names.map((name) => {
    const choices = offered.get(name) ?? [];
    const select = element(
      'select',
      { id: `wish-${name}`, 'aria-describedby': 'wishes-about', onchange: show },
      element('option', { value: '' }, text.wishes.any),
      ...choices.map(({ words }, i) => element('option', { value: i }, words)),
    );
    const row = element('div', { class: 'wish' }, element('label', { for: select.id }, text.wishes.names[name] ?? name), select);
    return { row, select, choices };
  });
  const clear = element(
    'button',
    {
      type: 'button',
      class: 'quiet',
      hidden: true,
      onclick: () => {
        for (const { select } of rows) select.value = '';
        show();
        rows[0].select.focus();
      },
    },
    text.wishes.clear,
  );
  function show() {
    clear.hidden = rows.every(({ select }) => select.value === '');
  }

  return {
    root: rows.length
      ? element(
          'div',
          { class: 'wishes', role: 'group', 'aria-label': text.wishes.title },
          ...rows.map(({ row }) => row),
          element('p', { class: 'about', id: 'wishes-about' }, text.wishes.about),
          clear,
        )
      : null,
    /** What `randomize` takes. @returns {Record<string, number>} */
    get attributes() {
      const chosen = rows.map(({ select, choices }) => (select.value === '' ? {} : choices[Number(select.value)].values));
      return Object.assign({}, ...chosen);
    },
  };
}
