import { encodeColouring, encodeExpression } from './addresscode.js';
import { keep, recall } from '../store.js';

/**
 * Keeps the face in the browser after every step.
 * @param {string} modelName
 */
export function createAutosave(modelName) {
  const key = `phiz-face-${modelName}`;
  return {
    /** @returns {{ code: string, locked: string[], held: string[], expression: string, colouring: string } | null} the face of the last visit */
    last() {
      const kept = /** @type {any} */ (recall(key));
      if (!kept || typeof kept.code !== 'string') return null;
      /** @param {unknown} list */
      const names = (list) => (Array.isArray(list) ? list.filter((name) => typeof name === 'string') : []);
      /** @param {unknown} value */
      const words = (value) => (typeof value === 'string' ? value : '');
      return {
        code: kept.code,
        locked: names(kept.locked),
        held: names(kept.held),
        expression: words(kept.expression),
        colouring: words(kept.colouring),
      };
    },
    /** @param {import('../editing/editor.js').Editor} editor */
    follow(editor) {
      const { face, model } = editor;
      editor.onStep(() => {
        const expression = editor.awaited || encodeExpression(model.expressions, face.expression);
        const colouring = encodeColouring(editor.colouring);
        keep(key, { code: face.code, locked: face.locked, held: face.lockedMeasures ?? [], expression, colouring });
      });
    },
  };
}
