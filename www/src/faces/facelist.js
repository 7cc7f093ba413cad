import { element } from '../frame/element.js';

/**
 * A list to choose a face from: some that the caller names, then those of the library.
 * @param {import('../keep/library.js').Library} library
 * @param {{ id: string, label: string, first: { id: string, name: string }[], onchange: () => void }} spec
 */
export function createFaceList(library, { id, label, first, onchange }) {
  const select = element('select', { id, onchange });
  function build() {
    const value = select.value;
    select.replaceChildren(...[...first, ...library.all].map((entry) => element('option', { value: entry.id }, entry.name)));
    if ([...select.options].some((option) => option.value === value)) select.value = value;
    else if (value) onchange();
  }
  build();
  library.onChange(build);
  return { root: element('div', { class: 'field' }, element('label', { for: id }, label), select), select };
}
