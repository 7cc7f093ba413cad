// An expression as files and the browser keep it: names and weights. A face that was saved before they
// were kept has none, and says nothing about it: opening it leaves the expression that there is.

/** @typedef {Readonly<Record<string, number>>} Shown */

/**
 * What can be shown of what was read: names of ARKit's kind with weights, in whole per cents.
 * @param {unknown} kept
 * @returns {Shown | undefined} undefined when nothing was kept
 */
export function readExpression(kept) {
  if (typeof kept !== 'object' || kept === null || Array.isArray(kept)) return undefined;
  return Object.fromEntries(
    Object.entries(kept).flatMap(([name, weight]) => {
      // What rounds to nothing, as a photo may tell of, is none.
      if (!/^[A-Za-z]{1,40}$/.test(name) || typeof weight !== 'number' || !(weight >= 0.005)) return [];
      return [[name, Math.round(100 * Math.min(1, weight)) / 100]];
    }),
  );
}

/** Those that the model has. @param {Shown} shown @param {readonly string[]} names @returns {Record<string, number>} */
export function among(shown, names) {
  return Object.fromEntries(Object.entries(shown).filter(([name]) => names.includes(name)));
}

/** Whether it is more than a face at rest, of expressions or colourings. @param {Readonly<Record<string, unknown>> | undefined} shown */
export const shows = (shown) => shown !== undefined && Object.keys(shown).length > 0;
