import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { text } from '../text.js';
import { MOST_PHOTOS } from './album.js';

/** What is being done: one block of the panel for each. @typedef {'empty' | 'busy' | 'choose' | 'none' | 'place' | 'ready' | 'adjust'} Mode */

/**
 * The panel of the room for photos: what may be done, and what is said of what is being done.
 *
 * @param {HTMLElement} panel
 * @param {{
 *   open: (files: File[]) => void,
 *   example: () => void,
 *   cancel: () => void,
 *   retry: () => void,
 *   place: () => void,
 *   fit: () => void,
 *   pointByPoint: () => void,
 *   asDetected: () => void,
 *   takeBack: () => void,
 *   leave: () => void,
 *   correct: () => void,
 *   another: () => void,
 *   more: (files: File[]) => void,
 *   close: () => void,
 *   own: () => void,
 *   keep: (type: 'image/png' | 'image/jpeg') => void,
 *   last: () => void,
 *   change: HTMLElement[],
 *   colours: HTMLElement,
 *   album: HTMLElement,
 * }} parts what each button does; `change`, `colours` and `album` stand among the controls of a photo that can be changed
 */
export function createControls(panel, parts) {
  const button = (/** @type {string} */ words, /** @type {() => void} */ onclick, kind = '') =>
    element('button', { type: 'button', class: `button ${kind}`, onclick }, words);
  const placeAnyway = () => button(text.photo.placeByHand, parts.place);
  const row = (/** @type {HTMLElement[]} */ ...of) => element('div', { class: 'row' }, ...of);

  const status = element('p', { class: 'photo-status', role: 'status' });
  const bar = element('progress', { max: 1, value: 0, 'aria-label': text.photo.progress });
  /** What is done with what is picked. */
  let picked = parts.open;
  const picker = element('input', {
    type: 'file',
    accept: 'image/*',
    multiple: true,
    hidden: true,
    'aria-label': text.photo.choose,
    onchange: () => {
      const files = [...(picker.files ?? [])];
      if (files.length > 0) picked(files);
      picked = parts.open;
      picker.value = '';
    },
  });
  /** @param {(files: File[]) => void} then */
  function pick(then) {
    picked = then;
    picker.click();
  }
  const back = button(text.photo.own, parts.own);
  const again = button(text.photo.fitAgain, parts.fit, 'primary');
  const asDetected = button(text.photo.asDetected, parts.asDetected);
  const takeBack = button(text.photo.takeBack, parts.takeBack);
  const leaving = button(text.photo.leave, parts.leave);
  const quality = element('p', { class: 'note' });
  const size = element('p', { class: 'note' });
  const retry = button(text.tryAgain, parts.retry);
  const another = button(text.photo.another, parts.another);
  const more = button(text.photo.more, () => pick(parts.more));

  /** @type {Partial<Record<Mode, HTMLElement>>} */
  const blocks = {
    busy: element('div', {}, bar, row(button(text.photo.cancel, parts.cancel))),
    choose: row(placeAnyway()),
    none: row(retry, placeAnyway()),
    place: element(
      'div',
      {},
      element('p', { class: 'note' }, text.photo.placeAbout),
      row(button(text.photo.fitThese, parts.fit, 'primary'), button(text.photo.pointByPoint, parts.pointByPoint)),
    ),
    adjust: element('div', {}, element('p', { class: 'note' }, text.photo.adjustAbout), row(again, takeBack, asDetected, leaving)),
    ready: element(
      'div',
      {},
      quality,
      row(button(text.photo.correct, parts.correct), another, button(text.photo.close, parts.close)),
      parts.album,
      row(more),
      element('p', { class: 'note' }, text.photo.moreAbout(MOST_PHOTOS)),
      element(
        'section',
        { class: 'part', 'aria-label': text.photo.change },
        element('h3', {}, text.photo.change),
        element('p', { class: 'note' }, text.photo.changeAbout),
        ...parts.change,
        row(back),
        parts.colours,
      ),
      element(
        'section',
        { class: 'part', 'aria-label': text.photo.saveTitle },
        element('h3', {}, text.photo.saveTitle),
        element('p', { class: 'note' }, text.photo.saveAbout),
        size,
        row(button(text.photo.asPng, () => parts.keep('image/png'), 'primary'), button(text.photo.asJpeg, () => parts.keep('image/jpeg'))),
      ),
    ),
  };
  const first = element('p', { class: 'note' }, text.photo.about);
  const toLast = row(button(text.photo.toLast, parts.last));
  panel.append(
    element('h2', { class: 'photo-title' }, text.photo.title),
    first,
    row(
      element('button', { type: 'button', class: 'button primary', onclick: () => pick(parts.open) }, icon('upload'), text.photo.choose),
      button(text.photo.example, parts.example),
      picker,
    ),
    element('p', { class: 'note photo-private' }, icon('lock'), text.photo.private),
    status,
    ...Object.values(blocks),
    toLast,
  );

  return {
    back,
    again,
    leaving,
    takeBack,
    retry,
    quality,
    size,
    /** @param {string} sentence @param {boolean} [wrong] */
    say(sentence, wrong = false) {
      status.textContent = sentence;
      status.classList.toggle('is-wrong', wrong);
    },
    /** Whether what was said last is that something is wrong. */
    get isWrong() {
      return status.classList.contains('is-wrong');
    },
    /** @param {number | null} part how much is done, 0 to 1; null when nobody knows */
    progress(part) {
      if (part === null) bar.removeAttribute('value');
      else bar.value = part;
    },
    /**
     * @param {Mode} mode
     * @param {{ photo: boolean, detected: boolean, several: boolean, last: boolean, full: boolean }} there whether there is a photo,
     *   points that were found in it, several faces, a photo before it, and as many of the person as may be
     */
    show(mode, there) {
      for (const [name, block] of Object.entries(blocks)) block.hidden = name !== mode;
      first.hidden = there.photo;
      asDetected.hidden = !there.detected;
      another.hidden = !there.several;
      more.disabled = there.full;
      toLast.hidden = !there.last || mode === 'busy' || mode === 'ready';
    },
    /** Goes to what can be done first. @param {Mode} mode */
    focus(mode) {
      /** @type {HTMLElement | null} */ ((blocks[mode] ?? panel).querySelector('button:enabled:not([hidden])'))?.focus();
    },
  };
}
