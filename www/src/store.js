// What the browser keeps, as JSON by name. Storage may be forbidden or full: then nothing is kept,
// and whoever writes is told.

/**
 * @param {string} key
 * @returns {unknown} null when there is nothing, or nothing that can be read
 */
export function recall(key) {
  try {
    const kept = localStorage.getItem(key);
    return kept === null ? null : JSON.parse(kept);
  } catch {
    return null;
  }
}

/**
 * @param {string} key @param {unknown} value
 * @returns {boolean} whether it is kept
 */
export function keep(key, value) {
  try {
    localStorage.setItem(key, JSON.stringify(value));
    return true;
  } catch {
    return false;
  }
}

/** @param {string} start @returns {string[]} the keys of what is kept that begin so */
export function keptUnder(start) {
  try {
    return Object.keys(localStorage).filter((key) => key.startsWith(start));
  } catch {
    return [];
  }
}

/** @param {string} key */
export function forget(key) {
  try {
    localStorage.removeItem(key);
  } catch {
    // What nobody can read is as good as gone.
  }
}
