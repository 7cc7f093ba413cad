import { decodeColouring, decodeExpression, encodeColouring, encodeExpression, joinHash, splitHash } from './addresscode.js';
import { text } from '../text.js';

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
  function write() {
    const parts = shown();
    window.history.replaceState(null, '', link({ ...parts, code: parts.code === median ? '' : parts.code }));
  }
  editor.onStep(write);
  window.addEventListener('hashchange', async () => {
    const asked = splitHash(location.hash);
    asked.code ||= median;
    const isNewest = editor.ask();
    if (joinHash(asked) === joinHash(shown())) return;
    try {
      if (asked.expression) await expressions.load();
      if (!isNewest()) return;
      editor.take({
        code: asked.code,
        expression: decodeExpression(model.expressions, asked.expression),
        colouring: decodeColouring(asked.colouring),
      });
    } catch {
      if (isNewest()) say(text.badCode);
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
