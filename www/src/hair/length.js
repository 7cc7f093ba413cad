// Of a style's length: its slider, 0 to 1, and mm.

/** The longest that hair is, mm: to below the chin. */
const LONGEST = 230;

/** How long hair is, mm. @param {{ length: number }} style */
export const hairLength = ({ length }) => LONGEST * length ** 1.5;

/** Where the slider of hair so long is. @param {number} mm */
export const sliderOfLength = (mm) => Math.min(1, (mm / LONGEST) ** (1 / 1.5));
