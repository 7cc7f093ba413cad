import { decodeExpression, encodeExpression, splitHash } from './expressioncode.js';
import { text } from './text.js';

/**
 * The whole face in the page's address, with its expression: kept as it changes, followed when it
 * is edited.
 *
 * @param {import('./editor.js').Editor} editor
 * @param {{ load: () => Promise<void> }} expressions
 * @param {(sentence: string) => void} say
 */
export function createAddress(editor, expressions, say) {
  const { model, face } = editor;
  const fresh = model.face();
  const median = fresh.code;
  fresh.free();

  /** @param {string} code */
  function link(code) {
    const shown = encodeExpression(model.expressions, face.expression);
    const url = new URL(location.href);
    url.hash = shown ? `${code}~${shown}` : code;
    return url;
  }
  const write = () => window.history.replaceState(null, '', link(face.code === median ? '' : face.code));
  editor.onStep(write);
  window.addEventListener('hashchange', async () => {
    const asked = splitHash(location.hash);
    const code = asked.code || median;
    if (code === face.code && asked.expression === encodeExpression(model.expressions, face.expression)) return;
    try {
      if (asked.expression) await expressions.load();
      editor.take(code, decodeExpression(model.expressions, asked.expression));
    } catch {
      say(text.badCode);
    }
  });

  return {
    write,
    async copy() {
      const { href } = link(face.code);
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
