// Which tabs of the page there are. Each holds a lock of its own for as long as it is there, which a browser takes from those that are
// closed, or fall.

/** @param {string} key @returns {string | null} */
function ofThisTab(key) {
  try {
    return sessionStorage.getItem(key);
  } catch {
    return null;
  }
}

/**
 * Gives this tab a name, which it has when it is loaded again, too.
 * @param {string} start how all names begin
 * @returns {Promise<{ name: string, present: () => Promise<Set<string>> } | null>} `present` are the names of tabs that are there;
 *   null where a browser does not tell
 */
export async function nameTab(start) {
  const { locks } = navigator;
  if (!locks) return null;
  const newName = () => `${start}${Date.now().toString(36)}-${Math.random().toString(36).slice(2, 7)}`;
  let release = () => {};
  /** @param {string} name @returns {Promise<boolean>} whether it is this tab's now */
  const hold = (name) =>
    new Promise((done, failed) => {
      const held = locks.request(name, { ifAvailable: true }, (lock) => {
        done(lock !== null);
        return lock && new Promise((over) => (release = () => over(undefined)));
      });
      held.catch(failed);
    });
  let name = ofThisTab(start) ?? newName();
  try {
    // A tab that was made as a copy of another one brings that one's name.
    if (!(await hold(name))) await hold((name = newName()));
    sessionStorage.setItem(start, name);
  } catch {
    return null;
  }
  // A page that holds a lock is not put away to come back as it was.
  window.addEventListener('pagehide', () => release());
  window.addEventListener('pageshow', ({ persisted }) => persisted && void hold(name).catch(() => {}));
  return {
    name,
    async present() {
      const { held = [] } = await locks.query();
      return new Set(held.map((lock) => lock.name ?? ''));
    },
  };
}
