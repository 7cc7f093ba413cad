// Here, since a sheet that did not come with its part is not asked for again.
import './photo.css';
import { part } from '../frame/download.js';
import { element } from '../frame/element.js';
import { mayBePicture } from '../frame/filekind.js';
import { text } from '../text.js';

/**
 * The panel's section for photos. What it takes comes when it is first wanted: who designs faces only
 * loads none of it.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {Omit<Parameters<typeof import('./room.js').createRoom>[1], 'panel'> & { choose: () => void }} parts
 *   `choose` brings the section to the front
 */
export function createPhotoTab(editor, parts) {
  const panel = element('div', { class: 'scroll' });
  const state = element('p', { class: 'note', role: 'status' });
  const retry = element('button', { type: 'button', class: 'button', hidden: true, onclick: () => void come() }, text.tryAgain);
  panel.append(state, retry);
  /** @type {Promise<ReturnType<typeof import('./room.js').createRoom>> | null} */
  let coming = null;
  /** @type {ReturnType<typeof import('./room.js').createRoom> | null} */
  let room = null;

  async function make() {
    state.textContent = text.photo.loading;
    retry.hidden = true;
    const { createRoom } = await part(() => import('./room.js'));
    room = createRoom(editor, { ...parts, panel });
    state.remove();
    retry.remove();
    return room;
  }
  /** What is to be opened once the room is there, which may take another try. @type {File | null} */
  let waiting = null;
  async function come() {
    coming ??= make();
    let there;
    try {
      there = await coming;
    } catch (error) {
      coming = null;
      state.textContent = text.photo.notLoaded(error instanceof Error ? error.message : String(error));
      retry.hidden = false;
      return;
    }
    const file = waiting;
    waiting = null;
    if (file) await there.open(file, file.name);
  }
  /** @param {Iterable<File> | undefined} files */
  function pictureAmong(files) {
    return [...(files ?? [])].find(mayBePicture);
  }
  /** @param {File} file */
  async function open(file) {
    waiting = file;
    parts.choose();
    await come();
  }
  // A photo can be dropped or pasted anywhere on the page.
  window.addEventListener('drop', (event) => {
    const file = pictureAmong(event.dataTransfer?.files);
    if (!file) return;
    event.preventDefault();
    void open(file);
  });
  window.addEventListener('paste', (event) => {
    const file = pictureAmong(event.clipboardData?.files);
    if (!file) return;
    // Tables and letters are copied as a picture, too: where words are typed, words are meant.
    const typed = event.target instanceof Element && event.target.closest('input:is([type=text], [type=number], :not([type])), textarea');
    if (typed && event.clipboardData?.types.includes('text/plain')) return;
    event.preventDefault();
    void open(file);
  });

  return {
    root: element('div', { class: 'photo-panel' }, panel),
    /** @param {boolean} now */
    shown(now) {
      if (now) void come();
    },
    /** The head is on the stage, for who wants what no photo shows. */
    reveal() {
      room?.reveal();
    },
    /** The head has the photo's colours on, if it is to, whether or not anybody looks at it. */
    async dress() {
      await room?.dress();
    },
    /** What the room knows, for automation; null before it was opened. */
    get state() {
      return room?.state ?? null;
    },
  };
}
