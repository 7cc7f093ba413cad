import { createAlike } from './alike.js';
import { element } from '../frame/element.js';
import { createSlider } from './slider.js';
import { someone } from '../head/someone.js';
import { text, titleOf } from '../text.js';
import { createWishes } from './wishes.js';

/**
 * Random faces: what they should be like, how unusual they are, and the seed that gives one again.
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   library: import('../keep/library.js').Library,
 *   portraits: import('../stage/portraits.js').Portraits,
 *   say: (sentence: string) => void,
 * }} parts
 */
export function createRandom(editor, { library, portraits, say }) {
  let spread = 1;
  const wishes = createWishes(editor.model);
  const amount = createSlider({
    name: text.spread,
    label: text.spread,
    id: 'spread',
    about: text.spreadAbout,
    limits: [0.1, 2],
    step: 0.05,
    key: 0.05,
    neutral: 1,
    words: (value) => text.unusual(value),
    typed: {
      label: text.spread,
      unit: '',
      min: 0.1,
      max: 2,
      step: 0.05,
      show: (value) => Number(value.toFixed(2)),
      take: (value) => setSpread(value),
    },
    move: setSpread,
    finish: () => {},
  });
  /** @param {number} value */
  function setSpread(value) {
    spread = value;
    amount.show(spread);
  }
  amount.show(spread);

  const seed = element('input', { type: 'number', id: 'seed', min: 0, step: 1, inputmode: 'numeric' });
  const again = element(
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
  );

  /** @param {string[]} [regions] @param {number} [withSeed] */
  function randomise(regions, withSeed) {
    const kept = regions?.find((region) => editor.face.locked.includes(region));
    if (kept !== undefined) return say(text.lockedAgainst(titleOf(kept).toLowerCase()));
    /** @type {import('../editing/editor.js').Chance} */
    const options = { spread, attributes: wishes.attributes };
    if (regions) options.regions = regions;
    if (withSeed !== undefined) options.seed = withSeed;
    const used = editor.randomise(options, dressed.checked && !regions ? (drawn) => someone(editor.face, drawn) : undefined);
    if (used === undefined) return;
    // Of a feature alone it says nothing: with it all of the face would be another.
    if (regions) return say(text.randomiseFeature(regions.map((region) => titleOf(region).toLowerCase()).join(', ')));
    seed.value = String(used);
    const { locked, lockedMeasures } = editor.face;
    say(locked.length + lockedMeasures.length > 0 ? text.randomisedRest(used, locked.length > 0) : text.randomised(used));
  }

  const dressed = element('input', { type: 'checkbox', id: 'random-colours', checked: true });
  const colours = element('label', { class: 'check', for: dressed.id }, dressed, text.randomColours);
  const coloursStay = element('p', { class: 'note', hidden: true }, text.coloursLocked);
  function refresh() {
    const stay = editor.face.locked.length > 0;
    dressed.disabled = stay;
    coloursStay.hidden = !stay;
  }
  editor.onShape(refresh);
  refresh();

  const alike = createAlike(editor, { library, portraits, say, spread: () => spread });
  const root = element('section', { class: 'part' }, element('h3', {}, text.randomFaces));
  if (wishes.root) {
    // The toolbar has a button of this kind; on a phone it is far from here.
    const draw = element('button', { type: 'button', class: 'button', onclick: () => randomise() }, text.wishes.draw);
    root.append(wishes.root, amount.root, colours, coloursStay, element('div', { class: 'row' }, draw, alike.button));
  } else {
    root.append(amount.root, colours, coloursStay, element('div', { class: 'row' }, alike.button));
  }
  root.append(alike.root);

  return { root, again, randomise };
}
