/** How large the tile of cropped hair is on the head, mm. */
export const TILE = 27;
