import { encodeColouring, encodeExpression } from './addresscode.js';
import { locksOf, readLocks } from './locks.js';
import { readExpression } from '../head/expression.js';
import { keep, recall } from '../store.js';
import { text } from '../text.js';

/**
 * Keeps the face in the browser after every step.
 * @param {string} modelName
 */
export function createAutosave(modelName) {
  // Another site on this origin may have another model of that name.
  const key = `phiz-face-${modelName}-${new URL('.', document.baseURI).pathname}`;
  return {
    /** The face of the last visit. */
    last() {
      // Earlier versions kept it for all of an origin.
      const kept = /** @type {any} */ (recall(key) ?? recall(`phiz-face-${modelName}`));
      if (!kept || typeof kept.code !== 'string') return null;
      /** @param {unknown} value */
      const words = (value) => (typeof value === 'string' ? value : '');
      return {
        code: kept.code,
        ...readLocks(kept),
        expression: words(kept.expression),
        /** The same, which is also read where there are no expressions; undefined of a visit to an earlier version. */
        shown: readExpression(kept.shown),
        colouring: words(kept.colouring),
        when: typeof kept.when === 'number' ? kept.when : null,
      };
    },
    /** @param {import('../editing/editor.js').Editor} editor @param {(sentence: string) => void} say */
    follow(editor, say) {
      const { face, model } = editor;
      let isTold = false;
      const store = () => {
        const expression = editor.awaited || encodeExpression(model.expressions, face.expression);
        const shown = editor.awaited ? undefined : readExpression(face.expression);
        const colouring = encodeColouring(editor.colouring);
        const isKept = keep(key, { code: face.code, ...locksOf(face), expression, shown, colouring, when: Date.now() });
        if (!isKept && !isTold) say(text.notKept);
        isTold ||= !isKept;
      };
      editor.onStep(store);
      // Something may have been done before anybody followed.
      if (editor.canUndo) store();
    },
  };
}
