/**
 * The models that come with the page, by the name that `?model=` takes: the file, the file of the
 * median face alone, which shows first, and that of the expressions.
 * @type {Readonly<Record<string, { file: string, head?: string, expressions?: string }>>}
 */
const MODELS = {
  people: { file: 'model.phiz', head: 'head.phiz', expressions: 'expressions.phiz' },
  synthetic: { file: 'synthetic.phiz' },
};

/** The names, the default's first. */
export const modelNames = Object.keys(MODELS);

/** The model that the page's address asks for: its name, its files, and whether there is one. */
export function chosenModel() {
  const asked = new URLSearchParams(location.search).get('model') ?? modelNames[0];
  const known = Object.hasOwn(MODELS, asked);
  const name = known ? asked : modelNames[0];
  const { file, head, expressions } = MODELS[name];
  const at = (/** @type {string} */ path) => new URL(path, document.baseURI);
  return { name, known, url: at(file), head: head ? at(head) : null, expressions: expressions ? at(expressions) : null };
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
