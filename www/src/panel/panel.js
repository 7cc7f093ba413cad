import { element } from '../frame/element.js';
import { fading, reveal } from '../frame/fading.js';

/**
 * The panel: one section at a time, chosen by tabs.
 *
 * @param {string} label
 * @param {(section: string) => void} changed
 * @param {{ name: string, title: string, root: HTMLElement, shown?: (visible: boolean) => void }[]} sections
 */
export function createPanel(label, changed, sections) {
  const tabs = sections.map(({ name, title }, i) =>
    element(
      'button',
      {
        type: 'button',
        class: 'mode',
        role: 'tab',
        id: `mode-${name}`,
        'aria-controls': `section-${name}`,
        onclick: () => choose(name),
        onkeydown: (/** @type {KeyboardEvent} */ event) => {
          const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
          if (!step) return;
          event.preventDefault();
          const next = (i + step + sections.length) % sections.length;
          choose(sections[next].name);
          tabs[next].focus();
        },
      },
      title,
    ),
  );
  let chosen = '';

  /** @param {string} name */
  function choose(name) {
    if (name === chosen || !sections.some((section) => section.name === name)) return;
    const before = sections.find((section) => section.name === chosen);
    chosen = name;
    sections.forEach(({ root }, i) => {
      const present = sections[i].name === name;
      root.hidden = !present;
      tabs[i].setAttribute('aria-selected', String(present));
      tabs[i].tabIndex = present ? 0 : -1;
      // On a phone they do not all fit.
      if (present) reveal(tabs[i]);
    });
    before?.shown?.(false);
    sections.find((section) => section.name === name)?.shown?.(true);
    changed(name);
  }

  for (const { name, root } of sections) {
    root.id = `section-${name}`;
    root.setAttribute('role', 'tabpanel');
    root.setAttribute('aria-labelledby', `mode-${name}`);
    root.classList.add('section');
  }
  const root = element(
    'aside',
    { class: 'panel', 'aria-label': label },
    fading(element('div', { class: 'modes', role: 'tablist', 'aria-label': label }, ...tabs), () => tabs.find((_, i) => sections[i].name === chosen)),
    ...sections.map((section) => section.root),
  );
  choose(sections[0].name);
  return {
    root,
    choose,
    get chosen() {
      return chosen;
    },
  };
}
