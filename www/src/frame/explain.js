import { element } from './element.js';
import { icon } from './icons.js';
import { ordinal, spoken, tapping, text } from '../text.js';

/**
 * Says beside the face what is happening: what the present section does, and what was just done.
 * @param {import('../editing/editor.js').Editor} editor
 */
export function createExplanation({ face, model, onStep }) {
  let section = '';
  const lengths = new Set(model.controls.filter((control) => control.measure).map((control) => control.name));
  let seen = new Map(model.controls.map(({ name }) => [name, face.get(name)]));
  const moved = element('p', { class: 'moved', 'aria-live': 'polite' });
  const words = element('div', {});
  const open = element(
    'button',
    {
      type: 'button',
      class: 'tool explain-open',
      'aria-label': text.happening,
      'aria-expanded': 'false',
      'aria-controls': 'explanation',
      title: text.happening,
      onclick: () => toggle(root.hidden !== false),
    },
    icon('info'),
  );
  const root = element(
    'aside',
    {
      id: 'explanation',
      class: 'explanation',
      hidden: true,
      'aria-label': text.happening,
      onkeydown: (/** @type {KeyboardEvent} */ event) => event.key === 'Escape' && toggle(false),
    },
    element(
      'header',
      {},
      element('h2', {}, text.happening),
      element('button', { type: 'button', class: 'tool', 'aria-label': text.closeHappening, onclick: () => toggle(false) }, icon('close')),
    ),
    moved,
    words,
  );
  /** @param {boolean} now */
  function toggle(now) {
    root.hidden = !now;
    open.setAttribute('aria-expanded', String(now));
    if (now) root.querySelector('button')?.focus();
    else open.focus();
  }

  onStep(() => {
    const now = new Map(model.controls.map(({ name }) => [name, face.get(name)]));
    const changed = [...now].filter(([name, value]) => Math.abs(value - (seen.get(name) ?? value)) > 0.005);
    const before = seen;
    seen = now;
    moved.textContent = '';
    // An eigenmesh changes lengths with it; a length, being an edit on top, no eigenmesh.
    const shapes = changed.filter(([name]) => !lengths.has(name));
    const step = (/** @type {[string, number]} */ [name, value]) => Math.abs(value - (before.get(name) ?? value));
    const one = shapes.length ? shapes : changed.sort((a, b) => step(b) - step(a)).slice(0, 1);
    if (one.length === 1) {
      const [name, value] = [spoken(one[0][0]), one[0][1]];
      const atEnd = value <= 0 || value >= 1;
      moved.textContent = atEnd ? text.explainEnd(name) : text.explainMoved(name, ordinal(value), Math.round(10 * value));
    }
  });

  return {
    root,
    open,
    /** @param {string} name of the panel's section */
    about(name) {
      if (name === section) return;
      section = name;
      const labels = name === 'features' && model.attributes.length ? text.explainLabels : [];
      words.replaceChildren(...[...(text.explain[name] ?? []), ...labels].map((paragraph) => element('p', {}, tapping(paragraph))));
    },
  };
}
