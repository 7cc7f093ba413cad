import { element } from './element.js';

/**
 * A button that counts for as long as it is held down, by pointer or by key.
 *
 * @param {string} words what stands on it
 * @param {{ changed: (down: boolean) => void, allowed?: () => boolean }} on `changed`: it went down or up;
 *   `allowed`: it may go down now
 */
export function createHold(words, { changed, allowed = () => true }) {
  let held = false;
  const button = element('button', { type: 'button', class: 'button hold', 'aria-pressed': 'false' }, words);
  /** As if it were held, for other keys. @param {boolean} down */
  function hold(down) {
    if (held === down || (down && !allowed())) return;
    held = down;
    button.setAttribute('aria-pressed', String(down));
    changed(down);
  }
  button.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    hold(true);
  });
  for (const end of ['pointerup', 'pointercancel', 'blur']) button.addEventListener(end, () => hold(false));
  button.addEventListener('keydown', (event) => {
    if (event.key !== ' ' && event.key !== 'Enter') return;
    event.preventDefault();
    hold(true);
  });
  button.addEventListener('keyup', (event) => (event.key === ' ' || event.key === 'Enter') && hold(false));
  button.addEventListener('contextmenu', (event) => event.preventDefault());
  return {
    button,
    hold,
    get held() {
      return held;
    },
  };
}
