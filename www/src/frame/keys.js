/**
 * The letter that a key is pressed for: its own, or where a keyboard has others, such as Greek or Cyrillic ones, the one that stands there
 * on a Latin keyboard.
 * @param {KeyboardEvent} event
 */
export function letterOf({ key, code }) {
  return (/^[a-z]$/i.test(key) ? key : code.replace(/^Key/, '')).toLowerCase();
}
