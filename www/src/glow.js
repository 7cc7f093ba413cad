/**
 * What the pointer is on shows while it is there; what was picked glows once.
 *
 * @param {ReturnType<typeof import('./head.js').createHead>} head
 * @param {ReturnType<typeof import('./scene.js').createScene>} scene
 */
export function createGlow(head, scene) {
  const still = window.matchMedia('(prefers-reduced-motion: reduce)');
  let strength = 0;
  let goal = 0;
  let pick = 0;
  let last = 0;
  /** @type {string | null} */
  let hovered = null;

  scene.beforeFrame.add(() => {
    const now = performance.now();
    const elapsed = Math.min(50, now - last);
    last = now;
    const step = still.matches ? 1 : elapsed / 140;
    strength += Math.max(-step, Math.min(step, goal - strength));
    pick = Math.max(0, pick - elapsed / 900);
    head.markStrength[0] = strength;
    head.markStrength[1] = pick;
    if (strength !== goal || pick > 0) scene.invalidate();
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
    /** @param {string} group */
    flash(group) {
      head.highlight(1, group);
      pick = still.matches ? 0 : 1;
      scene.invalidate();
    },
  };
}
