import { plantOn } from './plant.js';

/** @type {ReturnType<typeof plantOn> | null} */
let grow = null;
/** What the page has already. @type {Set<string>} */
const told = new Set();

// The head first, and then one style after the other.
addEventListener('message', ({ data }) => {
  if (!grow) {
    grow = plantOn(data.skin, data.where);
    return;
  }
  const { kind, style } = data;
  const grown = grow(kind, style);
  const planting = grown && !told.has(kind) ? grown.planting : null;
  told.add(kind);
  postMessage({ kind, planting, ribbons: grown && grown.ribbons }, { transfer: grown ? Object.values(grown.ribbons).map(({ buffer }) => buffer) : [] });
});
