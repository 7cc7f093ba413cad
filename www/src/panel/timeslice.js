// Long work in slices, so that the page goes on beside it.

/** Of work before others have their turn, ms. */
const SLICE = 24;
/** Where one frame takes longer than that, work is let go on for as long as others did, up to this: else a frame would be drawn a slice. */
const LONG_SLICE = 200;

/** @returns {() => Promise<void>} to be awaited between small parts of the work */
export function createTimeslices() {
  let since = performance.now();
  let slice = SLICE;
  return async () => {
    const until = performance.now();
    if (until - since < slice) return;
    // Not when the page is idle: while the stage draws it never is, and somebody waits.
    await new Promise((done) => setTimeout(done));
    since = performance.now();
    slice = Math.min(LONG_SLICE, Math.max(SLICE, since - until));
  };
}
