import { element } from '../frame/element.js';
import { text } from '../text.js';

/** How far a pointer goes before a press becomes a drag, px. */
const REACH = 8;

/**
 * The faces side by side: one can be chosen, or dragged onto the head.
 *
 * @param {{
 *   library: import('../keep/library.js').Library,
 *   portraits: import('../stage/portraits.js').Portraits,
 *   groupUnder: (event: PointerEvent) => string | null,
 *   preview: (group: string | null) => void,
 *   choose: (entry: import('../keep/library.js').Entry | null) => void,
 *   drop: (entry: import('../keep/library.js').Entry, group: string) => void,
 * }} on
 */
export function createTray({ library, portraits, groupUnder, preview, choose, drop }) {
  const root = element('div', { class: 'tray', role: 'group', 'aria-label': text.tray });
  /** @type {string | null} */
  let marked = null;
  let visible = false;

  /** @param {import('../keep/library.js').Entry} entry */
  function item(entry) {
    /** @type {{ pointer: number, x: number, y: number, ghost: HTMLElement | null } | null} */
    let drag = null;
    let dragged = false;
    const button = element(
      'button',
      {
        type: 'button',
        class: 'tray-face',
        'data-id': entry.id,
        'aria-pressed': String(entry.id === marked),
        onclick: () => {
          if (!dragged) choose(entry.id === marked ? null : entry);
          dragged = false;
        },
      },
      portraits.of(entry),
      element('span', {}, entry.name),
    );
    const heard = /** @type {const} */ ([['pointermove', follow], ['pointerup', letGo], ['pointercancel', giveUp]]);
    function end() {
      drag?.ghost?.remove();
      drag = null;
      preview(null);
      for (const [type, listener] of heard) window.removeEventListener(type, listener, true);
      document.removeEventListener('keydown', escape, true);
    }
    /** @param {KeyboardEvent} event */
    function escape(event) {
      if (event.key === 'Escape') end();
    }
    button.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || drag) return;
      dragged = false;
      drag = { pointer: event.pointerId, x: event.clientX, y: event.clientY, ghost: null };
      button.setPointerCapture(event.pointerId);
      // Wherever it goes, and whether the button is still there then: another tab may have saved a face meanwhile.
      for (const [type, listener] of heard) window.addEventListener(type, listener, true);
    });
    /** @param {PointerEvent} event */
    function follow(event) {
      if (drag?.pointer !== event.pointerId) return;
      if (!drag.ghost) {
        if (Math.hypot(event.clientX - drag.x, event.clientY - drag.y) < REACH) return;
        dragged = true;
        drag.ghost = element('div', { class: 'drag-face' }, portraits.of(entry));
        document.body.append(drag.ghost);
        document.addEventListener('keydown', escape, true);
      }
      drag.ghost.style.translate = `${event.clientX}px ${event.clientY}px`;
      preview(groupUnder(event));
    }
    /** @param {PointerEvent} event */
    function letGo(event) {
      if (drag?.pointer !== event.pointerId) return;
      const group = drag.ghost ? groupUnder(event) : null;
      end();
      if (group) drop(entry, group);
    }
    /** @param {PointerEvent} event */
    function giveUp(event) {
      if (drag?.pointer === event.pointerId) end();
    }
    return button;
  }

  /** @param {import('../keep/library.js').Entry | null} entry */
  function mark(entry) {
    marked = entry?.id ?? null;
    for (const button of root.querySelectorAll('button')) {
      button.setAttribute('aria-pressed', String(button.dataset.id === marked));
    }
  }
  function build() {
    if (!visible) return;
    root.replaceChildren(...library.all.map(item));
    if (marked && !library.find(marked)) choose(null);
  }
  library.onChange(build);

  return {
    root,
    mark,
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      build();
    },
  };
}
