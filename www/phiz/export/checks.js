/**
 * Nobody hears of an option that is misspelled; some pass null for none.
 * @template {object} T
 * @param {string} what @param {T | null | undefined} options @param {readonly (keyof T)[]} known
 * @returns {Partial<T>} them
 */
export function optionsOf(what, options, known) {
  const given = options ?? {};
  if (typeof given !== 'object') throw new TypeError(`the options of ${what} must be an object`);
  const unknown = Object.keys(given).find((name) => !known.includes(/** @type {keyof T} */ (name)));
  if (unknown !== undefined) throw new Error(`${what} knows no option "${unknown}"`);
  return given;
}

/**
 * Three numbers a vertex. glTF forbids what is not finite.
 * @param {string} what @param {unknown} values @param {number} vertices
 */
function checkVectors(what, values, vertices) {
  if (!(values instanceof Float32Array)) throw new TypeError(`${what} must be a Float32Array`);
  if (values.length !== 3 * vertices) throw new Error(`${what} must be ${3 * vertices} numbers, three a vertex, not ${values.length}`);
  for (let i = 0; i < values.length; i++) {
    if (!Number.isFinite(values[i])) throw new Error(`${what} must be finite, and one of vertex ${Math.floor(i / 3)} is ${values[i]}`);
  }
}

/** @param {unknown} colours @param {number} vertices */
export function checkColours(colours, vertices) {
  if (!(colours instanceof Uint8Array) && !(colours instanceof Uint8ClampedArray)) throw new TypeError('the colours must be a Uint8Array, sRGB');
  if (colours.length !== 3 * vertices) throw new Error(`the colours must be ${3 * vertices} numbers, three a vertex, not ${colours.length}`);
}

/**
 * @param {Partial<{ controls: readonly import('./index.js').MorphTarget[], expressions: readonly import('./index.js').ExpressionTarget[] }>} measured
 * @param {number} vertices
 */
export function checkMeasured(measured, vertices) {
  for (const kind of /** @type {const} */ (['controls', 'expressions'])) {
    const targets = measured?.[kind];
    if (!Array.isArray(targets)) throw new TypeError(`the measured ${kind} must be an array of targets`);
    for (const [i, target] of targets.entries()) {
      if (typeof target?.name !== 'string') throw new TypeError(`target ${i} of the measured ${kind} must have a name, a string`);
      for (const key of /** @type {const} */ (['positions', 'normals'])) checkVectors(`the ${key} of the target "${target.name}"`, target[key], vertices);
    }
  }
}

/** @param {string} what @param {Partial<import('./index.js').Picture> | undefined} picture */
function checkPicture(what, picture) {
  const isKnown = picture?.mimeType === 'image/jpeg' || picture?.mimeType === 'image/png';
  if (!isKnown || !(picture.bytes instanceof Uint8Array && picture.bytes.length > 0)) {
    throw new TypeError(`the picture ${what} must be the bytes of a JPEG or PNG, with its mimeType`);
  }
}

/** @param {Partial<import('./index.js').Part>} part @param {number} at @param {boolean} withTargets */
function checkPart(part, at, withTargets) {
  if (typeof part?.name !== 'string') throw new TypeError(`part ${at} of an appearance must have a name, a string`);
  const { name, positions, triangles, roughness } = part;
  const of = `of the part "${name}"`;
  const vertices = Math.ceil((positions?.length ?? 0) / 3);
  checkVectors(`the positions ${of}`, positions, vertices);
  checkVectors(`the normals ${of}`, part.normals, vertices);
  checkVectors(`the colours ${of}`, part.colours, vertices);
  if (!(triangles instanceof Uint32Array)) throw new TypeError(`the triangles ${of} must be a Uint32Array`);
  if (triangles.length % 3) throw new Error(`the triangles ${of} must be three corners each, and are ${triangles.length} corners`);
  const beyond = triangles.find((vertex) => vertex >= vertices);
  if (beyond !== undefined) throw new Error(`the triangles ${of} name vertex ${beyond}, and it has ${vertices}`);
  if (!(typeof roughness === 'number' && roughness >= 0 && roughness <= 1)) throw new Error(`the roughness ${of} must be a number from 0 to 1, not ${roughness}`);
  for (const key of /** @type {const} */ (['metalness', 'opacity'])) {
    const value = part[key];
    if (value !== undefined && !(typeof value === 'number' && value >= 0 && value <= 1)) throw new Error(`the ${key} ${of} must be a number from 0 to 1, not ${value}`);
  }
  if (!withTargets) return;
  if (typeof part.targets !== 'object' || !part.targets) throw new TypeError(`the targets ${of} must be an object`);
  for (const [target, moves] of Object.entries(part.targets)) checkVectors(`the target "${target}" ${of}`, moves, vertices);
}

/**
 * Whoever opens the file would refuse it, and could not say why.
 * @param {import('./index.js').Appearance} appearance @param {boolean} withTargets
 */
export function checkAppearance({ skin, eyes, parts = [] }, withTargets) {
  for (const name of /** @type {const} */ (['colour', 'normal', 'surface'])) checkPicture(`skin.${name} of an appearance`, skin?.[name]);
  if (eyes) {
    checkPicture('eyes.colour of an appearance', eyes.colour);
    if (!(Number.isFinite(eyes.reach) && eyes.reach > 0)) throw new Error(`eyes.reach of an appearance must be an angle above 0, not ${eyes.reach}`);
  }
  if (!Array.isArray(parts)) throw new TypeError('the parts of an appearance must be an array');
  for (const [i, part] of parts.entries()) checkPart(part, i, withTargets);
}
