import './exports.css';
import { createDialog } from '../frame/dialog.js';
import { part } from '../frame/download.js';
import { element } from '../frame/element.js';
import { portrait } from '../stage/portrait.js';
import { fileName, save } from './save.js';
import { text } from '../text.js';

/** Media types by ending. */
const MESHES = { glb: 'model/gltf-binary', obj: 'model/obj', ply: 'model/ply', stl: 'model/stl' };
/** The largest picture that is offered; most graphics cards draw it. */
const LARGEST = 8192;

/**
 * The dialog from which a face leaves the page, as a mesh or a picture.
 *
 * @param {object} of
 * @param {import('phiz').Face} of.face
 * @param {Parameters<typeof portrait>[0] & { shapeChanged: () => void }} of.view
 * @param {ReturnType<typeof import('../head/head.js').createHead>} of.head
 * @param {{ any: boolean, load: () => Promise<void> }} of.expressions
 * @param {() => string} of.named what the face is called, '' when it was not saved
 * @param {() => import('../head/colouring.js').Colouring} of.colouring that the face has, whatever of it is shown
 * @param {() => import('./legend.js').Legend | null} of.legend what a picture of the stage has to say, when that shows more than the face
 * @param {() => Promise<void>} of.settle shows the face as it is, without what passes, such as a blink
 */
export function createExports({ face, view, head, expressions, named, colouring, legend, settle }) {
  const status = element('p', { class: 'note', role: 'status' });

  /**
   * @param {string} ending
   * @param {() => Promise<Blob>} make
   * @param {string} [name]
   */
  async function offer(ending, make, name = named()) {
    status.textContent = text.exporting;
    // The sentence shows before the work begins, which for a GLB takes a second or two.
    await new Promise((painted) => requestAnimationFrame(() => setTimeout(painted)));
    try {
      const blob = await make();
      const file = fileName(name, ending);
      save(blob, file);
      status.textContent = text.exported(file, blob.size);
    } catch (error) {
      status.textContent = text.notExported(error instanceof Error ? error.message : String(error));
    }
  }

  /** @param {keyof typeof MESHES} ending */
  async function mesh(ending) {
    // What moves in the file is what the model knows of by then.
    if (ending === 'glb' && expressions.any) await expressions.load();
    // Who exports nothing does not wait for the writers.
    const [{ toObj, toPly, toStl }, { coloursAsShown, glbAsShown }] = await Promise.all([
      part(() => import('phiz/export')),
      part(() => import('../appearance/appearance.js')),
    ]);
    await settle();
    // Hair that is hidden is the face's all the same.
    const options = { colouring: colouring() };
    const coloured = () => ({ colours: coloursAsShown(view.renderer, head, face, options) });
    /** @type {Record<keyof typeof MESHES, () => Uint8Array<ArrayBuffer> | Promise<Uint8Array<ArrayBuffer>>>} */
    const write = {
      glb: () => glbAsShown(view.renderer, head, face, { ...options, targets: targets.checked }),
      obj: () => toObj(face, coloured()),
      ply: () => toPly(face, coloured()),
      stl: () => toStl(face),
    };
    const bytes = await write[ending]();
    // The stage may have been drawn meanwhile.
    view.shapeChanged();
    return new Blob([bytes], { type: MESHES[ending] });
  }

  /** @param {string} label @param {number} value */
  const side = (label, value) =>
    element('input', { type: 'number', 'aria-label': label, min: 16, max: LARGEST, step: 1, value, required: true });
  const width = side(text.width, 1600);
  const height = side(text.height, 2000);
  const transparent = element('input', { type: 'checkbox' });
  const targets = element('input', { type: 'checkbox', checked: true });

  return createDialog(
    'exports-title',
    text.exportTitle,
    element('h3', {}, text.exportMesh),
    element(
      'ul',
      { class: 'formats' },
      .../** @type {(keyof typeof MESHES)[]} */ (Object.keys(MESHES)).map((ending) =>
        element(
          'li',
          {},
          element('button', { type: 'button', class: 'button', onclick: () => offer(ending, () => mesh(ending)) }, ending.toUpperCase()),
          ' ',
          element('div', {}, text.exportFormats[ending], ...(ending === 'glb' ? [element('label', { class: 'check' }, targets, text.exportTargets)] : [])),
        ),
      ),
    ),
    element('h3', {}, text.exportPicture),
    element(
      'form',
      {
        class: 'picture',
        onsubmit: (/** @type {Event} */ event) => {
          event.preventDefault();
          const size = { width: width.valueAsNumber, height: height.valueAsNumber };
          const said = legend();
          const make = async () => {
            await settle();
            await head.equipping();
            head.finish();
            const picture = await portrait(view, { ...size, transparent: transparent.checked });
            return said ? (await part(() => import('./legend.js'))).withLegend(picture, said) : picture;
          };
          offer('png', make, said ? text.versus(named(), said.other) : undefined);
        },
      },
      element('span', { class: 'size' }, width, '×', height, text.pixels),
      element('label', {}, transparent, ' ', text.transparent),
      element('button', { type: 'submit', class: 'button' }, 'PNG'),
    ),
    status,
  );
}
