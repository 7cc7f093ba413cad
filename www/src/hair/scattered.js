// Light that goes from hair to hair comes out brighter than once off a pigment, the most where that is dark.

/** By how much. @param {readonly number[]} hair red, green and blue, linear */
export const scatters = ([r, g, b]) => (0.3 * r + 0.55 * g + 0.15 * b + 0.002) ** -0.16;

/** As `scatters` has it; of several hairs light takes a little of no one's colour. */
export const SCATTERED = /* glsl */ `
  vec3 scattered(vec3 hair) {
    float light = dot(hair, vec3(0.3, 0.55, 0.15));
    return mix(vec3(light), hair, 0.92) * pow(light + 0.002, -0.16);
  }
`;
