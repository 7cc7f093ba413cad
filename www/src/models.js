/**
 * The models that come with the page: their files, by the name that `?model=` takes.
 * @type {Readonly<Record<string, string>>}
 */
const FILES = { people: 'model.phiz', synthetic: 'synthetic.phiz' };

/** The names, the default's first. */
export const modelNames = Object.keys(FILES);

/** The model that the page's address asks for: its name, its file, and whether there is one. */
export function chosenModel() {
  const asked = new URLSearchParams(location.search).get('model') ?? modelNames[0];
  const known = Object.hasOwn(FILES, asked);
  const name = known ? asked : modelNames[0];
  return { name, known, url: new URL(FILES[name], document.baseURI) };
}

/**
 * The address of the page with another model. Its faces have codes of their own, so none goes along.
 * @param {string} name
 */
export function addressOf(name) {
  const url = new URL(location.href);
  url.hash = '';
  url.searchParams.delete('model');
  if (name !== modelNames[0]) url.searchParams.set('model', name);
  return url.href;
}
