import { element } from '../frame/element.js';
import { icon } from '../frame/icons.js';
import { text } from '../text.js';

/** How much closer than whole, at most: then a pixel of the photo is at least so many on the screen. */
const CLOSEST = 8;
/** How far an arrow key moves the photo, CSS px, and how much a step of zoom is. */
const STEP = 48;
const CLOSER = 1.25;
/** Room around a photo that is shown whole, CSS px: above for the switch, below for the tools. */
const MARGIN = { x: 12, top: 58, bottom: 62 };
/** From so many CSS px a pixel on, pixels are shown as squares. */
const PIXELS_FROM = 6;
/** A stage lower than this, CSS px, has no room to leave below. */
const LOW = 420;

/**
 * The photo on the stage: shown whole, or moved and zoomed by wheel, fingers, and keys. What lies over it
 * is told when it moves.
 *
 * @param {{ hold: (down: boolean) => void }} on `hold`: the space bar asks for the photo as it was
 */
export function createView({ hold }) {
  const canvas = element('canvas', { class: 'photo-canvas', tabindex: 0, role: 'img', 'aria-label': text.photo.canvas });
  const over = element('div', { class: 'photo-over' });
  const line = element('div', { class: 'photo-line', hidden: true });
  const window_ = element('div', { class: 'photo-window' }, canvas, over, line);
  const root = element('div', { class: 'photo', hidden: true }, window_);

  let [width, height] = [1, 1];
  /** CSS px a pixel of the photo, and where its corner is. */
  let [scale, x, y] = [1, 0, 0];
  let whole = true;
  /** What is to be shown as large as it fits, px of the photo, once there is a size to fit into. @type {readonly number[] | null} */
  let later = null;
  /** @type {number | null} */
  let split = null;
  /** @type {Set<() => void>} */
  const listeners = new Set();

  const below = () => (window_.clientHeight < LOW ? 6 : MARGIN.bottom);
  function least() {
    const { clientWidth, clientHeight } = window_;
    return Math.min((clientWidth - 2 * MARGIN.x) / width, (clientHeight - MARGIN.top - below()) / height);
  }
  function place() {
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    canvas.style.transform = `translate(${x}px, ${y}px) scale(${scale})`;
    // Pixels that are larger than the screen's are shown as they are.
    canvas.style.imageRendering = scale * (width / canvas.width) > PIXELS_FROM ? 'pixelated' : '';
    line.hidden = split === null;
    line.style.transform = `translate(${x + (split ?? 0) * width * scale}px, ${Math.max(0, y)}px)`;
    line.style.height = `${Math.min(window_.clientHeight, y + height * scale) - Math.max(0, y)}px`;
    for (const listener of listeners) listener();
  }
  /** The photo's edge is not dragged past the middle. */
  function keep() {
    const { clientWidth, clientHeight } = window_;
    x = Math.min(clientWidth / 2, Math.max(clientWidth / 2 - width * scale, x));
    y = Math.min(clientHeight / 2, Math.max(clientHeight / 2 - height * scale, y));
  }
  function fit() {
    const { clientWidth, clientHeight } = window_;
    whole = true;
    later = null;
    // Covered by the head it has no size, and comes to one when it is shown again.
    if (!clientWidth || !clientHeight) return;
    scale = Math.max(1e-3, least());
    x = (clientWidth - width * scale) / 2;
    y = MARGIN.top + (clientHeight - MARGIN.top - below() - height * scale) / 2;
    place();
  }
  /** @param {number} factor @param {number} atX @param {number} atY CSS px of the window, which stay where they are */
  function zoom(factor, atX, atY) {
    const smallest = least();
    const to = Math.min(Math.max(CLOSEST, CLOSEST * smallest), Math.max(smallest, scale * factor));
    if (to <= smallest) return fit();
    x = atX - ((atX - x) * to) / scale;
    y = atY - ((atY - y) * to) / scale;
    scale = to;
    whole = false;
    keep();
    place();
  }
  /** @param {number} dx @param {number} dy */
  function pan(dx, dy) {
    x += dx;
    y += dy;
    whole = false;
    keep();
    place();
  }
  /** What keys and buttons come closer to, px of the photo: the face, once there is one. @type {readonly [number, number] | null} */
  let subject = null;
  /** @param {number} factor */
  function zoomMiddle(factor) {
    const { clientWidth, clientHeight } = window_;
    const [left, top] = subject ? [x + subject[0] * scale, y + subject[1] * scale] : [-1, -1];
    const inside = left > 0 && top > 0 && left < clientWidth && top < clientHeight;
    zoom(factor, ...(inside ? /** @type {const} */ ([left, top]) : /** @type {const} */ ([clientWidth / 2, clientHeight / 2])));
  }

  /** Shows a part of the photo as large as it fits. @param {readonly number[]} box left, top, right, bottom */
  function closeTo(box) {
    const [left, top, right, bottom] = box;
    subject = [(left + right) / 2, (top + bottom) / 2];
    const { clientWidth, clientHeight } = window_;
    if (!clientWidth || !clientHeight) return void (later = box);
    const most = Math.min(clientWidth / (right - left), (clientHeight - MARGIN.top) / (bottom - top)) * 0.86;
    if (most <= least()) return fit();
    scale = Math.min(Math.max(CLOSEST, CLOSEST * least()), most);
    whole = false;
    later = null;
    x = clientWidth / 2 - scale * subject[0];
    y = (clientHeight + MARGIN.top) / 2 - scale * subject[1];
    // Not past the photo's edge while it fills the stage.
    x = clientWidth > width * scale ? (clientWidth - width * scale) / 2 : Math.min(0, Math.max(clientWidth - width * scale, x));
    const room = clientHeight - MARGIN.top;
    y = room > height * scale ? MARGIN.top + (room - height * scale) / 2 : Math.min(MARGIN.top, Math.max(clientHeight - height * scale, y));
    place();
  }

  /** @param {{ clientX: number, clientY: number }} event CSS px of the window */
  function local({ clientX, clientY }) {
    const box = window_.getBoundingClientRect();
    return /** @type {const} */ ([clientX - box.left, clientY - box.top]);
  }

  window_.addEventListener(
    'wheel',
    (event) => {
      event.preventDefault();
      // A trackpad's pinch comes as a wheel with Ctrl, in smaller steps.
      zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : event.ctrlKey ? 0.01 : 0.0016)), ...local(event));
    },
    { passive: false },
  );
  /** Pointers that are down on the photo. @type {Map<number, readonly [number, number]>} */
  const down = new Map();
  window_.addEventListener('pointerdown', (event) => {
    if (event.button > 1 || down.size === 2) return;
    down.set(event.pointerId, local(event));
    window_.setPointerCapture(event.pointerId);
    window_.classList.add('is-dragged');
  });
  window_.addEventListener('pointermove', (event) => {
    const before = down.get(event.pointerId);
    if (!before) return;
    const now = local(event);
    const other = [...down].find(([id]) => id !== event.pointerId)?.[1];
    down.set(event.pointerId, now);
    if (!other) return pan(now[0] - before[0], now[1] - before[1]);
    const length = (/** @type {readonly [number, number]} */ at) => Math.max(1, Math.hypot(at[0] - other[0], at[1] - other[1]));
    pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
    zoom(length(now) / length(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  });
  for (const end of /** @type {const} */ (['pointerup', 'pointercancel', 'lostpointercapture'])) {
    window_.addEventListener(end, (event) => {
      down.delete(event.pointerId);
      window_.classList.toggle('is-dragged', down.size > 0);
    });
  }
  canvas.addEventListener('dblclick', () => fit());
  canvas.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    /** @type {Record<string, () => void>} */
    const keys = {
      '+': () => zoomMiddle(CLOSER),
      '=': () => zoomMiddle(CLOSER),
      '-': () => zoomMiddle(1 / CLOSER),
      0: fit,
      ArrowLeft: () => pan(STEP, 0),
      ArrowRight: () => pan(-STEP, 0),
      ArrowUp: () => pan(0, STEP),
      ArrowDown: () => pan(0, -STEP),
      ' ': () => hold(true),
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    if (!event.repeat || event.key !== ' ') keys[event.key]();
  });
  canvas.addEventListener('keyup', (event) => event.key === ' ' && hold(false));
  canvas.addEventListener('blur', () => hold(false));
  new ResizeObserver(() => {
    if (!window_.clientWidth || !window_.clientHeight) return;
    if (later) return closeTo(later);
    if (whole) return fit();
    keep();
    place();
  }).observe(window_);

  const tool = (/** @type {Parameters<typeof icon>[0]} */ sign, /** @type {string} */ words, /** @type {() => void} */ onclick) =>
    element('button', { type: 'button', class: 'tool', 'aria-label': words, title: words, onclick }, icon(sign));
  const tools = element(
    'div',
    { class: 'photo-zoom', role: 'group', 'aria-label': text.photo.zoom },
    tool('minus', text.photo.farther, () => zoomMiddle(1 / CLOSER)),
    tool('plus', text.photo.closer, () => zoomMiddle(CLOSER)),
    tool('home', text.photo.whole, fit),
  );
  root.append(tools);

  return {
    root,
    canvas,
    /** Elements that lie over the photo; they place themselves when it moves. */
    over,
    /** @param {() => void} listener */
    onMove: (listener) => void listeners.add(listener),
    /** @param {number} w @param {number} h of the photo, px */
    open(w, h) {
      [width, height] = [w, h];
      subject = null;
      fit();
    },
    fit,
    get scale() {
      return scale;
    },
    /** From px of the photo to CSS px of the window. @param {number} px @param {number} py */
    onScreen: (px, py) => /** @type {const} */ ([x + px * scale, y + py * scale]),
    /** Of a pointer, px of the photo. @param {{ clientX: number, clientY: number }} event */
    onPhoto(event) {
      const [left, top] = local(event);
      return /** @type {const} */ ([(left - x) / scale, (top - y) / scale]);
    },
    /** @param {number | null} at a part of the width */
    split(at) {
      split = at;
      place();
    },
    /** Brings px of the photo into view. @param {number} px @param {number} py */
    reveal(px, py) {
      const [left, top] = [x + px * scale, y + py * scale];
      const { clientWidth, clientHeight } = window_;
      const dx = left < 24 ? 24 - left : Math.min(0, clientWidth - 24 - left);
      const dy = top < MARGIN.top ? MARGIN.top - top : Math.min(0, clientHeight - 24 - top);
      if (dx || dy) pan(dx, dy);
    },
    closeTo,
  };
}

/** @typedef {ReturnType<typeof createView>} View */
