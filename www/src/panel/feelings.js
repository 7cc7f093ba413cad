// Expressions that have a name, as weights of ARKit's. Those of feelings are what the Facial Action Coding System
// and its dictionary of emotions (Ekman, Friesen & Hager 2002) have them made of: the action units (AU) stand beside
// each. None is a prototype at its most: people who laugh do not open the jaw as far as it goes.

/** @typedef {Readonly<Record<string, number>>} Weights */

/**
 * On both sides of the face, and what has no side or only one.
 * @param {Weights} pairs @param {Weights} [single]
 * @returns {Weights}
 */
function made(pairs, single = {}) {
  const sides = Object.entries(pairs).flatMap(([name, weight]) => [`${name}Left`, `${name}Right`].map((side) => [side, weight]));
  return { ...Object.fromEntries(sides), ...single };
}

/** @type {Readonly<Record<string, Weights>>} */
export const FEELINGS = {
  // AU 6 + 12: without the cheeks and lids it is a smile for a photographer.
  smile: made({ mouthSmile: 0.7, cheekSquint: 0.5, eyeSquint: 0.2, mouthDimple: 0.15 }),
  // AU 6 + 7 + 12 + 25 + 26
  laugh: made({ mouthSmile: 0.85, cheekSquint: 0.75, eyeSquint: 0.5, mouthUpperUp: 0.35, mouthLowerDown: 0.2 }, { jawOpen: 0.35 }),
  // AU 1 + 4 + 15 + 17
  sad: made({ browDown: 0.35, mouthFrown: 0.65, eyeSquint: 0.15, eyeBlink: 0.1 }, { browInnerUp: 0.95, mouthShrugLower: 0.35 }),
  // AU 4 + 5 + 7 + 23 + 24
  angry: made({ browDown: 1, eyeSquint: 0.35, eyeWide: 0.4, noseSneer: 0.65, mouthPress: 0.4, mouthFrown: 0.45 }, { mouthRollLower: 0.2, mouthRollUpper: 0.2, mouthShrugLower: 0.25, jawForward: 0.2 }),
  // AU 1 + 2 + 5 + 26
  surprised: made({ browOuterUp: 0.95, eyeWide: 0.7 }, { browInnerUp: 0.9, jawOpen: 0.45 }),
  // AU 1 + 2 + 4 + 5 + 20 + 25
  afraid: made({ browOuterUp: 0.35, browDown: 0.3, eyeWide: 0.85, mouthStretch: 0.6, mouthFrown: 0.2, mouthLowerDown: 0.25 }, { browInnerUp: 0.85, jawOpen: 0.2 }),
  // AU 4 + 9 + 10 + 15 + 17
  disgusted: made({ noseSneer: 1, mouthUpperUp: 0.7, mouthFrown: 0.4, browDown: 0.6, eyeSquint: 0.45, cheekSquint: 0.4 }, { mouthShrugLower: 0.3 }),
  // AU 12 + 14 on one side: the only feeling that has one.
  contempt: made({ eyeSquint: 0.15, eyeBlink: 0.15 }, { mouthSmileLeft: 0.45, mouthDimpleLeft: 0.6, mouthPressLeft: 0.3 }),
  // AU 18
  kiss: made({ eyeSquint: 0.25 }, { mouthPucker: 1, mouthFunnel: 0.12 }),
  // AU 46, which the cheek helps with
  wink: made({}, { eyeBlinkLeft: 1, eyeSquintLeft: 0.3, cheekSquintLeft: 0.6, browDownLeft: 0.25, mouthSmileLeft: 0.5, mouthSmileRight: 0.25 }),
};

/** What a mouth does for the sounds that look apart. @type {Readonly<Record<string, Weights>>} */
export const VISEMES = {
  aa: made({ mouthLowerDown: 0.25, mouthUpperUp: 0.15 }, { jawOpen: 0.6 }),
  ee: made({ mouthSmile: 0.3, mouthStretch: 0.5, mouthUpperUp: 0.3, mouthLowerDown: 0.45 }, { jawOpen: 0.12 }),
  oo: made({}, { mouthPucker: 0.75, mouthFunnel: 0.35, jawOpen: 0.1 }),
  mm: made({ mouthPress: 0.4 }, { mouthRollLower: 0.3, mouthRollUpper: 0.3 }),
  ff: made({ mouthUpperUp: 0.25 }, { mouthRollLower: 0.9, jawOpen: 0.05 }),
  l: made({ mouthLowerDown: 0.15, mouthUpperUp: 0.15 }, { jawOpen: 0.25 }),
};
