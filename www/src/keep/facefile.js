import { readKept } from '../head/colouring.js';
import { Failure } from '../frame/failure.js';
import { readExpression } from '../head/expression.js';
import { text } from '../text.js';

// The file of a face: JSON with its code, its name, the model that it belongs to and, from version 2 on,
// its expression and, where it was kept, its colouring. A list of those is a file of several.

const FORMAT = 'phiz-face';
const VERSION = 2;
/** A face takes a kilobyte or two, and a browser that keeps as many as it can has thousands. */
const MOST = 20_000_000;

/** @typedef {{ name: string } & import('./library.js').Likeness} Named */

/** @param {string | undefined} model its title @param {Named} face */
const contentOf = (model, { name, code, expression, colouring }) => ({
  format: FORMAT,
  version: VERSION,
  name,
  model,
  code,
  expression: readExpression(expression),
  colouring,
});

/** @param {unknown} content */
const written = (content) => new Blob([`${JSON.stringify(content, null, 2)}\n`], { type: 'application/json' });

/** @param {import('phiz').FaceModel} model @param {Named} face */
export const faceFile = (model, face) => written(contentOf(model.about.title, face));

/**
 * @param {import('phiz').FaceModel} model
 * @param {readonly Named[]} faces @param {readonly unknown[]} unread what the browser keeps of other models, whose titles it does not know
 */
export const facesFile = (model, faces, unread) =>
  written([...faces.map((face) => contentOf(model.about.title, face)), ...unread.map((other) => contentOf(undefined, /** @type {Named} */ (Object(other))))]);

/** @param {any} content */
const isNewer = (content) => content?.format === FORMAT && Number(content.version) > VERSION;

/**
 * @param {import('phiz').FaceModel} model @param {File} file
 * @returns {Promise<Named | { faces: Named[], unread: number, newer: number }>} one face, or of several those that are of this model, and how many
 *   others there are: of another model or damaged, or of a newer version of the page
 * @throws Failure with a sentence that names the file and what is wrong with it
 */
export async function readFaceFile(model, file) {
  if (file.size > MOST) throw new Failure(text.fileTooLong(file.name));
  /** @type {any} */
  let content;
  try {
    content = JSON.parse(await file.text());
  } catch {
    throw new Failure(text.fileForeign(file.name));
  }
  if (!Array.isArray(content)) return readFace(model, file, content);
  const read = content.map((one) => {
    try {
      return readFace(model, file, one);
    } catch {
      return null;
    }
  });
  if (!content.some((one) => one?.format === FORMAT)) throw new Failure(text.fileForeign(file.name));
  const faces = read.filter((one) => one !== null);
  const newer = content.filter(isNewer).length;
  return { faces, unread: read.length - faces.length - newer, newer };
}

/**
 * @param {import('phiz').FaceModel} model @param {File} file @param {any} content
 * @returns {Named}
 */
function readFace(model, file, content) {
  if (content?.format !== FORMAT || typeof content.code !== 'string') throw new Failure(text.fileForeign(file.name));
  if (isNewer(content)) throw new Failure(text.fileVersion(file.name, String(content.version)));
  if (content.version !== 1 && content.version !== VERSION) throw new Failure(text.fileBroken(file.name, text.noVersion));
  try {
    model.fromCode(content.code).free();
  } catch (error) {
    if (typeof content.model === 'string' && content.model !== model.about.title) {
      throw new Failure(text.fileOtherModel(file.name, content.model, model.about.title));
    }
    throw new Failure(text.fileBroken(file.name, error instanceof Error ? error.message : String(error)));
  }
  const name = typeof content.name === 'string' ? content.name.trim().slice(0, 60) : '';
  return { name: name || file.name.replace(/(\.phiz)?\.[^.]*$/i, '').slice(0, 60), code: content.code, expression: readExpression(content.expression), colouring: readKept(content.colouring) };
}
