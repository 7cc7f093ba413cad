/** @typedef {'light' | 'dark'} Theme */

const KEY = 'phiz-theme';

/** The system's choice, until a person makes their own. */
export function createTheme() {
  const system = window.matchMedia('(prefers-color-scheme: dark)');
  /** @type {Theme | null} */
  let own = null;
  try {
    const stored = localStorage.getItem(KEY);
    if (stored === 'light' || stored === 'dark') own = stored;
  } catch {
    // Storage may be forbidden; then the choice lasts as long as the page.
  }
  /** @type {Set<(theme: Theme) => void>} */
  const followers = new Set();
  /** @returns {Theme} */
  const present = () => own ?? (system.matches ? 'dark' : 'light');
  function apply() {
    document.documentElement.dataset.theme = present();
    for (const follow of followers) follow(present());
  }
  system.addEventListener('change', apply);
  apply();
  return {
    /** Tells what it is, now and whenever it changes. @param {(theme: Theme) => void} follower */
    follow(follower) {
      followers.add(follower);
      follower(present());
    },
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
