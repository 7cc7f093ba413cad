// Every sentence of the page.

export const text = {
  name: 'phiz',
  tagline: 'face designer',
  loading: 'Loading the face model',
  features: 'Features',
  panel: 'Ways to shape the face',
  modes: { features: 'Features', meanings: 'Meanings', mix: 'Mix', compare: 'Compare', saved: 'Faces' },
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
  locked: 'Locked: random faces, mixing and resets leave it alone.',
  isLocked: 'Locked',
  finer: (/** @type {string} */ group) => `A finer variation of the ${group}`,
  resetControl: 'Double-click, or the Delete key, goes back to the median. Type a number for an exact value.',
  more: (/** @type {number} */ n) => `Show ${n} more`,
  fewer: 'Show fewer',
  advanced: 'Advanced',
  alpha: 'Blending distance',
  alphaTyped: 'Blending distance in mm',
  alphaAbout: 'How far a change of one feature reaches into the skin around it.',
  seed: 'Seed',
  seedAbout: 'The same seed gives the same random face again.',
  useSeed: 'Use',
  randomFaces: 'Random faces',
  spread: 'How unusual',
  spreadAbout: 'At × 1 random faces differ as people do; below, they keep close to the average.',
  unusual: (/** @type {number} */ spread) =>
    `${spread < 0.45 ? 'near the average' : spread < 0.85 ? 'ordinary' : spread <= 1.15 ? 'as people are' : spread < 1.55 ? 'unusual' : 'rare'}, × ${spread.toFixed(2)}`,
  randomised: (/** @type {number} */ seed) => `Random face, seed ${seed}`,
  randomisedRest: (/** @type {number} */ seed) => `Random but for what is locked, seed ${seed}`,
  typeValue: (/** @type {string} */ name, /** @type {string} */ words) => `${words}: type a value for ${name}`,
  typed: (/** @type {string} */ name) => `Percentile of ${name}`,
  measures: 'Measures',
  change: (/** @type {number} */ mm) => `${mm < 0 ? '−' : '+'}${Math.abs(mm).toFixed(1)}`,
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
  preset: (/** @type {number} */ n) => `Preset ${n}`,
  ownFace: (/** @type {number} */ n) => `My face ${n}`,
  thisFace: 'This face',
  ownFaces: 'Your faces',
  noFaces: 'Faces that you save stay in this browser. The one you are working on is kept by itself.',
  saveAs: 'Save this face as',
  namePlaceholder: 'A name',
  save: 'Save',
  saved: (/** @type {string} */ name) => `Saved as “${name}”`,
  notKept: 'This browser does not let the page keep anything, or its storage is full. Download the face, or copy its link.',
  open: (/** @type {string} */ name) => `Open ${name}`,
  rename: (/** @type {string} */ name) => `Rename ${name}`,
  remove: (/** @type {string} */ name) => `Delete ${name}`,
  removed: (/** @type {string} */ name) => `“${name}” is deleted.`,
  lastVisit: (/** @type {string} */ when) => `Last visit, ${when}`,
  lastKept: 'This link’s face is shown. The one you were working on is among your faces.',
  back: 'Your last face is back.',
  files: 'Files',
  filesAbout: 'A file holds one face, for this model. You can also drop one onto the page.',
  downloadThis: 'Download',
  downloadFace: (/** @type {string} */ name) => `Download ${name}`,
  importFace: 'Open a file',
  imported: (/** @type {string} */ name) => `“${name}” is opened, and among your faces.`,
  fileTooLong: (/** @type {string} */ file) => `${file} is not a face: it is far too long.`,
  fileForeign: (/** @type {string} */ file) => `${file} is not a face from this page.`,
  fileVersion: (/** @type {string} */ file, /** @type {string} */ version) =>
    `${file} was written by a newer page (version ${version}). Reload to get it.`,
  fileOtherModel: (/** @type {string} */ file, /** @type {string} */ theirs, /** @type {string} */ ours) =>
    `${file} is a face of another model, “${theirs}”; this page shows “${ours}”.`,
  fileBroken: (/** @type {string} */ file, /** @type {string} */ why) => `${file} is damaged: ${why}.`,
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

/**
 * A feature's name as a title.
 * @param {string} group
 */
export function titleOf(group) {
  return text.groups[group] ?? group.charAt(0).toUpperCase() + group.slice(1);
}
