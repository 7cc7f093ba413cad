// Every sentence of the page.

export const text = {
  name: 'phiz',
  tagline: 'face designer',
  loading: 'Loading the face model',
  features: 'Features',
  stage: 'The face. Drag to turn it, scroll or pinch to come closer, click a feature to shape it. The arrow keys turn it, plus and minus zoom.',
  hint: 'Click a feature to shape it',
  hintTouch: 'Tap a feature to shape it',
  views: 'View',
  view: { front: 'Front', quarter: 'Three-quarter', profile: 'Profile' },
  resetView: 'Reset the view',
  undo: 'Undo',
  redo: 'Redo',
  randomise: 'Random face',
  resetAll: 'Reset all',
  copyLink: 'Copy link',
  linkCopied: 'Link copied. Whoever opens it sees this face.',
  linkManual: 'Copy this link:',
  theme: 'Light or dark',
  about: 'What is this?',
  close: 'Close',
  resetFeature: (/** @type {string} */ group) => `Reset the ${group}`,
  randomiseFeature: (/** @type {string} */ group) => `Random ${group}`,
  lockFeature: (/** @type {string} */ group) => `Lock the ${group}`,
  locked: 'Locked: random faces and resets leave it alone.',
  finer: (/** @type {string} */ group) => `A finer variation of the ${group}`,
  resetControl: 'Double-click the slider to set it back to the median.',
  more: (/** @type {number} */ n) => `Show ${n} more`,
  fewer: 'Show fewer',
  advanced: 'Advanced',
  alpha: 'Blending distance',
  alphaAbout: 'How far a change of one feature reaches into the skin around it.',
  seed: 'Seed',
  seedAbout: 'The same seed gives the same random face again.',
  useSeed: 'Use',
  spread: 'Variety',
  spreadAbout: 'How unusual random faces are; 1 is the variety of the population.',
  randomised: (/** @type {number} */ seed) => `Random face, seed ${seed}`,
  undone: 'Undone',
  redone: 'Redone',
  millimetres: (/** @type {number} */ mm) => `${mm.toFixed(1)} mm`,
  badCode: 'The link holds no face of this model, so the median face is shown.',
  groups: /** @type {Record<string, string>} */ ({
    head: 'Head',
    forehead: 'Forehead',
    eyes: 'Eyes',
    nose: 'Nose',
    mouth: 'Mouth',
    chin: 'Chin',
  }),
  newVersion: 'A new version of phiz is here.',
  takeNewVersion: 'Take it',
  exportTitle: 'Take the face with you',
  exportMesh: 'As a mesh',
  exportFormats: {
    glb: 'for Blender, three.js and game engines: metres, and every slider as a named shape key',
    obj: 'for any modelling program: millimetres, texture coordinates, parts as groups',
    ply: 'for MeshLab and research code: millimetres, vertex colours, the model’s vertex order',
    stl: 'for a 3D printer: millimetres',
  },
  exportPicture: 'As a picture of this view',
  width: 'Width in pixels',
  height: 'Height in pixels',
  pixels: 'pixels',
  transparent: 'Transparent behind the head',
  exporting: 'Writing the file …',
  exported: (/** @type {string} */ file, /** @type {number} */ bytes) =>
    `${file} is written, ${(bytes / 1e6).toLocaleString('en-GB', { maximumFractionDigits: 1 })} MB.`,
  notExported: (/** @type {string} */ why) => `The file could not be written: ${why}.`,
  failed: 'The page cannot show a face',
  noWebGL:
    'Your browser does not offer WebGL 2, which draws the face. A current Chrome, Firefox, Edge or Safari has it; if yours is current, graphics acceleration may be switched off in its settings.',
  noWasm:
    'Your browser does not offer WebAssembly, which computes the face. It may be switched off by a security setting.',
  noModel: (/** @type {string} */ why) =>
    `The face model could not be downloaded (${why}). Check the connection and reload the page.`,
  badModel: (/** @type {string} */ why) =>
    `The face model on this site cannot be used: ${why}. Whoever runs the site should install it again.`,
  unknownModel: 'This link asks for a model that is not here. These are the faces of the usual one.',
  lostContext: 'The graphics card was lost for a moment. If the face does not come back, reload the page.',
  reload: 'Reload',
  aboutTitle: 'What is this?',
  aboutBody: [
    [
      'A face from a population',
      'phiz knows how faces differ, because it has learned from many. Every slider is one way in which they differ. All you see is computed on your own device; nothing is sent anywhere.',
    ],
    [
      'What a slider is',
      'For each feature, the model has found the shapes that vary together: first the greatest, then the next. Each is called an eigenmode, and “nose 1” is the first of the nose. They have no names of their own: move one, and see.',
    ],
    [
      'What the number means',
      'It is a percentile. At the 50th, half of the population has less and half has more; at the 90th, nine of ten have less. Every new face starts at the median.',
    ],
  ],
  population: 'Whose faces these are',
  models: 'Faces of',
  /** @type {Readonly<Record<string, string>>} */
  model: { people: 'scanned people', synthetic: 'synthetic people' },
  madeFrom: 'Made from',
  facesLearned: (/** @type {number} */ n) => `Learned from ${n.toLocaleString('en-GB')} faces.`,
};

/**
 * 0.5 -> "50th".
 * @param {number} value a percentile in [0, 1]
 */
export function ordinal(value) {
  const n = Math.round(value * 100);
  const tens = n % 100;
  const ending = tens >= 11 && tens <= 13 ? 'th' : (['th', 'st', 'nd', 'rd'][n % 10] ?? 'th');
  return `${n}${ending}`;
}
