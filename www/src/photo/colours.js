import { element } from '../frame/element.js';
import { text } from '../text.js';
import { Cancelled } from './fitter.js';
import { coloured } from './grey.js';

/** Texels a side of the colours that the 3D head takes from the photo. */
const SIDE = 1024;

/** With the looks that the head has as it is in the photo. @typedef {import('../head/head.js').Worn} Colours */

/**
 * The 3D head's colours: the photo's once somebody looks at it, if that is wanted, or its own.
 *
 * @param {{
 *   fitter: import('./fitter.js').Fitter,
 *   detail: () => import('phiz').PhotoDetail | null,
 *   tone: import('three').Color,
 *   colouring: () => import('../head/colouring.js').Colouring,
 *   allowed: () => boolean,
 *   wear: (colours: Colours | null) => void,
 *   complain: (sentence: string) => void,
 * }} parts `detail`: its face in its own pixels; `tone`: of the head's skin at rest; `colouring`: the
 *   looks that it has as it is in the photo; `allowed`: the face is that of a photo that says something of them
 */
export function createColours({ fitter, detail, tone, colouring, allowed, wear, complain }) {
  /** What the photo says; undefined before it was asked. @type {Colours | null | undefined} */
  let found;
  /** What of that the head has on. @type {Colours | null} */
  let worn = null;
  /** The question that is open. @type {Promise<void> | null} */
  let asking = null;
  /** What comes late for an earlier photo is dropped. */
  let asked = 0;
  const box = element('input', { type: 'checkbox', id: 'photo-colours', checked: true, onchange: () => void dress() });

  const wanted = () => box.checked && allowed();

  async function find() {
    const here = (asked += 1);
    try {
      const colours = await fitter.texture(SIDE, detail());
      if (here === asked) found = colours && { ...coloured(colours, tone), colouring: colouring() };
    } catch (error) {
      if (here !== asked) return;
      found = null;
      if (!(error instanceof Cancelled)) complain(text.photo.noColours(error instanceof Error ? error.message : String(error)));
    } finally {
      if (here === asked) asking = null;
    }
  }

  /** Asks the photo, once. */
  async function prepare() {
    if (wanted() && found === undefined) await (asking ??= find());
  }

  async function dress() {
    await prepare();
    // Another photo came in between, and asks by itself.
    if (wanted() && found === undefined) return;
    const shown = wanted() ? (found ?? null) : null;
    if (shown === worn) return;
    worn = shown;
    wear(shown);
  }

  return {
    /** For the panel. */
    root: element('label', { class: 'check' }, box, text.photo.colours),
    /** Whether it can be chosen, which nobody needs to look at the head for. */
    offer() {
      box.disabled = !allowed();
    },
    dress,
    prepare,
    /** The photo or its fit is another. */
    forget() {
      asked += 1;
      asking = null;
      found = undefined;
    },
    get worn() {
      return worn !== null;
    },
  };
}
