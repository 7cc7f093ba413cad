/** For how long what was picked shows, ms. On skin that is judged nothing may lie: a hint has its name for longer. */
const SHOWS = 1200;
/** How strongly, where nothing may move: it does not fade then. */
const STILL = 0.5;

/**
 * What the pointer is on shows while it is there; what was picked glows, and fades.
 *
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head
 * @param {ReturnType<typeof import('./scene.js').createScene>} scene
 */
export function createGlow(head, scene) {
  const still = window.matchMedia('(prefers-reduced-motion: reduce)');
  let strength = 0;
  let goal = 0;
  /** Until when what was picked shows. */
  let until = 0;
  let ending = 0;
  let last = 0;
  /** @type {string | null} */
  let hovered = null;

  scene.beforeFrame.add(() => {
    const now = performance.now();
    const elapsed = Math.min(50, now - last);
    last = now;
    const step = still.matches ? 1 : elapsed / 140;
    strength += Math.max(-step, Math.min(step, goal - strength));
    const pick = Math.max(0, until - now) / SHOWS;
    head.markStrength[0] = head.unmarked ? 0 : strength;
    head.markStrength[1] = head.unmarked ? 0 : still.matches && until ? STILL : pick;
    if (strength !== goal || (pick > 0 && !still.matches)) scene.invalidate();
  });

  /** @param {string | null} group */
  function hover(group) {
    if (group === hovered) return;
    hovered = group;
    if (group) head.highlight(0, group);
    goal = group ? 1 : 0;
    scene.invalidate();
  }
  /** @param {string | null} group */
  function select(group) {
    if (group) head.highlight(1, group);
    until = group ? performance.now() + SHOWS : 0;
    scene.invalidate();
    clearTimeout(ending);
    if (group && still.matches) ending = window.setTimeout(select, SHOWS, null);
  }
  return { hover, select };
}
