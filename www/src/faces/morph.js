import { mixture } from '../head/colouring.js';
import { part } from '../frame/download.js';
import { element } from '../frame/element.js';
import { createFaceList } from './facelist.js';
import { icon } from '../frame/icons.js';
import { save } from '../keep/save.js';
import { createSlider } from '../panel/slider.js';
import { shows } from '../head/expression.js';
import { text } from '../text.js';

/** How long the way takes, ms; it is played there and back. */
const LENGTH = 2400;
/** Frames a second of a film: a GIF counts in hundredths. */
const FPS = 20;

/** How far on the way, in per cent: slowly off and on, there until 1 and back until 2. @param {number} turn */
function placeAt(turn) {
  const along = turn < 1 ? turn : 2 - turn;
  return 100 * along * along * (3 - 2 * along);
}

/** Where on the way there it is so far. @param {number} percent */
const turnAt = (percent) => 0.5 - Math.sin(Math.asin(1 - percent / 50) / 3);

/**
 * The way from one face to another, on the stage only: to scrub, to play, to stop anywhere and keep, to
 * take along as a film.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   library: import('../keep/library.js').Library,
 *   display: import('../stage/display.js').Display,
 *   canvas: HTMLCanvasElement,
 *   wearsPhoto: () => boolean,
 *   reveal: () => void,
 *   say: (sentence: string) => void,
 * }} parts `reveal` brings the head to the stage, where a photo may be
 */
export function createMorph(editor, { library, display, canvas, wearsPhoto, reveal, say }) {
  const { model, face } = editor;
  const from = model.face();
  const to = model.face();
  const between = model.face();
  /** @type {import('../head/colouring.js').Colouring} */
  let colours = {};
  let percent = 0;
  /** Where it is on the way there and back, from which it is played. */
  let turn = 0;
  let playing = false;
  let showing = false;
  let began = 0;

  const present = { id: 'present', name: text.thisFace };
  const start = createFaceList(library, { id: 'morph-from', label: text.from, first: [present], onchange: changed });
  const end = createFaceList(library, { id: 'morph-to', label: text.to, first: [present], onchange: changed });
  end.select.value = library.presets[0].id;
  const aside = element('p', { class: 'note', hidden: true }, text.morphAtRest);

  /** Puts a face at an end. @param {import('phiz').Face} target @param {string} id @returns {import('../head/colouring.js').Colouring} its colours */
  function load(target, id) {
    const entry = library.find(id);
    target.code = entry ? entry.code : face.code;
    return entry?.colouring ?? editor.colouring;
  }
  function note() {
    aside.hidden = ![start, end].some(({ select }) => shows(select.value === present.id ? face.expression : library.find(select.value)?.expression));
  }
  function changed() {
    note();
    if (showing) show(percent);
  }
  /** @param {number} at in percent */
  function show(at) {
    percent = at;
    showing = true;
    const t = at / 100;
    colours = mixture([[load(from, start.select.value), 1 - t], [load(to, end.select.value), t]]);
    // A photo is worn by whose it is, and by nobody who is kept.
    const own = (start.select.value === present.id ? 1 - t : 0) + (end.select.value === present.id ? t : 0);
    between.code = from.code;
    between.blend(to, t);
    display.show(between, { colours, worn: wearsPhoto() ? own : true });
    refresh();
  }
  function leave() {
    playing = false;
    filming?.abort();
    if (showing) {
      showing = false;
      display.show(null);
    }
    percent = turn = 0;
    refresh();
  }
  /** @param {number} now */
  function frame(now) {
    if (!playing) return;
    // A frame may have begun before the button was pressed.
    turn = (Math.max(0, now - began) / LENGTH) % 2;
    show(placeAt(turn));
    requestAnimationFrame(frame);
  }

  const scrub = createSlider({
    name: text.way,
    label: text.way,
    id: 'morph-at',
    about: text.morphAbout,
    limits: [0, 100],
    step: 0.1,
    key: 1,
    neutral: 0,
    words: text.percent,
    typed: { label: text.wayTyped, unit: '%', min: 0, max: 100, step: 1, show: (value) => Math.round(value), take: pausedAt },
    move: pausedAt,
    finish: () => {},
  });
  /** @param {number} at */
  function pausedAt(at) {
    playing = false;
    turn = turnAt(at);
    show(at);
  }
  const play = element('button', {
    type: 'button',
    class: 'button',
    onclick: () => {
      playing = !playing;
      if (playing) {
        // Goes on from where it was left, and that way.
        began = performance.now() - LENGTH * turn;
        requestAnimationFrame(frame);
      }
      refresh();
    },
  });
  const keep = element(
    'button',
    {
      type: 'button',
      class: 'button',
      onclick: () => {
        const worn = colours;
        leave();
        const locked = face.locked.length + face.lockedMeasures.length > 0;
        // It is not all that was shown.
        if (editor.become(between, { colours: worn }) && locked) say(text.locked);
      },
    },
    text.keepThis,
  );
  const stop = element('button', { type: 'button', class: 'button', onclick: leave }, text.stop);

  const bar = element('progress', { max: 1, value: 0, hidden: true, 'aria-label': text.filming });
  const told = element('p', { class: 'note', role: 'status' });
  /** @type {AbortController | null} */
  let filming = null;
  /**
   * There and back as a file, at the size of the stage or less.
   * @param {'gif' | 'video'} kind
   */
  async function film(kind) {
    filming?.abort();
    const mine = new AbortController();
    filming = mine;
    playing = false;
    // It is of the head.
    reveal();
    bar.value = 0;
    bar.hidden = false;
    told.textContent = text.filming;
    // The encoder is on its way for a moment, in which nothing else may begin.
    refresh();
    try {
      // Who films nothing does not wait for the encoders.
      const make = kind === 'gif' ? (await part(() => import('../film/gif.js'))).gif : (await part(() => import('../film/video.js'))).video;
      const blob = await make({
        canvas,
        seconds: (2 * LENGTH) / 1000,
        fps: FPS,
        draw(t) {
          show(placeAt(2 * t));
          display.draw();
        },
        progress: (fraction) => (bar.value = fraction),
        signal: mine.signal,
      });
      const file = `morph.${{ 'image/gif': 'gif', 'video/mp4': 'mp4' }[blob.type] ?? 'webm'}`;
      save(blob, file);
      told.textContent = text.exported(file, blob.size);
    } catch (error) {
      told.textContent = mine.signal.aborted ? text.notFilmed : text.notExported(error instanceof Error ? error.message : String(error));
    }
    // Another film may have begun.
    if (filming !== mine) return;
    filming = null;
    bar.hidden = true;
    leave();
  }
  const asGif = element('button', { type: 'button', class: 'button', onclick: () => film('gif') }, icon('save'), text.asGif);
  const asVideo = element('button', { type: 'button', class: 'button', hidden: typeof VideoEncoder !== 'function' && typeof MediaRecorder !== 'function', onclick: () => film('video') }, icon('save'), text.asVideo);

  function refresh() {
    scrub.show(percent);
    if (play.dataset.playing !== String(playing)) {
      play.dataset.playing = String(playing);
      play.replaceChildren(icon(playing ? 'pause' : 'play'), playing ? text.pause : text.play);
    }
    keep.disabled = !showing;
    stop.disabled = !showing && filming === null;
    play.disabled = asGif.disabled = asVideo.disabled = start.select.disabled = end.select.disabled = filming !== null;
  }
  refresh();
  // Whoever shapes the face wants to see it, from the first move on.
  editor.onShape(() => {
    if (showing || filming) leave();
  });
  editor.onStep(() => {
    leave();
    note();
  });
  note();

  return {
    root: element(
      'section',
      { class: 'part morph', 'aria-label': text.morph },
      element('h3', {}, text.morph),
      element('div', { class: 'pair' }, start.root, end.root),
      aside,
      scrub.root,
      element('div', { class: 'row' }, play, keep, stop),
      element('div', { class: 'row' }, asGif, asVideo),
      bar,
      told,
    ),
    leave,
  };
}
