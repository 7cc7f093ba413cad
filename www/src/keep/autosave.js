import { encodeColouring, encodeExpression } from './addresscode.js';
import { locksOf, readLocks } from './locks.js';
import { nameTab } from './present.js';
import { readExpression } from '../head/expression.js';
import { forget, keep, keptUnder, recall } from '../store.js';
import { text } from '../text.js';

/**
 * Keeps the face in the browser after every step: what was worked on last, and beside it what each tab did.
 * @param {string} modelName
 */
export function createAutosave(modelName) {
  // Another site on this origin may have another model of that name.
  const where = `${modelName}-${new URL('.', document.baseURI).pathname}`;
  const key = `phiz-face-${where}`;
  const ofTabs = `phiz-tab-${where}-`;
  const naming = nameTab(ofTabs);
  /** Where this tab keeps its own, once it has a name. @type {string | null} */
  let own = null;
  /** @param {any} kept */
  function read(kept) {
    if (!kept || typeof kept.code !== 'string') return null;
    /** @param {unknown} value */
    const words = (value) => (typeof value === 'string' ? value : '');
    return {
      code: /** @type {string} */ (kept.code),
      ...readLocks(kept),
      expression: words(kept.expression),
      /** The same, which is also read where there are no expressions; undefined of a visit to an earlier version. */
      shown: readExpression(kept.shown),
      colouring: words(kept.colouring),
      when: typeof kept.when === 'number' ? kept.when : null,
    };
  }
  return {
    /** The face of the last visit. Earlier versions kept it for all of an origin. */
    last: () => read(recall(key) ?? recall(`phiz-face-${modelName}`)),
    /** What tabs worked on that are closed: of two, what was worked on last is one's alone. `settle` is for when it is safe. */
    async closed() {
      const tab = await naming;
      own = tab && tab.name;
      const present = await tab?.present().catch(() => null);
      if (!present) return [];
      return keptUnder(ofTabs)
        .filter((name) => name !== own && !present.has(name))
        .map((name) => ({ worked: read(recall(name)), settle: () => forget(name) }));
    },
    /** @param {import('../editing/editor.js').Editor} editor @param {(sentence: string) => void} say */
    follow(editor, say) {
      const { face, model } = editor;
      let isTold = false;
      const store = () => {
        const expression = editor.awaited || encodeExpression(model.expressions, face.expression);
        const shown = editor.awaited ? undefined : readExpression(face.expression);
        const colouring = encodeColouring(editor.colouring);
        const state = { code: face.code, ...locksOf(face), expression, shown, colouring, when: Date.now() };
        const isKept = keep(key, state);
        if (own) keep(own, state);
        if (!isKept && !isTold) say(text.notKept);
        isTold ||= !isKept;
      };
      editor.onStep(store);
      // Something may have been done before anybody followed.
      if (editor.canUndo) store();
    },
  };
}
