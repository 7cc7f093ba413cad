import { encodeColouring, encodeExpression } from './addresscode.js';
import { locksOf, readLocks } from './locks.js';
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
      /** @param {unknown} value */
      const words = (value) => (typeof value === 'string' ? value : '');
      return {
        code: kept.code,
        ...readLocks(kept),
        expression: words(kept.expression),
        colouring: words(kept.colouring),
      };
    },
    /** @param {import('../editing/editor.js').Editor} editor */
    follow(editor) {
      const { face, model } = editor;
      const store = () => {
        const expression = editor.awaited || encodeExpression(model.expressions, face.expression);
        const colouring = encodeColouring(editor.colouring);
        keep(key, { code: face.code, ...locksOf(face), expression, colouring });
      };
      editor.onStep(store);
      // Something may have been done before anybody followed.
      if (editor.canUndo) store();
    },
  };
}
