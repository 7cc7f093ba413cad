/**
 * Whether a key is meant for what composes a word of several, as Japanese is typed. Safari says so by the code alone.
 * @param {KeyboardEvent} event
 */
export const isComposing = (event) => event.isComposing || event.keyCode === 229;

/**
 * Where a key takes a slider: whole steps, which a browser's own are not where a slider is finer than what it says.
 * @param {KeyboardEvent} event @param {number} present @param {number} step @param {readonly [number, number]} ends
 * @returns {number | null} within its ends; null for other keys
 */
export function steppedTo({ key, shiftKey }, present, step, [min, max]) {
  const far = 10 * step;
  const near = shiftKey ? far : step;
  /** @type {Record<string, number>} */
  const to = {
    ArrowLeft: present - near,
    ArrowDown: present - near,
    ArrowRight: present + near,
    ArrowUp: present + near,
    PageDown: present - far,
    PageUp: present + far,
    Home: min,
    End: max,
  };
  return Object.hasOwn(to, key) ? Math.min(max, Math.max(min, to[key])) : null;
}

/** @type {Readonly<Record<string, readonly [number, number]>>} */
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
/**
 * How far a key moves a point, to the right and down: an arrow by so much, ten times with Shift.
 * @param {KeyboardEvent} event @param {number} by
 * @returns {readonly [number, number] | null} null for other keys
 */
export function nudgeOf({ key, shiftKey, ctrlKey, metaKey, altKey }, by) {
  if (ctrlKey || metaKey || altKey || !Object.hasOwn(WAYS, key)) return null;
  const step = by * (shiftKey ? 10 : 1);
  return [step * WAYS[key][0], step * WAYS[key][1]];
}

/**
 * The letter that a key is pressed for: its own, or where a keyboard has others, such as Greek or Cyrillic ones, the one that stands there
 * on a Latin keyboard.
 * @param {KeyboardEvent} event
 */
export function letterOf({ key, code }) {
  return (/^[a-z]$/i.test(key) ? key : code.replace(/^Key/, '')).toLowerCase();
}

/**
 * Whether keys ask for a step back, or forth again.
 * @param {KeyboardEvent} event @returns {'undo' | 'redo' | null}
 */
export function stepOf(event) {
  if (!(event.ctrlKey || event.metaKey) || event.altKey) return null;
  const key = letterOf(event);
  if (key === 'y' || (key === 'z' && event.shiftKey)) return 'redo';
  return key === 'z' ? 'undo' : null;
}
