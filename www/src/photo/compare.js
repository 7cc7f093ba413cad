import { element } from '../frame/element.js';
import { createHold } from '../frame/hold.js';
import { createSlider } from '../panel/slider.js';
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
  /** The photo as it was. */
  const original = createHold(text.photo.hold, { changed, allowed });

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

  return {
    /** For the panel. */
    strengthSlider: slider.root,
    button: original.button,
    /** For the stage. */
    beforeAfter,
    hold: original.hold,
    get held() {
      return original.held;
    },
    /** A part of the change. */
    get strength() {
      return strength / 100;
    },
    /** A part of the width; null: there is no line. */
    get split() {
      return split > 0 ? split / 100 : null;
    },
    /** For another photo, which shows all that is done to it. */
    reset() {
      strength = 100;
      slider.show(strength);
      split = line.valueAsNumber = 0;
    },
  };
}
