/** @typedef {'light' | 'dark'} Theme */

const KEY = 'phiz-theme';

/**
 * The system's choice, until a person makes their own.
 * @param {(theme: Theme) => void} changed
 */
export function createTheme(changed) {
  const system = window.matchMedia('(prefers-color-scheme: dark)');
  /** @type {Theme | null} */
  let own = null;
  try {
    const stored = localStorage.getItem(KEY);
    if (stored === 'light' || stored === 'dark') own = stored;
  } catch {
    // Storage may be forbidden; then the choice lasts as long as the page.
  }
  /** @returns {Theme} */
  const present = () => own ?? (system.matches ? 'dark' : 'light');
  function apply() {
    document.documentElement.dataset.theme = present();
    changed(present());
  }
  system.addEventListener('change', apply);
  apply();
  return {
    toggle() {
      own = present() === 'dark' ? 'light' : 'dark';
      try {
        localStorage.setItem(KEY, own);
      } catch {
        // As above.
      }
      apply();
    },
  };
}
