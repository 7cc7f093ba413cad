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

const at = (/** @type {string} */ path) => new URL(path, document.baseURI);

/**
 * A file of the page's own site; null where it is another's, or none.
 * @param {string | null} path
 */
function ownFile(path) {
  if (!path?.endsWith('.phiz') || !URL.canParse(path, document.baseURI)) return null;
  const url = at(path);
  return url.origin === location.origin ? url : null;
}

/**
 * The model that the page's address asks for: its name, its files, and whether there is one. One that does not come with the page
 * is a file of the same site, `?model=ours.phiz`, with its expressions, if it has any, in `&expressions=ours-expressions.phiz`.
 */
export function chosenModel() {
  const given = new URLSearchParams(location.search);
  const asked = given.get('model') ?? modelNames[0];
  const own = ownFile(asked);
  if (own) return { name: asked, known: true, url: own, head: null, expressions: ownFile(given.get('expressions')) };
  const known = Object.hasOwn(MODELS, asked);
  const name = known ? asked : modelNames[0];
  const { file, head, expressions } = MODELS[name];
  return { name, known, url: at(file), head: head ? at(head) : null, expressions: expressions ? at(expressions) : null };
}

/**
 * The address of the page with another model. Its faces have codes of their own, so none goes along.
 * @param {string} name
 */
export function addressOf(name) {
  const url = new URL(location.href);
  url.hash = '';
  for (const given of ['model', 'expressions']) url.searchParams.delete(given);
  if (name !== modelNames[0]) url.searchParams.set('model', name);
  return url.href;
}
