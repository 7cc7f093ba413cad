/**
 * A canvas in somebody's page, which goes on being scrolled over it: a wheel is the page's until the canvas was taken up, and a finger is
 * where it goes up or down. (The browser finds that out with its second event, so the first is held back.)
 * @param {HTMLCanvasElement} canvas
 * @param {{ isTaken: () => boolean, signal: AbortSignal }} options
 */
export function shareGestures(canvas, { isTaken, signal }) {
  // What turns the head wants all of them; now the style sheet says which, and a page may say otherwise.
  canvas.style.touchAction = '';
  /** A finger that did not go sideways yet. @type {PointerEvent | null} */
  let finger = null;
  const listen = { signal, capture: true };
  canvas.addEventListener(
    'pointerdown',
    (event) => {
      const scrolls = event.pointerType === 'touch' && getComputedStyle(canvas).touchAction !== 'none';
      // Two of them come closer.
      finger = scrolls && event.isPrimary ? event : null;
    },
    listen,
  );
  canvas.addEventListener(
    'pointermove',
    (event) => {
      if (finger?.pointerId !== event.pointerId) return;
      if (Math.abs(event.clientX - finger.clientX) > Math.abs(event.clientY - finger.clientY)) finger = null;
      else event.stopImmediatePropagation();
    },
    listen,
  );
  canvas.addEventListener('wheel', (event) => event.ctrlKey || event.metaKey || isTaken() || event.stopImmediatePropagation(), { ...listen, passive: true });
}
