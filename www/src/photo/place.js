import { element } from '../frame/element.js';
import { text } from '../text.js';
import { boxOf } from './points.js';

/** What a key does to the whole: px of the screen, a factor, radians. */
const MOVE = 4;
const GROW = 1.03;
const TURN = (2 * Math.PI) / 180;
/** The whole is no lower, px of the photo. */
const LEAST = 8;

/**
 * A mean set of points, laid over the photo as one thing: moved, sized and turned by a frame around it,
 * by a handle at its corner, and by keys.
 *
 * @param {import('./view.js').View} view
 * @param {{ changed: (points: Float64Array) => void }} on
 */
export function createPlacing(view, { changed }) {
  /** One high, around 0. @type {Float64Array} */
  let mean = new Float64Array(0);
  /** Where the middle is and how high it is, px of the photo; radians. */
  let [cx, cy, size, angle] = [0, 0, 1, 0];
  let half = [0.5, 0.5];

  const handle = element('span', { class: 'photo-grip', 'aria-hidden': 'true' });
  const frame = element('div', { class: 'photo-frame', role: 'application', tabindex: 0, 'aria-label': text.photo.frame, hidden: true }, handle);
  view.over.append(frame);

  function points() {
    const [c, s] = [size * Math.cos(angle), size * Math.sin(angle)];
    return mean.map((_, i) => (i % 2 ? cy + s * mean[i - 1] + c * mean[i] : cx + c * mean[i] - s * mean[i + 1]));
  }
  function draw() {
    if (frame.hidden) return;
    const [left, top] = view.onScreen(cx, cy);
    const [w, h] = half.map((value) => value * size * view.scale * 2);
    frame.style.width = `${w}px`;
    frame.style.height = `${h}px`;
    frame.style.transform = `translate(${left - w / 2}px, ${top - h / 2}px) rotate(${angle}rad)`;
  }
  function apply() {
    draw();
    changed(points());
  }

  /** @type {{ id: number, corner: boolean, at: readonly [number, number], from: { cx: number, cy: number, size: number, angle: number } } | null} */
  let held = null;
  frame.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    event.stopPropagation();
    if (held) return;
    frame.setPointerCapture(event.pointerId);
    held = { id: event.pointerId, corner: event.target === handle, at: view.onPhoto(event), from: { cx, cy, size, angle } };
  });
  frame.addEventListener('pointermove', (event) => {
    if (held?.id !== event.pointerId) return;
    event.stopPropagation();
    const { at, from, corner } = held;
    const now = view.onPhoto(event);
    if (corner) {
      const [before, after] = [at, now].map(([px, py]) => [px - from.cx, py - from.cy]);
      size = Math.max(LEAST, (from.size * Math.hypot(after[0], after[1])) / Math.max(1e-6, Math.hypot(before[0], before[1])));
      angle = from.angle + Math.atan2(after[1], after[0]) - Math.atan2(before[1], before[0]);
    } else {
      cx = from.cx + now[0] - at[0];
      cy = from.cy + now[1] - at[1];
    }
    apply();
  });
  /** What is held is where it was. */
  function giveUp() {
    if (!held) return;
    ({ cx, cy, size, angle } = held.from);
    held = null;
    apply();
  }
  frame.addEventListener('pointerup', (event) => {
    if (held?.id === event.pointerId) held = null;
  });
  frame.addEventListener('pointercancel', (event) => {
    if (held?.id === event.pointerId) giveUp();
  });
  frame.addEventListener('keydown', (event) => {
    if (event.key === 'Escape') return giveUp();
    // Brackets are typed with Alt on many keyboards.
    if (event.ctrlKey || event.metaKey || (event.altKey && !'[]'.includes(event.key))) return;
    const step = (MOVE * (event.shiftKey ? 5 : 1)) / view.scale;
    /** @type {Record<string, () => void>} */
    const keys = {
      ArrowLeft: () => (cx -= step),
      ArrowRight: () => (cx += step),
      ArrowUp: () => (cy -= step),
      ArrowDown: () => (cy += step),
      '+': () => (size *= GROW),
      '=': () => (size *= GROW),
      '-': () => (size /= GROW),
      '[': () => (angle -= TURN),
      ']': () => (angle += TURN),
    };
    const act = keys[event.key];
    if (!act) return;
    event.preventDefault();
    act();
    view.reveal(cx, cy);
    apply();
  });
  view.onMove(draw);

  return {
    /**
     * @param {Float64Array} shape one high, around 0
     * @param {number} px where its middle goes, px of the photo @param {number} py @param {number} tall px
     */
    open(shape, px, py, tall) {
      mean = shape;
      [cx, cy, size, angle] = [px, py, tall, 0];
      const [left, top, right, bottom] = boxOf(shape);
      half = [Math.max(-left, right), Math.max(-top, bottom)];
      apply();
    },
    /** Around points as they lie. @param {Float64Array} at px of the photo */
    take(at) {
      const [left, top, right, bottom] = boxOf(at);
      [cx, cy, size, angle] = [(left + right) / 2, (top + bottom) / 2, Math.max(LEAST, bottom - top), 0];
      mean = at.map((value, i) => (value - (i % 2 ? cy : cx)) / size);
      half = [(right - left) / 2 / size, (bottom - top) / 2 / size];
      draw();
    },
    /** @param {boolean} now */
    show(now) {
      frame.hidden = !now;
      draw();
    },
    focus: () => frame.focus(),
  };
}
