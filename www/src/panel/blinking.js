/** A blink, ms: the lids fall in about a third of it (Evinger et al. 1991, "Eyelid movements"). */
const FALL = 90;
const RISE = 170;
/** Between two, ms: people who look ahead blink some fifteen times a minute, never evenly. */
const BETWEEN = [2200, 6000];

/**
 * How far the lids are shut so many ms after a blink began, 0 to 1.
 * @param {number} time
 */
function shutAt(time) {
  const part = time < FALL ? time / FALL : 1 - (time - FALL) / RISE;
  const held = Math.min(1, Math.max(0, part));
  return held * held * (3 - 2 * held);
}

/**
 * The shown face blinks now and then, and is not changed by it: what is saved, shared or undone knows
 * nothing of it. Who asks for less motion sees none.
 *
 * @param {{ shut: (amount: number) => boolean }} display
 */
export function createBlinking(display) {
  const still = window.matchMedia('(prefers-reduced-motion: reduce)');
  let timer = 0;
  let frame = 0;

  function wait() {
    const [least, most] = BETWEEN;
    timer = window.setTimeout(blink, least + (most - least) * Math.random());
  }
  function blink() {
    let start = performance.now();
    let closed = false;
    const step = (/** @type {number} */ now) => {
      // Where frames are few, one of them has the lids shut all the same.
      if (!closed && now - start >= FALL) {
        closed = true;
        start = now - FALL;
      }
      const over = now - start >= FALL + RISE;
      // What holds the lids, such as a comparison, ends this one.
      const shown = display.shut(over ? 0 : shutAt(now - start));
      if (over || !shown) return wait();
      frame = requestAnimationFrame(step);
    };
    frame = requestAnimationFrame(step);
  }
  function stop() {
    clearTimeout(timer);
    cancelAnimationFrame(frame);
    timer = frame = 0;
    display.shut(0);
  }

  let wanted = false;
  function apply() {
    if (timer) stop();
    if (wanted && !still.matches) wait();
  }
  still.addEventListener('change', apply);

  return {
    /** @param {boolean} on */
    set(on) {
      wanted = on;
      apply();
    },
  };
}
