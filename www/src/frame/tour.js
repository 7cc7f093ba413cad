import { element } from './element.js';
import { icon } from './icons.js';
import { keep, recall } from '../store.js';
import { tapping, text } from '../text.js';

const KEY = 'phiz-toured';
const MARGIN = 12;

/**
 * A short look around: a card beside each thing in turn. Offered once, and never in the way.
 * @param {{ choose: (section: string) => void }} panel
 */
export function createTour(panel) {
  let steps = text.tourSteps;
  let at = 0;
  const ring = element('div', { class: 'tour-ring', hidden: true });
  const title = element('h2', { id: 'tour-title' });
  const words = element('p', {});
  const count = element('span', { class: 'note' });
  const back = element('button', { type: 'button', class: 'button', onclick: () => go(at - 1) }, text.previous);
  const next = element('button', { type: 'button', class: 'button primary', onclick: () => go(at + 1) });
  const card = element(
    'section',
    {
      class: 'tour-card',
      role: 'dialog',
      'aria-labelledby': 'tour-title',
      hidden: true,
      onkeydown: (/** @type {KeyboardEvent} */ event) => {
        if (event.key === 'Escape') end();
      },
    },
    element(
      'header',
      {},
      title,
      element('button', { type: 'button', class: 'tool', 'aria-label': text.close, onclick: end }, icon('close')),
    ),
    words,
    element('footer', {}, count, back, next),
  );
  const invitation = element(
    'p',
    { class: 'invitation', hidden: recall(KEY) === true },
    text.invitation,
    element('button', { type: 'button', class: 'link', onclick: start }, text.showAround),
    element('button', { type: 'button', class: 'tool small', 'aria-label': text.close, onclick: dismiss }, icon('close')),
  );

  function dismiss() {
    invitation.hidden = true;
    keep(KEY, true);
  }
  function start() {
    dismiss();
    // A model without expressions has no section for them.
    steps = text.tourSteps.filter(({ mode }) => document.getElementById(`mode-${mode}`));
    go(0);
  }
  function end() {
    ring.hidden = card.hidden = true;
    window.removeEventListener('resize', place);
    panel.choose('features');
    /** @type {HTMLElement | null} */ (document.querySelector('.view'))?.focus();
  }
  /** The first of what it tells of that can be seen: a section may have more of the kind, put away. */
  const told = () => [...document.querySelectorAll(steps[at].at)].find((one) => one.getClientRects().length > 0);
  /** @param {number} to */
  function go(to) {
    if (to < 0) return;
    if (to >= steps.length) return end();
    at = to;
    const step = steps[at];
    panel.choose(step.mode);
    told()?.scrollIntoView({ block: 'nearest' });
    title.textContent = step.title;
    words.textContent = tapping(step.words);
    count.textContent = text.step(at + 1, steps.length);
    back.disabled = at === 0;
    next.textContent = at === steps.length - 1 ? text.done : text.next;
    ring.hidden = card.hidden = false;
    window.addEventListener('resize', place);
    place();
    next.focus();
  }
  /** The card goes where there is room beside the thing: left, below, above, or onto it. */
  function place() {
    const target = told()?.getBoundingClientRect();
    if (!target) return;
    ring.style.left = `${target.left - 4}px`;
    ring.style.top = `${target.top - 4}px`;
    ring.style.width = `${target.width + 8}px`;
    ring.style.height = `${target.height + 8}px`;
    const { offsetWidth: width, offsetHeight: height } = card;
    let [left, top] = [target.left - width - 2 * MARGIN, target.top];
    if (left < MARGIN) {
      left = target.left + target.width / 2 - width / 2;
      // What is about the face leaves the tabs next to it free.
      top = target.height > window.innerHeight / 3 ? window.innerHeight - height - MARGIN : target.bottom + 2 * MARGIN;
      if (top + height > window.innerHeight - MARGIN || top < target.bottom) top = target.top - height - 2 * MARGIN;
      if (top < MARGIN) top = target.top + 64;
    }
    card.style.left = `${Math.max(MARGIN, Math.min(left, window.innerWidth - width - MARGIN))}px`;
    card.style.top = `${Math.max(MARGIN, Math.min(top, window.innerHeight - height - MARGIN))}px`;
  }

  return { invitation, parts: [ring, card], start };
}
