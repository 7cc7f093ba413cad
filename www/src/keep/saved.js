import { part } from '../frame/download.js';
import { element } from '../frame/element.js';
import { faceFile, facesFile, readFaceFile } from './facefile.js';
import { mayBePicture } from '../frame/filekind.js';
import { icon } from '../frame/icons.js';
import { isComposing } from '../frame/keys.js';
import { among, shows } from '../head/expression.js';
import { fileName, save } from './save.js';
import { text } from '../text.js';

/** How the names of faces' files end. */
const FACE = 'phiz.json';

/**
 * The person's own faces: save under a name, open, rename, delete, to and from files.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   library: import('./library.js').Library,
 *   portraits: import('../stage/portraits.js').Portraits,
 *   display: import('../stage/display.js').Display,
 *   canvas: HTMLCanvasElement,
 *   expressions: { load: () => Promise<void> },
 *   say: (sentence: string) => void,
 * }} parts
 */
export function createSaved(editor, { library, portraits, display, canvas, expressions, say }) {
  const { model } = editor;
  let visible = false;
  /** Whether it was said that some faces cannot be shown. */
  let told = false;
  /** What was deleted since the page was opened, and how many stood after it. @type {{ entry: import('./library.js').Entry, after: number }[]} */
  const removed = [];
  /** What was saved last under a name that another has, and may take the place of that one. @type {{ name: string, older: string, newer: string } | null} */
  let namesake = null;
  /** @type {string | null} */
  let renaming = null;
  /** Whether a pointer is down, and whether the list waits for what it does. */
  let [pressing, waiting] = [false, false];

  const name = element('input', { type: 'text', id: 'save-name', maxlength: 60, autocomplete: 'off', placeholder: text.namePlaceholder });
  const form = element(
    'form',
    {
      class: 'save',
      onsubmit: (/** @type {SubmitEvent} */ event) => {
        event.preventDefault();
        const wanted = name.value.trim() || library.freeName;
        const chosen = library.freeNameLike(wanted);
        const older = library.own.find((entry) => entry.name === wanted);
        say(library.add({ name: chosen, ...editor.likeness }) ? text.saved(chosen, wanted) : text.notKept);
        namesake = older ? { name: wanted, older: older.id, newer: library.own[0].id } : null;
        name.value = '';
        build();
      },
    },
    element('label', { for: 'save-name' }, text.saveAs),
    element('span', { class: 'seed-row' }, name, element('button', { class: 'button primary' }, text.save)),
  );
  const list = element('ul', { class: 'saved', 'aria-label': text.ownFaces });
  const nothing = element('p', { class: 'note' }, text.noFaces);
  const sheet = element('button', { type: 'button', class: 'button', title: text.sheetAbout, onclick: saveSheet }, icon('download'), text.sheet);
  const all = element(
    'button',
    {
      type: 'button',
      class: 'button',
      title: text.downloadAllAbout,
      onclick: () => save(facesFile(model, library.own, library.unread), fileName(text.sheetName, FACE)),
    },
    icon('download'),
    text.downloadAll,
  );
  const ofAll = element('div', { class: 'row', hidden: true }, sheet, all);
  const restoreNote = element('p', { class: 'note restore', hidden: true });
  const replaceNote = element('p', { class: 'note restore', hidden: true });
  const picker = element('input', {
    type: 'file',
    accept: '.json,application/json',
    multiple: true,
    hidden: true,
    'aria-label': text.importFace,
    onchange: async () => {
      await take([...(picker.files ?? [])]);
      picker.value = '';
    },
  });

  /**
   * One step: this face, with the expression that it was kept with.
   * @param {import('./library.js').Likeness} kept
   * @returns {Promise<string | null>} why its expression could not be shown, or nothing; null when another face was asked for meanwhile
   */
  async function become({ code, expression, colouring }) {
    if (shows(expression)) {
      const isNewest = editor.ask();
      try {
        await expressions.load();
        if (!isNewest()) return null;
      } catch {
        if (!isNewest()) return null;
        editor.take({ code, expression: {}, colouring });
        return text.noSavedExpression;
      }
    }
    editor.take({ code, expression: expression && among(expression, model.expressions), colouring });
    return '';
  }
  /** @param {import('./library.js').Likeness} kept */
  async function show(kept) {
    const why = await become(kept);
    if (why) say(why);
  }

  /** Of several, what is said of one does not take the place of what is said of another. @param {File[]} files */
  async function take(files) {
    let [added, known, unread, newer] = [0, 0, 0, 0];
    /** What is said of a face that is opened alone. @type {string | null} */
    let alone = null;
    /** @type {Set<string>} */
    const wrong = new Set();
    for (const file of files) {
      try {
        const found = await readFaceFile(model, file);
        const isSingle = !('faces' in found);
        const faces = isSingle ? [found] : found.faces;
        // What is there already is not there twice.
        const fresh = faces.filter((face) => !library.has(face));
        if (fresh.length > 0 && !library.add(...fresh)) wrong.add(text.notKept);
        const [{ name }] = library.all;
        added += fresh.length;
        known += faces.length - fresh.length;
        if (!isSingle) {
          // What is kept is brought back: the face stays that is worked on.
          unread += found.unread;
          newer += found.newer;
          continue;
        }
        const why = await become(found);
        // Who asked for another face meanwhile looks at that.
        alone = why === null ? '' : fresh.length > 0 ? text.imported(name) : text.importedKnown(found.name);
        if (why) wrong.add(why);
      } catch (error) {
        wrong.add(error instanceof Error ? error.message : String(error));
      }
    }
    const isOne = files.length === 1;
    const all = isOne && alone !== null ? alone : text.importedAll(added, known, unread, newer);
    // Of one face what went wrong is all that there is to say; of several, how many are there all the same.
    const said = wrong.size === 0 ? [all] : isOne || added + known + unread + newer === 0 ? [...wrong] : [all, ...wrong];
    if (said.join('') !== '') say(said.join(' '));
  }

  async function saveSheet() {
    const faces = library.own;
    sheet.disabled = true;
    say(text.exporting);
    try {
      // Without them those that have one are at rest.
      if (faces.some(({ expression }) => shows(expression))) await expressions.load().catch(() => {});
      const { sheetOf } = await part(() => import('./sheet.js'));
      const file = fileName(text.sheetName, 'png');
      save(await sheetOf(faces, model, display, canvas), file);
      say(text.sheetSaved(faces.length, file));
    } catch (error) {
      say(text.notExported(error instanceof Error ? error.message : String(error)));
    }
    sheet.disabled = false;
  }

  /** @param {import('./library.js').Entry} entry */
  function row(entry) {
    const { id } = entry;
    /** @param {Parameters<typeof icon>[0]} sign @param {string} words @param {() => void} onclick */
    const tool = (sign, words, onclick) =>
      element('button', { type: 'button', class: 'tool', 'aria-label': words, title: words, onclick }, icon(sign));
    if (renaming === id) {
      const box = element('input', { type: 'text', maxlength: 60, value: entry.name, 'aria-label': text.rename(entry.name) });
      /** @param {boolean} keep */
      const done = (keep) => {
        renaming = null;
        const wanted = box.value.trim();
        const chosen = library.freeNameLike(wanted, id);
        if (!keep || !wanted || chosen === entry.name) return build();
        if (!library.rename(id, chosen)) say(text.notKept);
        else if (chosen !== wanted) say(text.saved(chosen, wanted));
      };
      box.addEventListener('keydown', (event) => {
        if (renaming !== id || isComposing(event) || (event.key !== 'Enter' && event.key !== 'Escape')) return;
        done(event.key === 'Enter');
        /** @type {HTMLElement | null} */ (list.querySelector(`[data-id="${id}"] button`))?.focus();
      });
      box.addEventListener('blur', () => {
        if (renaming !== id) return;
        wait();
        done(true);
      });
      return element('li', { 'data-id': id }, portraits.of(entry), box);
    }
    return element(
      'li',
      { 'data-id': id },
      element(
        'button',
        { type: 'button', class: 'open', 'aria-label': text.open(entry.name), title: text.open(entry.name), onclick: () => show(entry) },
        portraits.of(entry),
        element('span', {}, entry.name),
      ),
      tool('rename', text.rename(entry.name), () => {
        renaming = id;
        build();
        const box = /** @type {HTMLInputElement | null} */ (list.querySelector('input'));
        box?.focus();
        box?.select();
      }),
      tool('download', text.downloadFace(entry.name), () => save(faceFile(model, entry), fileName(entry.name, FACE))),
      tool('bin', text.remove(entry.name), () => {
        discard(entry);
      }),
    );
  }

  /** @param {import('./library.js').Entry} entry */
  function discard(entry) {
    removed.push({ entry, after: library.own.length - 1 - library.own.findIndex(({ id }) => id === entry.id) });
    library.remove(entry.id);
    restoreNote.querySelector('button')?.focus();
  }

  /** Whoever saves while they work wants the newest of a name: the older one goes, and can be brought back as any. */
  function offerToReplace() {
    const [older, newer] = [namesake?.older, namesake?.newer].map((id) => library.own.find((entry) => entry.id === id));
    replaceNote.hidden = true;
    // Either may have got another name meanwhile.
    if (!older || !newer || older.name !== namesake?.name) return;
    const { name } = older;
    replaceNote.hidden = false;
    replaceNote.replaceChildren(
      element(
        'button',
        {
          type: 'button',
          class: 'link',
          onclick: () => {
            const isKept = library.rename(newer.id, name);
            discard(older);
            say(isKept ? text.replaced(name) : text.notKept);
          },
        },
        text.replace(name),
      ),
    );
  }

  /** Who ends a name by pressing something means what is pressed: the list stays as it is until that is clicked. */
  function wait() {
    waiting = true;
    const end = () => {
      if (!waiting) return;
      waiting = false;
      build();
    };
    // Before the click's own listeners, which have the list as it is to be.
    window.addEventListener('click', end, { capture: true, once: true });
    const late = () => setTimeout(end);
    if (!pressing) return void late();
    for (const over of ['pointerup', 'pointercancel']) window.addEventListener(over, late, { once: true });
  }
  for (const [name, now] of /** @type {const} */ ([['pointerdown', true], ['pointerup', false], ['pointercancel', false]])) {
    window.addEventListener(name, () => (pressing = now), true);
  }

  function build() {
    if (!visible || waiting) return;
    // Nor is it taken from who types a name when another tab saves: it is built when that is done.
    const typed = list.querySelector('input')?.closest('li')?.dataset.id;
    if (typed !== undefined && typed === renaming && library.find(typed)) return;
    // What has the focus has it in the new list.
    const rows = () => [.../** @type {HTMLCollectionOf<HTMLElement>} */ (list.children)];
    const there = rows().find((one) => one.contains(document.activeElement));
    const at = [...(there?.querySelectorAll('button') ?? [])].findIndex((button) => button === document.activeElement);
    list.replaceChildren(...library.own.map(row));
    if (there) rows().find((one) => one.dataset.id === there.dataset.id)?.querySelectorAll('button')[at]?.focus();
    nothing.hidden = library.own.length > 0;
    sheet.hidden = !nothing.hidden;
    ofAll.hidden = library.own.length + library.unread.length === 0;
    offerToReplace();
    const last = removed.at(-1);
    restoreNote.hidden = last === undefined;
    restoreNote.replaceChildren();
    if (last) {
      const { entry, after } = last;
      restoreNote.append(
        text.removed(entry.name),
        ' ',
        element(
          'button',
          {
            type: 'button',
            class: 'link',
            onclick: () => {
              removed.pop();
              const name = library.freeNameLike(entry.name);
              if (!library.putBack({ ...entry, name }, after)) say(text.notKept);
              else if (name !== entry.name) say(text.saved(name, entry.name));
              /** @type {HTMLElement | null} */ (list.querySelector(`[data-id="${entry.id}"] button`))?.focus();
            },
          },
          text.undo,
        ),
      );
    }
  }
  library.onChange(build);

  // A file can also be dropped anywhere on the page.
  window.addEventListener('dragover', (event) => {
    if (event.dataTransfer?.types.includes('Files')) event.preventDefault();
  });
  window.addEventListener('drop', (event) => {
    // All else is the photo section's.
    const files = [...(event.dataTransfer?.files ?? [])].filter((file) => !mayBePicture(file));
    if (files.length === 0) return;
    event.preventDefault();
    void take(files);
  });

  const root = element(
    'div',
    {},
    element(
      'div',
      { class: 'scroll' },
      form,
      replaceNote,
      restoreNote,
      nothing,
      list,
      ofAll,
      element(
        'section',
        { class: 'part' },
        element('h3', {}, text.files),
        element('p', { class: 'note' }, text.filesAbout),
        element(
          'div',
          { class: 'row' },
          element(
            'button',
            {
              type: 'button',
              class: 'button',
              onclick: () => {
                const chosen = name.value.trim() || library.nameOf(editor.likeness) || text.thisFace;
                save(faceFile(model, { name: chosen, ...editor.likeness }), fileName(chosen, FACE));
              },
            },
            icon('download'),
            text.downloadThis,
          ),
          element('button', { type: 'button', class: 'button', onclick: () => picker.click() }, icon('upload'), text.importFace),
          picker,
        ),
      ),
    ),
  );
  return {
    root,
    /** @param {boolean} now */
    shown(now) {
      visible = now;
      build();
      if (!visible || told || library.unread.length === 0) return;
      told = true;
      say(text.unreadFaces(library.unread.length));
    },
  };
}
