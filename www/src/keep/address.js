import { decodeColouring, decodeExpression, encodeColouring, encodeExpression, joinHash, splitHash } from './addresscode.js';
import { locksOf, readLocks } from './locks.js';
import { text } from '../text.js';

/** After so long an address that the browser did not take is offered again, ms: Safari takes a hundred in half a minute. */
const LATER = 2000;

/** What was locked in this tab when the page was loaded again; null in a tab that comes to its address for the first time. */
export function locksOfTab() {
  const state = window.history.state;
  return state === null ? null : readLocks(state);
}

/**
 * The whole face in the page's address, with its expression and its colours: kept as it changes, followed when it
 * is edited.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{ load: () => Promise<void> }} expressions
 * @param {(sentence: string) => void} say
 */
export function createAddress(editor, expressions, say) {
  const { model, face } = editor;
  const fresh = model.face();
  const median = fresh.code;
  fresh.free();

  const shown = () => ({
    code: face.code,
    expression: editor.awaited || encodeExpression(model.expressions, face.expression),
    colouring: encodeColouring(editor.colouring),
  });
  /** @param {ReturnType<typeof shown>} parts */
  function link(parts) {
    const url = new URL(location.href);
    url.hash = joinHash(parts);
    return url;
  }
  let later = 0;
  function write() {
    window.clearTimeout(later);
    const parts = shown();
    try {
      window.history.replaceState(locksOf(face), '', link({ ...parts, code: parts.code === median ? '' : parts.code }));
    } catch {
      later = window.setTimeout(write, LATER);
    }
  }
  editor.onStep(write);
  window.addEventListener('hashchange', async () => {
    const asked = splitHash(location.hash);
    asked.code ||= median;
    const isNewest = editor.ask();
    if (joinHash(asked) === joinHash(shown())) return;
    /** @param {string} sentence */
    const refuse = (sentence) => {
      write();
      say(sentence);
    };
    try {
      if (asked.expression) await expressions.load();
    } catch {
      return isNewest() && refuse(text.noExpressionHere);
    }
    if (!isNewest()) return;
    let unread = '';
    /** What of a link can be read is taken. @template T @param {() => T} read @param {T} otherwise @param {string} sentence */
    const attempt = (read, otherwise, sentence) => {
      try {
        return read();
      } catch {
        unread = sentence;
        return otherwise;
      }
    };
    try {
      editor.take({
        code: asked.code,
        expression: attempt(() => decodeExpression(model.expressions, asked.expression), {}, text.badExpression),
        colouring: attempt(() => decodeColouring(asked.colouring), {}, text.badColours),
      });
      if (unread) say(unread);
    } catch {
      refuse(text.badCodeHere);
    }
  });

  return {
    write,
    async copy() {
      const { href } = link(shown());
      try {
        await navigator.clipboard.writeText(href);
        say(text.linkCopied);
      } catch {
        // Without permission or a secure origin there is no clipboard: let the person copy it.
        window.prompt(text.linkManual, href);
      }
    },
  };
}
