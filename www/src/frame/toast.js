import { element } from './element.js';

/** How long it is there at the least, and for each letter: who reads slowly reads twelve in a second; ms. */
const [LEAST, LETTER] = [4200, 80];

/** A sentence that goes away by itself. */
export function createToast() {
  const root = element('p', { class: 'toast', role: 'status' });
  let timer = 0;
  return {
    root,
    /** @param {string} sentence nothing takes the last one away */
    say(sentence) {
      root.textContent = sentence;
      root.classList.toggle('is-shown', sentence !== '');
      clearTimeout(timer);
      timer = window.setTimeout(() => root.classList.remove('is-shown'), Math.max(LEAST, LETTER * sentence.length));
    },
  };
}
