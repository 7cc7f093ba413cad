/**
 * A map of what was wanted last: of more than `most` the one is forgotten that was wanted longest ago.
 * @template T
 * @param {number} most
 */
export function createRemembered(most) {
  /** @type {Map<string, T>} in the order of when each was wanted */
  const kept = new Map();
  /** @param {string} key @param {T} value */
  function set(key, value) {
    kept.delete(key);
    kept.set(key, value);
    const [oldest] = kept.keys();
    if (kept.size > most) kept.delete(oldest);
  }
  return {
    set,
    /** @param {string} key */
    get(key) {
      const value = kept.get(key);
      if (value !== undefined) set(key, value);
      return value;
    },
    clear: () => kept.clear(),
  };
}
