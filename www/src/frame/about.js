import { createDialog } from './dialog.js';
import { element } from './element.js';
import { addressOf, modelNames } from './models.js';
import { text } from '../text.js';

/**
 * A model in the list of them; the one that is shown is no link.
 * @param {string} name @param {string} present
 */
function entry(name, present) {
  const label = text.model[name];
  if (name === present) return element('strong', { 'aria-current': 'true' }, label);
  return element('a', { href: addressOf(name) }, label);
}

/**
 * The page explains itself: eigenmeshes, percentiles, and whose faces these are.
 * @param {import('phiz').FaceModel} model
 * @param {string} present the name of the model among those of the page
 * @param {() => void} tour shows the person around
 */
export function createAbout(model, present, tour) {
  const { about } = model;
  const dialog = createDialog(
    'about-title',
    text.aboutTitle,
    element(
      'button',
      {
        type: 'button',
        class: 'link',
        onclick: () => {
          dialog.close();
          tour();
        },
      },
      text.showAround,
    ),
    ...text.aboutBody.flatMap(([head, body]) => [element('h3', {}, head), element('p', {}, body)]),
    element('h3', {}, text.population),
    element('p', {}, about.population),
    ...(about.caveat ? [element('p', {}, about.caveat)] : []),
    element('p', {}, text.facesLearned(about.faces)),
    element(
      'p',
      { class: 'models' },
      text.models,
      ...modelNames.map((name) => entry(name, present)),
      ...(modelNames.includes(present) ? [] : [element('strong', { 'aria-current': 'true' }, about.title)]),
    ),
    element('h3', {}, text.madeFrom),
    element(
      'ul',
      {},
      ...about.licences.map(({ source, by, licence }) =>
        element('li', {}, `${source}, ${by} (${licence})`),
      ),
    ),
    element('p', { class: 'note' }, text.findsFaces),
    element('p', { class: 'note' }, `${about.title} · ${about.made_by}`),
  );
  return { root: dialog, show: () => dialog.showModal() };
}
