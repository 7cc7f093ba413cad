import { mixture } from '../head/colouring.js';
import { element } from '../frame/element.js';
import { tapping, text } from '../text.js';

const MOST = 6;

/**
 * The share of each face at a place: by the inverse square of the distance (Shepard 1968), so that
 * on a face it is that face alone, and in the middle all have the same.
 * @param {readonly (readonly [number, number])[]} faces @param {readonly [number, number]} at
 */
export function shares(faces, at) {
  const weights = faces.map(([x, y]) => 1 / Math.max(1e-9, (x - at[0]) ** 2 + (y - at[1]) ** 2));
  const sum = weights.reduce((total, weight) => total + weight, 0);
  return weights.map((weight) => weight / sum);
}

/** @param {number} count @returns {[number, number][]} on the unit circle, the first on top */
function places(count) {
  return Array.from({ length: count }, (_, i) => {
    const turn = (2 * Math.PI * i) / count;
    return [Math.sin(turn), -Math.cos(turn)];
  });
}

/**
 * Up to six faces in a circle and a puck between them: the face is the mixture where the puck is.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{ library: import('../keep/library.js').Library, portraits: import('../stage/portraits.js').Portraits, say: (sentence: string) => void }} parts
 */
export function createCircle(editor, { library, portraits, say }) {
  const { model } = editor;
  const mixed = model.face();
  /** @type {{ entry: import('../keep/library.js').Entry, whole: import('phiz').Face }[]} */
  let members = [];
  /** @type {[number, number]} */
  let at = [0, 0];
  /** What is locked stays as it was. @type {import('../editing/history.js').State | null} */
  let base = null;
  let ownStep = false;
  /** Where the puck stood when the face was the one of a code: a step back or forth leads there. @type {Map<string, [number, number]>} */
  const stood = new Map();
  editor.onStep(() => {
    if (ownStep) return;
    base = null;
    at = stood.get(editor.face.code) ?? at;
    refresh();
  });

  function finish() {
    stood.set(editor.face.code, at);
    ownStep = true;
    editor.finish('mixing circle');
    ownStep = false;
  }
  /** The puck is where it was taken up, and so is what it counts from. */
  function cancel() {
    if (!held) return;
    const { from, counted } = held;
    held = null;
    ownStep = true;
    editor.cancel();
    ownStep = false;
    at = from;
    base = counted;
    refresh();
  }
  /** @param {number} x @param {number} y */
  function moveTo(x, y) {
    if (!base) {
      base = editor.state;
      stood.set(base.code, at);
    }
    const length = Math.max(1, Math.hypot(x, y));
    at = [x / length, y / length];
    const weights = shares(places(members.length), at);
    // One after another, each by its share of those so far: faces are more than their coefficients where locks took something back.
    let sum = 0;
    members.forEach(({ whole }, i) => {
      sum += weights[i];
      if (weights[i] > 0) mixed.blend(whole, weights[i] / sum);
    });
    const own = base.colouring;
    const colours = mixture(members.map(({ entry }, i) => [entry.colouring ?? own, weights[i]]));
    editor.moveFrom(base, (present) => present.blend(mixed, 1), colours);
    refresh();
  }
  function refresh() {
    puck.style.setProperty('--x', String(at[0]));
    puck.style.setProperty('--y', String(at[1]));
    const weights = shares(places(members.length), at);
    const words = members.map(({ entry }, i) => [entry.name, Math.round(100 * weights[i])]);
    puck.setAttribute('aria-valuetext', words.map(([name, share]) => `${name} ${share}%`).join(', '));
    puck.setAttribute('aria-valuenow', String(Math.round(100 * Math.max(0, ...weights))));
    ring.querySelectorAll('.share').forEach((label, i) => (label.textContent = text.percent(100 * weights[i])));
  }

  const puck = element('div', {
    class: 'puck',
    role: 'slider',
    tabindex: 0,
    'aria-label': text.puck,
    'aria-valuemin': 0,
    'aria-valuemax': 100,
    onkeydown: (/** @type {KeyboardEvent} */ event) => {
      const step = event.shiftKey ? 0.25 : 0.05;
      /** @type {Record<string, [number, number]>} */
      const to = {
        ArrowLeft: [at[0] - step, at[1]],
        ArrowRight: [at[0] + step, at[1]],
        ArrowUp: [at[0], at[1] - step],
        ArrowDown: [at[0], at[1] + step],
        Home: [0, 0],
      };
      if (event.key === 'Escape' && held) {
        event.stopPropagation();
        cancel();
      }
      if (!(event.key in to)) return;
      event.preventDefault();
      moveTo(...to[event.key]);
      finish();
    },
  });
  const ring = element('div', { class: 'ring' });
  /** @type {{ pointer: number, from: [number, number], counted: import('../editing/history.js').State | null } | null} */
  let held = null;
  /** @param {PointerEvent} event */
  function follow(event) {
    const box = ring.getBoundingClientRect();
    // The faces stand on a circle of 38 % of the box.
    moveTo((event.clientX - box.left - box.width / 2) / (0.38 * box.width), (event.clientY - box.top - box.height / 2) / (0.38 * box.height));
  }
  ring.addEventListener('pointerdown', (event) => {
    // One face alone has nothing between it and another.
    if (members.length < 2) return;
    if (event.button !== 0 || held || !(event.target instanceof Element) || event.target.closest('button')) return;
    event.preventDefault();
    puck.focus({ preventScroll: true });
    ring.setPointerCapture(event.pointerId);
    held = { pointer: event.pointerId, from: at, counted: base };
    follow(event);
  });
  ring.addEventListener('pointermove', (event) => held?.pointer === event.pointerId && follow(event));
  ring.addEventListener('pointerup', (event) => {
    if (held?.pointer !== event.pointerId) return;
    held = null;
    finish();
  });
  ring.addEventListener('pointercancel', (event) => held?.pointer === event.pointerId && cancel());

  /** @param {typeof members} now in the circle: a place is another mixture then */
  function gather(now) {
    members = now;
    at = [0, 0];
    stood.clear();
    build();
  }
  function build() {
    const on = places(members.length);
    ring.replaceChildren(
      ...members.map(({ entry }, i) => {
        const node = element(
          'button',
          {
            type: 'button',
            'aria-label': text.outOfCircle(entry.name),
            title: text.outOfCircle(entry.name),
            onclick: () => {
              members.find((member) => member.entry.id === entry.id)?.whole.free();
              gather(members.filter((member) => member.entry.id !== entry.id));
              (ring.querySelector('button') ?? heading).focus();
            },
          },
          portraits.of(entry),
        );
        const place = element('div', { class: 'member' }, node, element('span', { class: 'share', 'aria-hidden': 'true' }));
        place.style.setProperty('--x', String(on[i][0]));
        place.style.setProperty('--y', String(on[i][1]));
        return place;
      }),
      ...(members.length > 1 ? [puck] : []),
    );
    ring.hidden = members.length === 0;
    about.textContent = members.length === 0 ? text.circleEmpty : members.length === 1 ? text.circleOne : tapping(text.circleAbout);
    refresh();
  }
  const heading = element('h3', { tabindex: -1 }, text.circle);
  const about = element('p', { class: 'note' });
  const root = element('section', { class: 'part circle', 'aria-label': text.circle }, heading, about, ring);
  build();
  // Who is called something else is the same face.
  library.onChange(() => {
    if (!members.some(({ entry }) => (library.find(entry.id)?.name ?? entry.name) !== entry.name)) return;
    members = members.map(({ entry, whole }) => ({ entry: library.find(entry.id) ?? entry, whole }));
    build();
  });

  return {
    root,
    /** @param {import('../keep/library.js').Entry} entry */
    add(entry) {
      if (members.some((member) => member.entry.id === entry.id)) return say(text.inCircle(entry.name));
      if (members.length === MOST) return say(tapping(text.circleFull));
      const whole = model.face();
      whole.code = entry.code;
      gather([...members, { entry, whole }]);
      root.scrollIntoView({ block: 'nearest' });
      say(text.circled(entry.name, members.length));
    },
  };
}
