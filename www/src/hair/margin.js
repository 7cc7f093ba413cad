/** How far inside or outside of its line hair is told from skin, mm. */
export const MARGIN = 20;
