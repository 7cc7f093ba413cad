import { beardLength } from './beard.js';
import { broadOf } from './browform.js';
import { createGrower } from './grower.js';
import { hairLength } from './length.js';
import { partsOf } from './parts.js';
import { createTresses } from './tresses.js';

/** Brows are never longer or shorter: how long their hairs are, mm. */
const BROW = 6;

/**
 * Longer hair, a longer beard and brows on a head.
 *
 * @param {import('./plant.js').Skin} skin
 * @param {ReturnType<typeof import('./growth.js').growth>} where
 * @param {Parameters<typeof createTresses>[2] & Record<'worn' | 'browed', { value: number }>} uniforms of the skin
 * @param {readonly [number, number]} fade heights between which the neck runs out, mm
 * @param {() => void} onGrown some that was asked for has come
 */
export function growHair(skin, where, uniforms, fade, onGrown) {
  const parts = partsOf(skin.positions, skin.landmarks);
  const grower = createGrower(skin, { ...where, parts });
  const on = { grower, rest: skin.positions, onGrown };
  const tresses = [
    createTresses(
      { kind: 'hair', style: (paints) => paints.style, thinning: ({ standing, gone }) => ({ share: standing[0], gone: [0, 0, 0, gone[3]] }), long: hairLength, half: 0.83, stride: ({ curl }) => (curl > 0.3 ? 2 : 3) },
      on,
      uniforms,
      // About where the neck does: no shoulders are there that it could lie on.
      fade.map((y) => y + 18),
    ),
    createTresses(
      { kind: 'beard', style: (paints) => paints.whiskers, thinning: ({ standing, gone }) => ({ share: standing[1], gone: [...gone.slice(0, 3), 0] }), long: beardLength, half: 0.58, stride: () => 6 },
      on,
      uniforms,
      fade.map((y) => y - 40),
    ),
    createTresses(
      {
        kind: 'brows',
        style: ({ browForm }) => browForm,
        // What is bushy is broader, too: thin brows are the middle of it. And what is made broader is not thinner.
        thinning: ({ bushy, browed, browForm }) => ({ share: browed * Math.min(1, 0.365 * bushy ** 1.15 * broadOf(browForm) ** 0.75), gone: [0, 0, 0, 0.35 * (2 - bushy)] }),
        long: () => BROW,
        half: 0.255,
        gaps: 0.45,
        bare: 0.2,
        carries: ({ browed }) => browed,
      },
      on,
      // A photo that is worn has brows of its own.
      { ...uniforms, hides: uniforms.worn, stands: uniforms.browed },
      fade,
    ),
  ];
  return { tresses, parts, dispose: grower.dispose };
}
