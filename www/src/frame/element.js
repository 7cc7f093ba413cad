/**
 * Makes an element: `element('button', { class: 'tool', onclick }, 'Undo')`. A value that is a
 * function listens; `true` sets an empty attribute, `false` and null none.
 *
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, any>} [attributes]
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

/**
 * What an element says, which is laid out again only if it is something else.
 * @param {HTMLElement} where @param {string} words
 */
export function say(where, words) {
  if (where.textContent !== words) where.textContent = words;
}
