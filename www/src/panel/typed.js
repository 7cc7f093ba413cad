// What somebody types into the field of a slider. Whatever the page writes can be typed: its units, its ranks.

/** What is written after a number of a unit, and how many of the unit it is. @type {Record<string, Record<string, number>>} */
const UNITS = {
  mm: { mm: 1, cm: 10 },
  years: { years: 1, year: 1 },
  '%': { '%': 1 },
  σ: { σ: 1 },
};
const RANK = /^(st|nd|rd|th)( percentile)?$/;

/**
 * A number and what is written after it, in small letters; NaN when it does not begin with a number. A comma is a point.
 * @param {string} typed
 * @returns {readonly [number: number, rest: string]}
 */
export function numberAndRest(typed) {
  const plain = typed.trim().toLowerCase().replace(/^× ?/, '').replace('−', '-').replace(',', '.');
  const [, number = '', rest = ''] = plain.match(/^([-+]?(?:\d+\.?\d*|\.\d+))\s*(.*)$/) ?? [];
  return [number === '' ? NaN : Number(number), rest];
}

/**
 * What is typed as a change from the present value, as the table of differences writes it: `+3`, or `−3` where nothing is less than
 * nothing; with `=` it is one wherever signs are a part of values.
 * @param {string} typed @param {number} least that there is @param {string} unit
 * @returns {string | null} the change, signed; null for a value
 */
export function changeIn(typed, least, unit) {
  const [, sign, equals, rest] = typed.trim().match(/^([-+−])(=?)\s*(.*)$/) ?? [];
  // Standard deviations are written with either sign.
  const isChange = equals || (sign === '+' ? unit !== 'σ' : least >= 0);
  return sign && isChange ? (sign === '+' ? rest : `-${rest}`) : null;
}

/**
 * @param {string} typed @param {string} unit of the number, which need not be typed
 * @param {(percent: number) => number} [atRank] what the number is where so many per cent of people have less
 * @returns {number} NaN when it cannot be read
 */
export function numberIn(typed, unit, atRank) {
  const [number, rest] = numberAndRest(typed);
  if (rest === '') return number;
  if (atRank && RANK.test(rest)) return number >= 0 && number <= 100 ? atRank(number) : NaN;
  return number * (UNITS[unit]?.[rest] ?? NaN);
}
