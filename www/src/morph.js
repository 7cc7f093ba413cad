import { element } from './element.js';
import { createFaceList } from './facelist.js';
import { icon } from './icons.js';
import { createSlider } from './slider.js';
import { text } from './text.js';

/** How long the way takes, ms; it is played there and back. */
const LENGTH = 2400;

/**
 * The way from one face to another, on the stage only: to scrub, to play, to stop anywhere and keep.
 *
 * @param {import('./editor.js').Editor} editor
 * @param {{ library: import('./library.js').Library, display: import('./display.js').Display }} parts
 */
export function createMorph(editor, { library, display }) {
  const { model, face } = editor;
  const from = model.face();
  const to = model.face();
  const between = model.face();
  let percent = 0;
  let playing = false;
  let showing = false;
  let began = 0;

  const present = { id: 'present', name: text.thisFace };
  const start = createFaceList(library, { id: 'morph-from', label: text.from, first: [present], onchange: changed });
  const end = createFaceList(library, { id: 'morph-to', label: text.to, first: [present], onchange: changed });
  end.select.value = library.presets[0].id;

  /** @param {import('phiz').Face} target @param {string} id */
  function load(target, id) {
    const entry = library.find(id);
    target.code = entry ? entry.code : face.code;
  }
  function changed() {
    if (showing) show(percent);
  }
  /** @param {number} at in percent */
  function show(at) {
    percent = at;
    showing = true;
    load(from, start.select.value);
    load(to, end.select.value);
    between.code = from.code;
    between.blend(to, at / 100);
    display.show(between);
    refresh();
  }
  function leave() {
    playing = false;
    if (showing) {
      showing = false;
      display.show(null);
    }
    percent = 0;
    refresh();
  }
  /** @param {number} now */
  function frame(now) {
    if (!playing) return;
    const turn = ((now - began) / LENGTH) % 2;
    const along = turn < 1 ? turn : 2 - turn;
    show(100 * along * along * (3 - 2 * along));
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
    show(at);
  }
  const play = element('button', {
    type: 'button',
    class: 'button',
    onclick: () => {
      playing = !playing;
      if (playing) {
        // Goes on from where it was left: the inverse of the ease, near enough.
        began = performance.now() - LENGTH * Math.min(0.99, percent / 100);
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
        const code = between.code;
        leave();
        editor.take(code);
      },
    },
    text.keepThis,
  );
  const stop = element('button', { type: 'button', class: 'button', onclick: leave }, text.stop);

  function refresh() {
    scrub.show(percent);
    if (play.dataset.playing !== String(playing)) {
      play.dataset.playing = String(playing);
      play.replaceChildren(icon(playing ? 'pause' : 'play'), playing ? text.pause : text.play);
    }
    keep.disabled = !showing;
    stop.disabled = !showing;
  }
  refresh();
  // Whoever shapes the face wants to see it.
  editor.onStep(leave);

  return {
    root: element(
      'section',
      { class: 'part morph', 'aria-label': text.morph },
      element('h3', {}, text.morph),
      element('div', { class: 'pair' }, start.root, end.root),
      scrub.root,
      element('div', { class: 'row' }, play, keep, stop),
    ),
    leave,
    /** The faces at the two ends and where between them the stage is, for whoever films it. */
    get ends() {
      load(from, start.select.value);
      load(to, end.select.value);
      return { from, to };
    },
  };
}
