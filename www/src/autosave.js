import { keep, recall } from './store.js';

/**
 * Keeps the face in the browser after every step.
 * @param {string} modelName
 */
export function createAutosave(modelName) {
  const key = `phiz-face-${modelName}`;
  return {
    /** @returns {{ code: string, locked: string[], held: string[] } | null} the face of the last visit */
    last() {
      const kept = /** @type {any} */ (recall(key));
      if (!kept || typeof kept.code !== 'string') return null;
      /** @param {unknown} list */
      const names = (list) => (Array.isArray(list) ? list.filter((name) => typeof name === 'string') : []);
      return { code: kept.code, locked: names(kept.locked), held: names(kept.held) };
    },
    /** @param {import('./editor.js').Editor} editor */
    follow({ face, onStep }) {
      onStep(() => void keep(key, { code: face.code, locked: face.locked, held: face.lockedMeasures ?? [] }));
    },
  };
}
