import { text } from './text.js';

/**
 * The whole face in the page's address: kept as it changes, followed when it is edited.
 *
 * @param {import('./editor.js').Editor} editor
 * @param {(sentence: string) => void} say
 */
export function createAddress(editor, say) {
  const { model, face } = editor;
  const fresh = model.face();
  const median = fresh.code;
  fresh.free();

  function link() {
    const code = face.code;
    const url = new URL(location.href);
    url.hash = code === median ? '' : code;
    return url;
  }
  const write = () => window.history.replaceState(null, '', link());
  editor.onStep(write);
  window.addEventListener('hashchange', () => {
    const code = location.hash.slice(1) || median;
    if (code === face.code) return;
    try {
      editor.take(code);
    } catch {
      say(text.badCode);
    }
  });

  return {
    write,
    async copy() {
      const url = new URL(location.href);
      url.hash = face.code;
      try {
        await navigator.clipboard.writeText(url.href);
        say(text.linkCopied);
      } catch {
        // Without permission or a secure origin there is no clipboard: let the person copy it.
        window.prompt(text.linkManual, url.href);
      }
    },
  };
}
