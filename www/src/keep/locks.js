// What of a face is locked, which no code of a face says: beside it in what the browser keeps, and beside the address in
// the tab's own history.

/** @typedef {{ locked: string[], held: string[] }} Locks regions, and measures */

/** @param {import('phiz').Face} face @returns {Locks} */
export const locksOf = (face) => ({ locked: [...face.locked], held: [...face.lockedMeasures] });

/** @param {unknown} kept @returns {Locks} what can be read of them */
export function readLocks(kept) {
  const { locked, held } = /** @type {Record<string, unknown>} */ (Object(kept));
  /** @param {unknown} list @returns {string[]} */
  const names = (list) => (Array.isArray(list) ? list.filter((name) => typeof name === 'string') : []);
  return { locked: names(locked), held: names(held) };
}

/** @param {import('phiz').Face} face @param {Locks} locks those that another model had are left out */
export function lockAgain(face, { locked, held }) {
  const { regions, measures } = face.model;
  for (const region of locked) if (regions.includes(region)) face.lock(region);
  for (const { name } of measures) if (held.includes(name)) face.lockMeasure(name);
}
