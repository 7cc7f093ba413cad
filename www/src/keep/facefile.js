import { readKept } from '../head/colouring.js';
import { Failure } from '../frame/failure.js';
import { readExpression } from '../head/expression.js';
import { text } from '../text.js';

// The file of a face: JSON with its code, its name, the model that it belongs to and, from version 2 on,
// its expression and, where it was kept, its colouring.

const FORMAT = 'phiz-face';
const VERSION = 2;
/** A face takes less than a kilobyte. */
const MOST = 100_000;

/**
 * @param {import('phiz').FaceModel} model @param {string} name
 * @param {import('./library.js').Likeness} face
 */
export function faceFile(model, name, { code, expression, colouring }) {
  const content = { format: FORMAT, version: VERSION, name, model: model.about.title, code, expression: readExpression(expression), colouring };
  return new Blob([`${JSON.stringify(content, null, 2)}\n`], { type: 'application/json' });
}

/**
 * @param {import('phiz').FaceModel} model @param {File} file
 * @returns {Promise<{ name: string } & import('./library.js').Likeness>}
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
  if (content?.format !== FORMAT || typeof content.code !== 'string') throw new Failure(text.fileForeign(file.name));
  if (content.version !== 1 && content.version !== VERSION) throw new Failure(text.fileVersion(file.name, String(content.version)));
  try {
    model.fromCode(content.code).free();
  } catch (error) {
    if (typeof content.model === 'string' && content.model !== model.about.title) {
      throw new Failure(text.fileOtherModel(file.name, content.model, model.about.title));
    }
    throw new Failure(text.fileBroken(file.name, error instanceof Error ? error.message : String(error)));
  }
  const name = typeof content.name === 'string' ? content.name.trim().slice(0, 60) : '';
  return { name: name || file.name.replace(/\.[^.]*$/, ''), code: content.code, expression: readExpression(content.expression), colouring: readKept(content.colouring) };
}
