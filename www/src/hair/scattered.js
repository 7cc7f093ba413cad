/** Light that goes from hair to hair comes out brighter than once off a pigment, the most where that is dark. */
export const SCATTERED = /* glsl */ `
  vec3 scattered(vec3 hair) { return hair * pow(dot(hair, vec3(0.3, 0.55, 0.15)) + 0.002, -0.16); }
`;
