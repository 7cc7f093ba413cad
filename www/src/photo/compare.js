import { element } from '../element.js';
import { createSlider } from '../slider.js';
import { text } from '../text.js';

/**
 * How the changed photo is compared with the photo as it was: how much of the change is shown, left of which
 * line none of it is, and nothing of it for as long as something is held.
 *
 * @param {{ changed: () => void, allowed: () => boolean }} on `changed`: the photo is to be drawn again;
 *   `allowed`: there is a change to hold
 */
export function createComparison({ changed, allowed }) {
  let strength = 100;
  let split = 0;
  let held = false;

  const slider = createSlider({
    name: text.photo.strength,
    label: text.photo.strength,
    id: 'photo-strength',
    about: text.photo.strengthAbout,
    limits: [0, 100],
    step: 1,
    key: 1,
    neutral: 100,
    words: text.percent,
    typed: { label: text.photo.strengthTyped, unit: '%', min: 0, max: 100, step: 1, show: Math.round, take: setStrength },
    move: setStrength,
    finish() {},
  });
  slider.show(strength);
  const line = element('input', { type: 'range', id: 'photo-split', min: 0, max: 100, value: 0, oninput: () => setSplit(line.valueAsNumber) });
  const beforeAfter = element('div', { class: 'photo-split', hidden: true }, element('label', { for: 'photo-split' }, text.photo.split), line);
  const button = element('button', { type: 'button', class: 'button hold', 'aria-pressed': 'false' }, text.photo.hold);

  /** @param {number} percent */
  function setStrength(percent) {
    strength = percent;
    slider.show(percent);
    changed();
  }
  /** @param {number} percent */
  function setSplit(percent) {
    split = percent;
    changed();
  }
  /** The photo as it was, for as long as something is held. @param {boolean} down */
  function hold(down) {
    if (held === down || !allowed()) return;
    held = down;
    button.setAttribute('aria-pressed', String(down));
    changed();
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
    /** For the panel. */
    strengthSlider: slider.root,
    button,
    /** For the stage. */
    beforeAfter,
    hold,
    get held() {
      return held;
    },
    /** A part of the change. */
    get strength() {
      return strength / 100;
    },
    /** A part of the width; null: there is no line. */
    get split() {
      return split > 0 ? split / 100 : null;
    },
    /** For another photo. */
    reset() {
      split = line.valueAsNumber = 0;
    },
  };
}
