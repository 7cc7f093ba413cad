import { isBeyond } from './distribution.js';
import { element } from '../frame/element.js';
import { isComposing, steppedTo } from '../frame/keys.js';
import { text } from '../text.js';
import { changeIn, numberIn } from './typed.js';

/** How far a finger goes sideways before it means the slider and not the page, px. */
const FINGER = 6;

/** Where what stands at the end of its way is, 0 to 1: ways reach out to the left, which no panel can be scrolled to. @param {number} at */
const alongWay = (at) => `${100 * (at - 1)}%`;

/**
 * The population's density as a filled curve.
 * @param {readonly number[]} density
 */
function bell(density) {
  const space = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(space, 'svg');
  svg.setAttribute('viewBox', `0 0 ${density.length - 1} 1`);
  svg.setAttribute('preserveAspectRatio', 'none');
  svg.setAttribute('aria-hidden', 'true');
  svg.classList.add('bell');
  const path = document.createElementNS(space, 'path');
  const points = density.map((value, i) => `L${i} ${(1 - value).toFixed(3)}`).join('');
  path.setAttribute('d', `M0 1${points}L${density.length - 1} 1Z`);
  svg.append(path);
  return svg;
}

/**
 * A named slider: a native range input whose thumb is drawn where the distribution puts it, and
 * its value as a button that takes a typed number.
 *
 * One gesture is from `hold` to `finish`: a drag, a run of one key, a typed number.
 *
 * @param {{
 *   name: string, label: string | Node, id: string, about: string, title?: string,
 *   limits: readonly [number, number], ends?: readonly [number, number], step: number, key: number, neutral: number,
 *   distribution?: Pick<import('./distribution.js').Distribution, 'place' | 'value' | 'density'>,
 *   words: (value: number) => string,
 *   typed: { label: string, unit: string, min: number, max: number, step: number,
 *     show: (value: number) => number, take: (shown: number) => void,
 *     atRank?: (percent: number) => number, write?: (shown: number) => string, read?: (typed: string, present: number) => number,
 *     ended?: (most: number) => string | Node, also?: () => string },
 *   legend?: string,
 *   move: (value: number) => void,
 *   hold?: () => void,
 *   cancel?: () => void,
 *   finish: () => void,
 *   extra?: Node[],
 * }} spec `limits` are the track's, `ends` where the thumb stops on it; `key` is what an arrow key adds; `typed` is the number that people see and type,
 *   `atRank` what it is at a percentile, `write` and `read` how it is typed where that is more than a number and its unit, `ended` what is said when it is
 *   beyond its end, `also` what else is to be said once it was taken, or nothing; `legend` stands after the value; `cancel` brings back what was there before, where moving there does not, and `finish` follows
 */
export function createSlider(spec) {
  const [min, max] = spec.ends ?? spec.limits;
  const { distribution } = spec;
  // Where on the track a value is, 0 to 1, and the other way round.
  const [first, last] = spec.limits.map((limit) => distribution?.place(limit) ?? limit);
  const along = (/** @type {number} */ at) => (at - first) / (last - first);
  const place = (/** @type {number} */ value) => Math.min(1, Math.max(0, along(distribution?.place(value) ?? value)));
  const valueAt = (/** @type {number} */ at) => {
    const there = first + at * (last - first);
    return distribution?.value(there) ?? there;
  };
  /** @type {{ pointer: number, grip: number, x: number, moving: boolean } | null} */
  let drag = null;
  let held = false;
  /** The value when it was taken up. */
  let began = NaN;
  // What is shown, the nearest to it that the input takes, and its words.
  let shown = NaN;
  let rounded = NaN;
  let said = '';
  /** @type {number | null} */
  let haunts = null;
  /** That what was typed is beyond the end, until the value is another, or that it cannot be read. @type {HTMLElement | null} */
  let notice = null;
  function unsay() {
    notice?.remove();
    notice = null;
    number.removeAttribute('aria-invalid');
  }
  /** @param {string | Node} wrong or nothing @param {string} [also] */
  function notify(wrong, also = '') {
    unsay();
    notice = element('p', { class: `notice${wrong ? '' : ' is-quiet'}`, role: 'alert' }, wrong, wrong && also && ' ', also);
    track.after(notice);
  }

  function hold() {
    if (held) return;
    held = true;
    began = shown;
    closeTyped(false);
    root.classList.add('is-held');
    spec.hold?.();
  }
  function release() {
    if (!held) return;
    held = false;
    root.classList.remove('is-held');
    spec.finish();
  }
  /** @param {number} value */
  function move(value) {
    hold();
    input.valueAsNumber = Math.min(max, Math.max(min, value));
    spec.move(input.valueAsNumber);
  }
  function toNeutral() {
    move(spec.neutral);
    release();
  }

  const input = element('input', {
    type: 'range',
    id: spec.id,
    min,
    max,
    step: spec.step,
    'aria-describedby': spec.about ? `${spec.id}-about` : null,
    title: spec.title,
    // Assistive technology and browsers' own gestures come this way.
    oninput: () => {
      if (drag) return;
      const value = input.valueAsNumber;
      hold();
      spec.move(value);
    },
    onchange: () => !drag && release(),
    ondblclick: toNeutral,
    onblur: () => !drag && release(),
    onkeyup: () => !drag && release(),
    onkeydown: (/** @type {KeyboardEvent} */ event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const to = steppedTo(event, input.valueAsNumber, spec.key, [min, max]);
      if (to !== null) move(to);
      else if (event.key === 'Escape' && drag) {
        cancel();
        event.stopPropagation();
      } else if (event.key === 'Delete' || event.key === 'Backspace') toNeutral();
      else if (/^[0-9.,+-]$/.test(event.key)) openTyped(event.key);
      else if (event.key === 'Enter') openTyped();
      else return;
      event.preventDefault();
    },
  });

  /** @param {PointerEvent} event @returns {number} */
  function placeUnder(event) {
    const box = input.getBoundingClientRect();
    const thumb = parseFloat(getComputedStyle(input).getPropertyValue('--thumb')) || 0;
    return (event.clientX - box.left - thumb / 2) / Math.max(1, box.width - thumb);
  }
  /** @param {PointerEvent} event */
  function follow(event) {
    if (!drag) return;
    move(valueAt(Math.min(1, Math.max(0, placeUnder(event) - drag.grip))));
  }
  input.addEventListener('pointerdown', (event) => {
    if (event.button !== 0 || drag) return;
    // The browser's own dragging would lay the slider out by percentile.
    event.preventDefault();
    input.focus({ preventScroll: true });
    const away = placeUnder(event) - place(input.valueAsNumber);
    const thumb = parseFloat(getComputedStyle(input).getPropertyValue('--thumb')) || 0;
    const onThumb = Math.abs(away) * input.clientWidth < thumb;
    drag = { pointer: event.pointerId, grip: onThumb ? away : 0, x: event.clientX, moving: event.pointerType !== 'touch' };
    // Wherever it is let go, and whether this is still there then: the other hand may have opened another feature.
    for (const over of /** @type {const} */ (['pointerup', 'pointercancel'])) window.addEventListener(over, letGo, true);
    if (drag.moving && !onThumb) follow(event);
    if (drag.moving) {
      input.setPointerCapture(event.pointerId);
      hold();
    }
  });
  input.addEventListener('pointermove', (event) => {
    if (drag?.pointer !== event.pointerId) return;
    if (!drag.moving && Math.abs(event.clientX - drag.x) < FINGER) return;
    drag.moving = true;
    follow(event);
  });
  function drop() {
    for (const over of /** @type {const} */ (['pointerup', 'pointercancel'])) window.removeEventListener(over, letGo, true);
    drag = null;
  }
  /** @param {PointerEvent} event */
  function letGo(event) {
    if (drag?.pointer !== event.pointerId) return;
    if (event.type === 'pointercancel') return cancel();
    // A tap of a finger puts the thumb there.
    if (!drag.moving && drag.grip === 0 && input.isConnected) follow(event);
    drop();
    release();
  }
  function cancel() {
    drop();
    if (!held) return;
    if (spec.cancel) spec.cancel();
    else spec.move(began);
    release();
  }

  const value = element('button', { type: 'button', class: 'value', onclick: () => openTyped() });
  const withinTyped = (/** @type {number} */ typed) => Math.min(spec.typed.max, Math.max(spec.typed.min, typed));
  // Browsers drop a comma from a number that is not typed in their language, and 50,5 is 505.
  const number = element('input', {
    type: 'text',
    role: 'spinbutton',
    class: 'typed',
    hidden: true,
    'aria-valuemin': spec.typed.min,
    'aria-valuemax': spec.typed.max,
    inputmode: 'decimal',
    autocomplete: 'off',
    'aria-label': spec.typed.label,
    title: text.typedChange(spec.typed.min < 0, spec.typed.unit === 'σ'),
    oninput: () => {
      unsay();
      tell();
    },
    onkeydown: (/** @type {KeyboardEvent} */ event) => {
      if (isComposing(event)) return;
      if (event.key === 'Enter') closeTyped(true);
      else if (event.key === 'Escape') closeTyped(false);
      else if (event.key === 'ArrowUp') stepTyped(1);
      else if (event.key === 'ArrowDown') stepTyped(-1);
      else return;
      event.preventDefault();
      event.stopPropagation();
    },
    onblur: () => closeTyped(true),
  });
  const present = () => spec.typed.show(input.valueAsNumber);
  const written = (/** @type {number} */ shown) => spec.typed.write?.(shown) ?? String(shown);
  function numberTyped() {
    const { unit, min, read, atRank } = spec.typed;
    if (read) return read(number.value, present());
    const change = changeIn(number.value, min, unit);
    return change === null ? numberIn(number.value, unit, atRank) : present() + numberIn(change, unit);
  }
  /** What the field had when it was opened, unless that was a key. */
  let untouched = '';
  function tell() {
    const typed = numberTyped();
    if (Number.isFinite(typed)) number.setAttribute('aria-valuenow', String(typed));
    else number.removeAttribute('aria-valuenow');
    if (spec.typed.write) number.setAttribute('aria-valuetext', number.value);
  }
  /** @param {number} steps */
  function stepTyped(steps) {
    const typed = numberTyped();
    if (!Number.isFinite(typed)) return;
    unsay();
    // What a sum of decimals is off by is not shown.
    number.value = written(Number(withinTyped(typed + steps * spec.typed.step).toFixed(6)));
    tell();
  }
  /** @param {string} [start] the first digit, typed on the slider */
  function openTyped(start) {
    number.hidden = false;
    value.hidden = true;
    unsay();
    untouched = start === undefined ? written(present()) : '';
    number.value = start ?? untouched;
    tell();
    number.focus();
    if (start === undefined) number.select();
  }
  /** @param {boolean} keep what was typed, unless it cannot be read: then the field stays, and says so */
  function closeTyped(keep) {
    if (number.hidden) return;
    // Not where the focus is on its way to something else.
    const isWithin = document.activeElement === number;
    const before = present();
    const left = !keep || number.value.trim() === '' || number.value === untouched;
    const typed = left ? before : numberTyped();
    if (!Number.isFinite(typed)) {
      notify(text.unread(written(before)));
      number.setAttribute('aria-invalid', 'true');
      return;
    }
    unsay();
    number.hidden = true;
    value.hidden = false;
    if (isWithin) value.focus({ preventScroll: true });
    if (typed === before) return;
    const within = withinTyped(typed);
    let also = '';
    if (within !== before) {
      spec.typed.take(within);
      also = spec.typed.also?.() ?? '';
    }
    if (within !== typed) notify(spec.typed.ended?.(within) ?? text.ended(written(within)), also);
    else if (also) notify('', also);
  }

  // Each is told its own place: what the track is told, all that is in it has to be styled for again.
  const fill = element('span', { class: 'fill' });
  const ghost = element('span', { class: 'way' }, element('span', { class: 'ghost' }));
  const thumb = element('span', { class: 'way' }, element('span', { class: 'thumb' }));
  const track = element('div', { class: 'track' }, element('span', { class: 'line' }), fill, ghost, thumb, input);
  if (distribution) {
    track.prepend(bell(distribution.density));
    // Where people end.
    track.style.setProperty('--low', String(Math.max(0, along(0))));
    track.style.setProperty('--high', String(Math.min(1, along(1))));
    track.classList.toggle('goes-beyond', first < 0);
  }
  track.style.setProperty('--least', String(place(min)));
  track.style.setProperty('--most', String(place(max)));
  const root = element(
    'div',
    { class: 'control' },
    element('label', { for: spec.id }, spec.label),
    element('span', { class: 'reading' }, value, number, ...(spec.legend ? [element('span', { class: 'legend', 'aria-hidden': 'true' }, spec.legend)] : [])),
    track,
    ...(spec.about ? [element('p', { class: 'about', id: `${spec.id}-about` }, spec.about)] : []),
    ...(spec.extra ?? []),
  );

  return {
    root,
    input,
    /**
     * Shows a value, on the track, in words, and to assistive technology.
     * @param {number} present
     */
    show(present) {
      const words = spec.words(present);
      // Most sliders stay where they are while one moves.
      if (present === shown && words === said && input.valueAsNumber === rounded) return;
      if (present !== shown) {
        // What could not be read was typed for the value before.
        if (number.hasAttribute('aria-invalid')) closeTyped(false);
        unsay();
      }
      [shown, said] = [present, words];
      if (!(drag && input.valueAsNumber === present)) input.valueAsNumber = present;
      rounded = input.valueAsNumber;
      const at = place(present);
      thumb.style.translate = alongWay(at);
      const rest = place(spec.neutral);
      fill.style.setProperty('--from', String(Math.min(at, rest)));
      fill.style.setProperty('--to', String(Math.max(at, rest)));
      if (input.getAttribute('aria-valuetext') !== words) {
        input.setAttribute('aria-valuetext', words);
        value.textContent = words;
        value.setAttribute('aria-label', text.typeValue(spec.name, words));
      }
      root.classList.toggle('is-moved', Math.abs(present - spec.neutral) > 0.0051 * (distribution ? 1 : max - min));
      root.classList.toggle('is-beyond', distribution !== undefined && isBeyond(present));
    },
    /** What was said beside the way is over, such as when something else was done since. */
    hush() {
      if (notice?.classList.contains('is-quiet')) unsay();
    },
    /**
     * Marks where it stood before something else was moved; null takes the mark away.
     * @param {number | null} before
     */
    ghost(before) {
      if (before === haunts) return;
      haunts = before;
      track.classList.toggle('has-ghost', before !== null);
      if (before !== null) ghost.style.translate = alongWay(place(before));
    },
  };
}

/** @typedef {ReturnType<typeof createSlider>} Slider */
