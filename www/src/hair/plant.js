import { beardGround } from './beard.js';
import { browHair } from './browhair.js';
import { scalpGround } from './hairstyle.js';
import { createHull } from './hull.js';
import { layRibbons, ribbonsOf } from './ribbons.js';
import { growOn } from './strands.js';

// Longer hair and a longer beard on a head, as numbers: on the page or beside it.

/** What hair grows on: the skin at rest. @typedef {import('../groundwork/groundwork.js').Rest} Skin */
/** @typedef {ReturnType<typeof import('./growth.js').growth> & { parts: Uint8Array }} Where */
/** @typedef {{ hair: import('./hairstyle.js').Style, beard: import('./beard.js').Beard, brows: import('./browhair.js').Brows }} Styles */
/** @typedef {keyof Styles} Kind */
/** Its strands and what ribbons on them have in common. @typedef {import('./strands.js').Planted & ReturnType<typeof layRibbons>} Planting */
/** @typedef {ReturnType<typeof ribbonsOf>} Ribbons */

/**
 * @param {Skin} skin
 * @param {Where} where
 */
export function plantOn(skin, { scalp, beard, parts }) {
  const { positions, normals, triangles, landmarks } = skin;
  /** @type {import('./hull.js').Hull | null | undefined} */
  let hull;
  /**
   * @template {import('./strands.js').Curled} S
   * @param {(hull: import('./hull.js').Hull) => import('./strands.js').Ground<S> | null} groundOn
   */
  function on(groundOn) {
    if (hull === undefined) hull = createHull(positions, triangles, landmarks);
    const ground = hull && groundOn(hull);
    return laid(hull && ground ? growOn(positions, normals, triangles, hull, ground, parts) : null);
  }
  /**
   * @template {import('./strands.js').Curled} S
   * @param {import('./strands.js').Hair<S> | null} hair
   */
  function laid(hair) {
    if (!hair) return null;
    const { grow, ...planted } = hair;
    return { planting: /** @type {Planting} */ ({ ...planted, ...layRibbons(planted) }), grow: (/** @type {S} */ style) => ribbonsOf(grow(style)) };
  }
  /** Each when it is first asked for. @type {Map<Kind, ReturnType<typeof laid<any>>>} */
  const plants = new Map();
  /** @param {Kind} kind */
  function plant(kind) {
    let found = plants.get(kind);
    if (found === undefined) {
      if (kind === 'brows') found = laid(browHair(skin));
      else found = kind === 'hair' ? on((hull) => scalpGround(scalp, landmarks, hull)) : on(() => beardGround(beard, landmarks));
      plants.set(kind, found);
    }
    return found;
  }
  /**
   * @template {Kind} K
   * @param {K} kind
   * @param {Styles[K]} style
   * @returns {{ planting: Planting, ribbons: Ribbons } | null} null where nothing grows
   */
  function grow(kind, style) {
    const found = plant(kind);
    return found && { planting: found.planting, ribbons: found.grow(style) };
  }
  return grow;
}
