/** How strongly what is selected shows. */
const SELECTED = 0.5;

/**
 * What the pointer is on shows while it is there; what was picked glows, and stays marked while it is
 * selected.
 *
 * @param {ReturnType<typeof import('../head/head.js').createHead>} head
 * @param {ReturnType<typeof import('./scene.js').createScene>} scene
 */
export function createGlow(head, scene) {
  const still = window.matchMedia('(prefers-reduced-motion: reduce)');
  let strength = 0;
  let goal = 0;
  let pick = 0;
  /** What the glow falls to. */
  let floor = 0;
  let last = 0;
  /** @type {string | null} */
  let hovered = null;

  scene.beforeFrame.add(() => {
    const now = performance.now();
    const elapsed = Math.min(50, now - last);
    last = now;
    const step = still.matches ? 1 : elapsed / 140;
    strength += Math.max(-step, Math.min(step, goal - strength));
    pick = Math.max(floor, pick - elapsed / 900);
    head.markStrength[0] = strength;
    head.markStrength[1] = pick;
    if (strength !== goal || pick > floor) scene.invalidate();
  });

  return {
    /** @param {string | null} group */
    hover(group) {
      if (group === hovered) return;
      hovered = group;
      if (group) head.highlight(0, group);
      goal = group ? 1 : 0;
      scene.invalidate();
    },
    /** @param {string | null} group */
    select(group) {
      if (group) head.highlight(1, group);
      floor = group ? SELECTED : 0;
      pick = group && !still.matches ? 1 : floor;
      scene.invalidate();
    },
  };
}
