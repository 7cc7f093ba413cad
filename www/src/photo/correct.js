import { element } from '../frame/element.js';
import { nudgeOf } from '../frame/keys.js';
import { text } from '../text.js';
import { onHair } from './onhair.js';
import { COUNT, LINES } from './points.js';

const SVG = 'http://www.w3.org/2000/svg';
/** The magnifier: its size, CSS px, and how much closer than the photo it shows. */
const LENS = 132;
const LENS_ZOOM = 3;
/** CSS px that an arrow key moves a point; ten times with Shift. */
const NUDGE = 1;
/** Points go so far beyond the photo's edges, of its size: where it cuts a face off, what is cut off is there. */
const BEYOND = 0.5;

/**
 * The drawing of the 68 points over the photo, and its correction: each is dragged under a magnifier, or
 * reached with Tab and moved with the arrow keys.
 *
 * @param {import('./view.js').View} view
 * @param {{ changed: () => void, leave: () => void }} on `leave`: Escape
 */
export function createCorrection(view, { changed, leave }) {
  /** px of the photo. @type {Float64Array} */
  let points = new Float64Array(2 * COUNT);
  /** How far from them they are drawn and taken hold of: brows on their hair. @type {Float64Array} */
  let off = new Float64Array(2 * COUNT);
  /** What they were before each step, and what was taken back. @type {{ done: Float64Array[], undone: Float64Array[] }} */
  let steps = { done: [], undone: [] };
  /** The point that keys move: until something else is done that is one step. */
  let nudged = -1;
  /** Where the fitted face has them. @type {Float64Array | null} */
  let fitted = null;
  /** @type {{ bitmap: ImageBitmap, width: number, height: number } | null} */
  let photo = null;

  const drawing = document.createElementNS(SVG, 'svg');
  drawing.setAttribute('class', 'photo-lines');
  drawing.setAttribute('aria-hidden', 'true');
  const path = (/** @type {string} */ name) => {
    const made = document.createElementNS(SVG, 'path');
    made.setAttribute('class', name);
    drawing.append(made);
    return made;
  };
  const fittedLines = path('is-fitted');
  const shadow = path('is-shadow');
  const given = path('is-given');

  const lens = element('canvas', { class: 'photo-lens', width: 2 * LENS, height: 2 * LENS, hidden: true, 'aria-hidden': 'true' });
  const handles = Array.from({ length: COUNT }, (_, i) => {
    const [name, first, last] = LINES.find(([, from, to]) => i >= from && i <= to) ?? LINES[0];
    const handle = element('button', {
      type: 'button',
      class: 'photo-point',
      'aria-label': text.photo.point(text.photo.lines[name], i - first + 1, last - first + 1),
      tabindex: -1,
    });
    handle.addEventListener('focus', () => {
      // One of them is a stop of the Tab key, from outside; from there it goes on to the others.
      for (const other of handles) other.tabIndex = other === handle ? 0 : -1;
      // What a pointer takes hold of stays under it.
      if (held < 0) view.reveal(...seen(i));
      nudged = -1;
    });
    handle.addEventListener('blur', () => (lens.hidden = true));
    handle.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === 'Escape') return held < 0 ? leave() : giveUp();
      const next = event.key === 'Tab' ? handles[i + (event.shiftKey ? -1 : 1)] : undefined;
      if (next) {
        event.preventDefault();
        next.focus();
      }
      const nudge = nudgeOf(event, NUDGE / view.scale);
      if (!nudge) return;
      event.preventDefault();
      if (nudged !== i) begin();
      nudged = i;
      move(i, points[2 * i] + nudge[0], points[2 * i + 1] + nudge[1]);
      view.reveal(...seen(i));
      magnify(i);
    });
    return handle;
  });
  const root = element('div', { class: 'photo-points', role: 'group', 'aria-label': text.photo.points, hidden: true }, ...handles, lens);
  root.prepend(drawing);
  /** The point that a pointer holds. */
  let held = -1;
  /** How far from the pointer it is, px of the photo: it is not drawn to it. */
  let grip = [0, 0];
  let isMoved = false;
  let pointer = -1;
  root.addEventListener('pointerdown', (event) => {
    if (event.button !== 0 || held >= 0) return;
    event.preventDefault();
    event.stopPropagation();
    // Handles overlap: the nearest is meant.
    const [px, py] = view.onPhoto(event);
    const away = (/** @type {number} */ i) => Math.hypot(seen(i)[0] - px, seen(i)[1] - py);
    held = handles.reduce((best, _, i) => (away(i) < away(best) ? i : best), 0);
    grip = [points[2 * held] - px, points[2 * held + 1] - py];
    isMoved = false;
    pointer = event.pointerId;
    handles[held].focus({ preventScroll: true });
    handles[held].setPointerCapture(event.pointerId);
    magnify(held);
  });
  root.addEventListener('pointermove', (event) => {
    if (held < 0 || !handles[held].hasPointerCapture(event.pointerId)) return;
    event.stopPropagation();
    if (!isMoved) begin();
    isMoved = true;
    const [px, py] = view.onPhoto(event);
    move(held, px + grip[0], py + grip[1]);
    magnify(held);
  });
  root.addEventListener('lostpointercapture', () => {
    held = -1;
    lens.hidden = true;
  });
  root.addEventListener('pointercancel', (event) => event.pointerId === pointer && giveUp());
  view.over.append(root);

  /** Where a point is drawn, px of the photo. @param {number} i @returns {[number, number]} */
  function seen(i, of = points) {
    return [of[2 * i] + off[2 * i], of[2 * i + 1] + off[2 * i + 1]];
  }
  /** @param {Float64Array} of */
  function pathOf(of) {
    return LINES.map(([, first, last, closed]) => {
      const at = [];
      for (let i = first; i <= last; i++) at.push(view.onScreen(...seen(i, of)).map((value) => value.toFixed(1)).join(' '));
      return `M${at.join('L')}${closed ? 'Z' : ''}`;
    }).join('');
  }
  function draw() {
    if (root.hidden) return;
    given.setAttribute('d', pathOf(points));
    shadow.setAttribute('d', pathOf(points));
    fittedLines.setAttribute('d', fitted ? pathOf(fitted) : '');
    for (const [i, handle] of handles.entries()) {
      const [left, top] = view.onScreen(...seen(i));
      handle.style.transform = `translate(${left.toFixed(2)}px, ${top.toFixed(2)}px)`;
    }
  }
  /** @param {number} i @param {number} px @param {number} py */
  function move(i, px, py) {
    const within = (/** @type {number} */ at, size = 0) => Math.min((1 + BEYOND) * size, Math.max(-BEYOND * size, at));
    points[2 * i] = within(px, photo?.width);
    points[2 * i + 1] = within(py, photo?.height);
    draw();
    changed();
  }
  /** A step begins, which can be taken back. */
  function begin() {
    steps.done.push(points.slice());
    steps.undone = [];
    nudged = -1;
  }
  /** What is held is where it was. */
  function giveUp() {
    if (held < 0) return;
    const handle = handles[held];
    held = -1;
    if (handle.hasPointerCapture(pointer)) handle.releasePointerCapture(pointer);
    lens.hidden = true;
    const before = isMoved && steps.done.pop();
    if (!before) return;
    points = before;
    draw();
    changed();
  }
  /** One step back, or forth again. @param {Float64Array[]} from @param {Float64Array[]} to */
  function go(from, to) {
    // What is held is under way.
    const there = held < 0 && from.pop();
    if (!there) return;
    to.push(points.slice());
    points = there;
    nudged = -1;
    lens.hidden = true;
    draw();
    changed();
  }
  /** @param {number} i */
  function magnify(i) {
    const context = lens.getContext('2d');
    if (!context || !photo) return;
    const [px, py] = seen(i);
    const closer = LENS_ZOOM * view.scale * 2;
    context.imageSmoothingEnabled = closer < 12;
    context.fillStyle = '#000';
    context.fillRect(0, 0, lens.width, lens.height);
    context.setTransform(closer, 0, 0, closer, LENS - px * closer, LENS - py * closer);
    context.drawImage(photo.bitmap, 0, 0, photo.width, photo.height);
    context.setTransform(1, 0, 0, 1, 0, 0);
    // The point is where the lines would meet; the pixel itself stays free.
    context.lineWidth = 2;
    for (const [style, off] of /** @type {const} */ ([['rgb(0 0 0 / 60%)', 1], ['#fff', 0]])) {
      context.strokeStyle = style;
      context.beginPath();
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        context.moveTo(LENS + 10 * dx + off, LENS + 10 * dy + off);
        context.lineTo(LENS + 46 * dx + off, LENS + 46 * dy + off);
      }
      context.stroke();
    }
    const [left, top] = view.onScreen(px, py);
    const { clientWidth } = view.over;
    const above = top > LENS + 40;
    lens.hidden = false;
    lens.style.transform = `translate(${Math.min(clientWidth - LENS, Math.max(0, left - LENS / 2))}px, ${above ? top - LENS - 28 : top + 28}px)`;
  }
  view.onMove(draw);

  return {
    root,
    get points() {
      return points;
    },
    /** @param {typeof photo} of @param {Float64Array} at copied */
    open(of, at) {
      photo = of;
      points = at.slice();
      off = onHair(points);
      steps = { done: [], undone: [] };
      nudged = -1;
      draw();
    },
    /** All of them, as a step. @param {Float64Array} at copied */
    replace(at) {
      begin();
      points = at.slice();
      off = onHair(points);
      draw();
      changed();
    },
    get canUndo() {
      return steps.done.length > 0;
    },
    undo: () => go(steps.done, steps.undone),
    redo: () => go(steps.undone, steps.done),
    /** The drawing of the fit, or none. @param {Float64Array | null} at */
    compare(at) {
      fitted = at;
      draw();
    },
    /** @param {boolean} now @param {boolean} [still] shown, but not to be moved */
    show(now, still = false) {
      root.hidden = !now;
      root.classList.toggle('is-still', still);
      for (const handle of handles) handle.hidden = still;
      lens.hidden = true;
      draw();
    },
    /** The tip of the nose first. */
    focus: () => handles[30].focus(),
  };
}
