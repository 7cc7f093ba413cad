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
  /** What is to be opened once the room is there, which may take another try. @type {File[]} */
  let waiting = [];
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
    const files = waiting;
    waiting = [];
    if (files.length > 0) await there.openAll(files);
  }
  /** @param {Iterable<File> | undefined} files */
  const picturesAmong = (files) => [...(files ?? [])].filter(mayBePicture);
  /** @param {File[]} files */
  async function open(files) {
    waiting = files;
    parts.choose();
    await come();
  }
  // Photos can be dropped or pasted anywhere on the page: several are of one person.
  window.addEventListener('drop', (event) => {
    const files = picturesAmong(event.dataTransfer?.files);
    if (files.length === 0) return;
    event.preventDefault();
    void open(files);
  });
  window.addEventListener('paste', (event) => {
    const files = picturesAmong(event.clipboardData?.files);
    if (files.length === 0) return;
    // Tables and letters are copied as a picture, too: where words are typed, words are meant.
    const typed = event.target instanceof Element && event.target.closest('input:is([type=text], [type=number], :not([type])), textarea');
    if (typed && event.clipboardData?.types.includes('text/plain')) return;
    event.preventDefault();
    void open(files);
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
