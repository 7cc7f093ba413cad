import { Box3, BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Group, Mesh, Sphere, SRGBColorSpace, Vector3 } from 'three';
import { paintBrows } from './brows.js';
import { EYEBALL, eyeballsOn, eyeVerticesOf } from './eyeballs.js';
import { createEyes } from './eyes.js';
import { growth } from '../hair/growth.js';
import { createLashes } from './lashes.js';
import { wearsGlasses } from './colouring.js';
import { foldingOf } from './folds.js';
import { nostrils } from './nostrils.js';
import { smoothed } from '../groundwork/occlusion.js';
import { pigments } from './pigments.js';
import { createSkin } from './skin.js';
import { manlyOf, toldOf } from './someone.js';
import { subdivide } from './subdivision.js';
import { createTeeth } from './teeth.js';
import { createMap, createTile } from '../rendering/textures.js';

/** The landmarks that glasses sit by: a model that has them not wears none. */
const SEATS = ['ibug_00', 'ibug_16', 'ibug_27', 'superaurale left', 'postaurale left', 'helix root left'];

/** As many parts of the mesh as are uploaded one by one with a frame. */
const MOST_RANGES = 32;

/**
 * The vertices on edges that only one triangle has.
 * @param {Uint32Array} triangles
 */
function openEdge(triangles) {
  /** @type {Map<number, number>} */
  const uses = new Map();
  const key = (/** @type {number} */ a, /** @type {number} */ b) =>
    Math.min(a, b) * 0x100000 + Math.max(a, b);
  for (let t = 0; t < triangles.length; t++) {
    const pair = key(triangles[t], triangles[t % 3 === 2 ? t - 2 : t + 1]);
    uses.set(pair, (uses.get(pair) ?? 0) + 1);
  }
  /** @type {Set<number>} */
  const vertices = new Set();
  for (const [pair, count] of uses) {
    if (count === 1) vertices.add(Math.floor(pair / 0x100000)).add(pair % 0x100000);
  }
  return [...vertices];
}

/**
 * What a portrait shows, from the fading neck to the crown, and where the neck runs out, mm.
 * @param {import('phiz').FaceModel} model @param {ArrayLike<number>} rest
 */
export function framing(model, rest) {
  const bounds = new Box3();
  const point = new Vector3();
  for (const part of model.parts) {
    if (/eyeball/.test(part.name)) continue;
    for (const corner of model.triangles.subarray(3 * part.first, 3 * (part.first + part.count))) {
      bounds.expandByPoint(point.fromArray(rest, 3 * model.uvVertices[corner]));
    }
  }
  const stencil = model.landmarks.find(({ name }) => name === 'ibug_08')?.stencil;
  const chin = stencil ? stencil.reduce((y, [vertex, weight]) => y + weight * rest[3 * vertex + 1], 0) : bounds.min.y;
  const top = bounds.max.y;
  return {
    bounds,
    subject: {
      centre: new Vector3(0, (top + chin - 26) / 2, bounds.getCenter(new Vector3()).z * 0.6),
      height: (top - chin + 26) * 1.2,
      /** From the nose's tip to the back of the head, and what is in the middle between them. */
      depth: bounds.max.z - bounds.min.z,
      axis: (bounds.max.z + bounds.min.z) / 2,
    },
    /** The neck is not seen below the first of these heights, and wholly above the second. */
    fade: /** @type {[number, number]} */ ([Math.max(bounds.min.y + 4, chin - 66), chin - 14]),
  };
}

/**
 * What a head is drawn from, copied: views on the module's memory die with the next call.
 * @param {import('phiz').FaceModel} model
 * @param {import('phiz').Face} face
 * @returns {import('../groundwork/groundwork.js').Rest}
 */
export function atRest(model, face) {
  const positions = face.positions.slice();
  const corners = model.uvVertices;
  /** @type {import('../groundwork/paint.js').Points} */
  const landmarks = new Map();
  for (const { name, stencil } of model.landmarks) {
    const point = weighted(positions, stencil, new Vector3());
    landmarks.set(name, [point.x, point.y, point.z]);
  }
  return { positions, normals: face.normals.slice(), triangles: model.triangles.map((corner) => corners[corner]), landmarks };
}

/**
 * @param {ArrayLike<number>} positions @param {readonly (readonly [number, number])[]} stencil
 * @param {Vector3} out
 */
export function weighted(positions, stencil, out) {
  out.set(0, 0, 0);
  for (const [vertex, weight] of stencil) {
    out.x += weight * positions[3 * vertex];
    out.y += weight * positions[3 * vertex + 1];
    out.z += weight * positions[3 * vertex + 2];
  }
  return out;
}

/**
 * The head: geometry from the model's topology and a face's vertices.
 *
 * @param {import('phiz').FaceModel} model
 * @param {import('../groundwork/groundwork.js').Rest} face at rest
 * @param {import('../groundwork/groundwork.js').Groundwork} groundwork of it
 */
export function createHead(model, { positions: rest, normals: restNormals, landmarks: at }, groundwork) {
  const vertexCount = model.vertexCount;
  const corners = model.uvVertices;
  const regionOf = model.regionOf;
  const ownCorners = corners.length;

  const indices = [];
  for (const part of model.parts) {
    if (!EYEBALL.test(part.name)) indices.push(...model.triangles.subarray(3 * part.first, 3 * (part.first + part.count)));
  }
  const whole = Uint32Array.from(indices);
  const ofSkin = whole.map((corner) => corners[corner]);
  /** @param {RegExp} name of parts */
  const verticesOf = (name) =>
    model.parts
      .filter((part) => name.test(part.name))
      .flatMap(({ first, count }) => [...new Set(Array.from(model.triangles.subarray(3 * first, 3 * (first + count)), (corner) => corners[corner]))]);
  // Where lips and lids meet what is behind them, edges are short, and curves would go through each other.
  const rims = new Uint8Array(vertexCount);
  for (const v of verticesOf(/cavit/)) rims[v] = 1;
  const finer = subdivide(whole, corners, rest, restNormals, rims);
  const cornerCount = finer.corners;

  /** @type {Map<string, readonly (readonly [number, number])[]>} */
  const stencils = new Map(model.landmarks.map((landmark) => [landmark.name, landmark.stencil]));
  /**
   * @param {ArrayLike<number>} positions @param {string} name @param {Vector3} out
   */
  function landmark(positions, name, out) {
    const stencil = stencils.get(name);
    return stencil ? weighted(positions, stencil, out) : null;
  }

  const { bounds, fade } = framing(model, rest);

  const geometry = new BufferGeometry();
  geometry.setIndex(new BufferAttribute(finer.index, 1));
  /**
   * What vertices have, for the corners of what is drawn.
   * @template {Float32Array | Uint8Array | Int8Array} Values
   * @param {ArrayLike<number>} values @param {number} size numbers a vertex
   * @param {Values} array for them
   */
  const spread = (values, size, array) => {
    for (let i = 0; i < ownCorners; i++) {
      for (let k = 0; k < size; k++) array[size * i + k] = values[size * corners[i] + k];
    }
    return finer.between(array, size);
  };
  /** @param {Float32Array} values three a vertex */
  const perCorner = (values) => new BufferAttribute(spread(values, 3, new Float32Array(3 * cornerCount)), 3);
  const positions = spread(rest, 3, new Float32Array(3 * cornerCount));
  const normals = spread(restNormals, 3, new Float32Array(3 * cornerCount));
  finer.curve(positions, normals, 0, vertexCount);
  const position = new BufferAttribute(positions, 3);
  const normal = new BufferAttribute(normals, 3);
  const marks = new Float32Array(2 * cornerCount);
  const mark = new BufferAttribute(marks, 2);
  for (const live of [position, normal, mark]) live.setUsage(DynamicDrawUsage);
  geometry.setAttribute('position', position);
  geometry.setAttribute('normal', normal);
  geometry.setAttribute('mark', mark);
  const uvs = new Float32Array(2 * cornerCount);
  uvs.set(model.uvs);
  geometry.setAttribute('uv', new BufferAttribute(finer.between(uvs, 2), 2));
  const heats = new Float32Array(3 * cornerCount);
  const heat = new BufferAttribute(heats, 3).setUsage(DynamicDrawUsage);
  geometry.setAttribute('heat', heat);
  geometry.setAttribute('rest', perCorner(rest));
  geometry.setAttribute('restNormal', perCorner(restNormals));

  // The skin's own colour is the median of the prescribed ones: lips, brows and cavities are few.
  const colours = model.colours;
  const part = model.parts.find(({ name }) => name === 'skin') ?? model.parts[0];
  const onSkin = model.triangles.subarray(3 * part.first, 3 * (part.first + part.count)).map((corner) => corners[corner]);
  const [red, green, blue] = [0, 1, 2].map((channel) => {
    const values = Uint8Array.from(onSkin, (v) => colours[3 * v + channel]);
    return values.sort()[values.length >> 1] / 255;
  });
  const tone = new Color().setRGB(red, green, blue, SRGBColorSpace);

  const chin = at.get('ibug_08') ?? [0, bounds.min.y, 0];
  const nose = at.get('ibug_30') ?? [0, 0, bounds.max.z];
  const earX = 0.83 * bounds.max.x;
  const brow = at.get('ibug_19') ?? [0, chin[1] + 120, 0];
  const [fadeEnd, fadeStart] = fade;
  // The neck runs out into what is behind it before its cut edge, wherever that is.
  const edge = openEdge(ofSkin).filter((v) => rest[3 * v + 1] < chin[1] + 30);
  const shade = new Float32Array(3 * vertexCount);
  const deep = nostrils(model, onSkin, rest, at.get('ibug_33'), green);
  for (let v = 0; v < vertexCount; v++) {
    const [x, y, z] = [rest[3 * v], rest[3 * v + 1], rest[3 * v + 2]];
    shade[3 * v] = groundwork.open[v] * (1 - deep[v]);
    if (z < nose[2] - 70) {
      const height = Math.max(0, 1 - Math.abs(y - (brow[1] + nose[1]) / 2 + 4) / 48);
      const beside = Math.min(1, Math.max(0, (Math.abs(x) - earX * 0.92) / 8));
      shade[3 * v + 1] = Math.min(1, height * 2.2) * beside;
    }
    const t = Math.min(1, Math.max(0, (y - fadeEnd) / (fadeStart - fadeEnd)));
    let nearest = Infinity;
    if (y < chin[1] + 40) {
      for (const e of edge) {
        const d = (rest[3 * e] - x) ** 2 + (rest[3 * e + 1] - y) ** 2 + (rest[3 * e + 2] - z) ** 2;
        if (d < nearest) nearest = d;
      }
    }
    const s = Math.min(1, Math.max(0, (Math.sqrt(nearest) - 3) / 36));
    shade[3 * v + 2] = t * t * (3 - 2 * t) * s * s * (3 - 2 * s);
  }
  geometry.setAttribute('shade', perCorner(shade));
  const pouch = verticesOf(/^mouth cavity$/);
  // How much of each vertex lies deep in the mouth, not just behind the lips.
  const inside = new Uint8Array(vertexCount);
  const lips = at.get('ibug_66')?.[2] ?? 0;
  for (const v of pouch) inside[v] = 255 * Math.min(1, Math.max(0, (lips - rest[3 * v + 2] - 3) / 2));
  geometry.setAttribute('inside', new BufferAttribute(spread(inside, 1, new Uint8Array(cornerCount)), 1, true));
  const grows = growth(rest, at, verticesOf(/cavit/), ofSkin);
  const grown = Float32Array.from({ length: 2 * vertexCount }, (_, i) => (i % 2 ? grows.beard : grows.scalp)[i >> 1]);
  geometry.setAttribute('growth', new BufferAttribute(spread(grown, 2, new Float32Array(2 * cornerCount)), 2));
  const folding = foldingOf(rest, at).map((part) => 127 * part);
  geometry.setAttribute('folding', new BufferAttribute(spread(folding, 4, new Int8Array(4 * cornerCount)), 4, true));
  geometry.boundingSphere = new Sphere(
    bounds.getCenter(new Vector3()),
    0.6 * bounds.getSize(new Vector3()).length(),
  );

  const pores = createTile(groundwork.pores);
  const skin = createSkin({
    pores,
    face: { map: createMap(groundwork.paint.map), frame: groundwork.paint.frame },
    brows: paintBrows(at),
    depth: nose[2] - 82,
    landmarks: at,
  });
  /** @type {ReturnType<typeof import('../hair/onhead.js').growHair>['tresses']} */
  let tresses = [];
  let disposeHair = () => {};
  const mesh = new Mesh(geometry, skin.material);
  mesh.customDepthMaterial = skin.shadow;
  mesh.castShadow = true;
  mesh.receiveShadow = true;
  mesh.name = 'skin';

  const eyeVertices = eyeVerticesOf(model, rest);
  let present = rest;
  const eyes = createEyes(
    eyeVertices.map((vertices) => ({
      vertices,
      landmark: (name, out) => landmark(present, name, out),
    })),
    pores,
  );
  const vertexOf = (/** @type {string} */ name) => {
    const stencil = stencils.get(name) ?? [[0, 1]];
    return stencil.reduce((best, entry) => (entry[1] > best[1] ? entry : best))[0];
  };
  const lashes = createLashes(ofSkin, rest, vertexOf);
  const teeth = createTeeth(rest, at, pouch, vertexOf);
  eyes.update(rest);
  lashes.update(rest, eyes.centres);
  // How many of the first vertices are of the eyes or of what stands around them.
  const ofEyes = new Uint32Array(vertexCount + 1);
  const edges = eyes.landmarks.flatMap((name) => (stencils.get(name) ?? []).map(([vertex]) => vertex));
  for (const vertex of [...eyeVertices.flat(), ...lashes.vertices, ...edges]) ofEyes[vertex + 1] = 1;
  for (let v = 0; v < vertexCount; v++) ofEyes[v + 1] += ofEyes[v];

  const group = new Group();
  group.add(mesh, ...eyes.meshes, lashes.mesh, ...(teeth?.meshes ?? []));

  /** @type {number[]} */
  const duplicates = [];
  for (let i = vertexCount; i < ownCorners; i++) duplicates.push(i);

  const still = [new Vector3(), new Vector3()];
  /** @type {(expression: Record<string, number>) => Vector3[]} */
  let turnsOf = () => still;
  const unmoved = new Float32Array(3 * (teeth?.anchors.length ?? 0));
  /** @type {(expression: Record<string, number>) => Float32Array} */
  let shiftsOf = () => unmoved;
  teeth?.update(rest, unmoved);

  /** What the skin is folded by and the eyes are turned by. @type {Readonly<Record<string, number>> | null} */
  let folded = null;
  /**
   * Takes over a range of the face's vertices.
   * @param {import('phiz').Face} from
   * @param {readonly [number, number]} [range]
   */
  function update(from, [first, end] = [0, vertexCount]) {
    if (end <= first) return;
    for (const [attribute, array, key] of /** @type {const} */ ([[position, positions, 'positions'], [normal, normals, 'normals']])) {
      array.set(from[key].subarray(3 * first, 3 * end), 3 * first);
      for (const i of duplicates) {
        const o = 3 * corners[i];
        array[3 * i] = array[o];
        array[3 * i + 1] = array[o + 1];
        array[3 * i + 2] = array[o + 2];
      }
      // While nothing is drawn they would become more and more.
      if (attribute.updateRanges.length >= MOST_RANGES) {
        attribute.clearUpdateRanges();
        attribute.addUpdateRange(0, 3 * cornerCount);
      }
      attribute.addUpdateRange(3 * first, 3 * (end - first));
      attribute.addUpdateRange(3 * vertexCount, 3 * (cornerCount - vertexCount));
      attribute.needsUpdate = true;
    }
    finer.curve(positions, normals, first, end);
    present = positions;
    const { expression } = from;
    const isAtRest = Object.keys(expression).length === 0;
    if (expression !== folded) skin.fold(expression);
    const sex = toldOf(from, 'sex');
    const suited = lashes.suit(sex === undefined ? 0 : manlyOf(sex));
    if (suited || ofEyes[end] > ofEyes[first]) {
      eyes.update(present);
      lashes.update(present, eyes.centres);
    }
    // Eyes that turn go by their size as well.
    if (expression !== folded || !isAtRest) eyes.turn(turnsOf(expression), !isAtRest);
    folded = expression;
    for (const one of tresses) one.update(present);
    if (glasses) glasses.update(present, eyes.balls, steadied(expression));
    teeth?.update(present, shiftsOf(expression));
  }

  /** The feature of each region. @type {readonly string[]} */
  let groups = model.regionNames.map(() => 'head');
  /** @type {Map<string, Float32Array>} */
  const soft = new Map();
  /** @param {string} group */
  function softRegion(group) {
    let weights = soft.get(group);
    if (!weights) {
      const inside = groups.map((name) => name === group);
      weights = smoothed(
        Float32Array.from(regionOf, (region) => (inside[region] ? 1 : 0)),
        ofSkin,
        4,
      );
      soft.set(group, weights);
    }
    return weights;
  }

  /**
   * Shows a feature: slot 0 is what the pointer is on, slot 1 what was just picked.
   * @param {0 | 1} slot @param {string | null} group
   */
  function highlight(slot, group) {
    const weights = group === null ? null : softRegion(group);
    for (let i = 0; i < ownCorners; i++) marks[2 * i + slot] = weights ? weights[corners[i]] : 0;
    finer.between(marks, 2);
    mark.needsUpdate = true;
  }

  /**
   * Paints the skin with a colour a vertex in place of its own; null takes it off.
   * @param {Float32Array | null} colours sRGB in 0 to 1, three a vertex
   */
  function paintHeat(colours) {
    skin.uniforms.heatStrength.value = colours ? 1 : 0;
    if (!colours) return;
    spread(colours, 3, heats);
    heat.needsUpdate = true;
  }

  const unworn = skin.uniforms.wornMap.value;
  /** @type {import('three').DataTexture | null} */
  let worn = null;
  /** The colours in which that is as it is. @type {ReturnType<typeof pigments> | null} */
  let wornIn = null;
  /**
   * Shows a person's own colours in place of the skin's; null takes them off.
   * @param {Worn | null} texture
   */
  function wear(texture) {
    worn?.dispose();
    worn = wornIn = null;
    // One that is disposed of comes back with the next frame while a shader has it.
    skin.uniforms.wornMap.value = unworn;
    skin.uniforms.worn.value = texture ? 1 : 0;
    if (!texture) return;
    worn = createMap(texture);
    worn.colorSpace = SRGBColorSpace;
    worn.flipY = true;
    skin.uniforms.wornMap.value = worn;
    wornIn = pigments(tone, texture.colouring);
    paint(colouring);
  }

  /** Draws marks of the skin, once that has come. @type {import('./marking.js').Marking | null} */
  let marking = null;
  /** Once a face has had some on. @type {ReturnType<typeof import('../glasses/glasses.js').createGlasses> | null} */
  let glasses = null;
  /** Where they come from. @type {Wardrobe | null} */
  let wardrobe = null;
  /** Until they are there. @type {Promise<void> | null} */
  let fetching = null;
  /** How far expressions move some vertices. @type {((vertices: number[]) => typeof shiftsOf) | null} */
  let measure = null;
  /** The same of those that glasses go by, measured when it first matters. @type {typeof shiftsOf | null} */
  let steady = null;
  /** @param {Readonly<Record<string, number>>} expression */
  function steadied(expression) {
    if (!glasses || !measure || Object.keys(expression).length === 0) return null;
    steady ??= measure(glasses.vertices);
    return steady(expression);
  }
  /** @type {import('./colouring.js').Colouring} */
  let colouring = {};
  /**
   * @param {import('./colouring.js').Colouring} now
   * @param {boolean} [asks] whether hair that is new is to grow; otherwise whoever paints it finishes it at once
   */
  function paint(now, asks = true) {
    colouring = now;
    const bald = marking ? marking.lay(now) : [];
    if (marking && now.marks) skin.beMarked(marking);
    const paints = { ...pigments(tone, now), bald };
    for (const part of [skin, lashes, eyes]) part.paint(paints);
    for (const one of tresses) one.paint(paints, asks);
    glasses?.paint(now, paints);
    if (wornIn) skin.tint(paints, wornIn);
    if (wearsGlasses(now)) fetchGlasses();
  }
  paint(colouring);

  /** Most faces have none on: what draws them comes for the first that has. */
  function fetchGlasses() {
    if (glasses || !wardrobe || !SEATS.every((name) => at.has(name)) || eyeVertices.length < 2) return;
    const { come, onCome, onMiss } = wardrobe;
    fetching ??= come().then(
      ({ createGlasses }) => {
        glasses = createGlasses({ rest, normals: restNormals, skin: onSkin, mirror: model.mirror, scalp: grows.scalp, at, vertexOf, eyes: ballsOn(rest) }, skin.uniforms);
        group.add(glasses.group);
        steady = null;
        glasses.update(present, eyes.balls, steadied(folded ?? {}));
        glasses.paint(colouring, pigments(tone, colouring));
        fetching = null;
        onCome();
      },
      (why) => {
        // Whoever puts some on asks again.
        fetching = null;
        onMiss(why);
      },
    );
  }

  /**
   * Lets longer hair grow and what is fine on the skin come, which the head that shows first does without. Both are made beside
   * the page when they are first wanted.
   * @param {typeof import('../hair/onhead.js').growHair} grow
   * @param {typeof import('./finework.js').layFinework} lay
   * @param {typeof import('./marking.js').createMarking} mark
   * @param {() => void} onCome something that was wanted has come
   * @param {Wardrobe} glasses
   */
  function adorn(grow, lay, mark, onCome, glasses) {
    wardrobe = glasses;
    skin.refine(lay, onCome);
    marking = mark({ positions: rest, normals: restNormals, triangles: ofSkin });
    const grown = grow({ positions: rest, normals: restNormals, triangles: ofSkin, landmarks: at }, grows, skin.uniforms, fade, onCome);
    ({ tresses, dispose: disposeHair } = grown);
    geometry.setAttribute('parts', new BufferAttribute(spread(grown.parts, 4, new Uint8Array(4 * cornerCount)), 4, true));
    for (const one of tresses) {
      group.add(one.mesh);
      one.update(present);
    }
    paint(colouring);
  }

  /**
   * Tells features apart, which takes a model that has them: the head may be drawn from one that is
   * a face and no more.
   * @param {import('phiz').FaceModel} whole of the same mesh
   */
  function divide(whole) {
    // What belongs to no feature's block is the head's.
    groups = whole.regionGroups.map((g) => (g === null ? 'head' : whole.regions[g]));
    soft.clear();
  }

  /** The eyeballs on a face of the model. @param {Float32Array} positions */
  const ballsOn = (positions) => eyeballsOn(eyeVertices, positions);
  const centresOn = (/** @type {Float32Array} */ positions) => ballsOn(positions).map(({ centre }) => centre);

  /** @param {number} corner of what is drawn */
  const groupAt = (corner) => groups[regionOf[finer.rootsOf(corner)[0]]];

  return {
    group,
    skin: mesh,
    /** Below this height the neck is hardly seen, mm. */
    neckEnd: (fadeEnd + fadeStart) / 2,
    /** What the skin's shader, the eyes' and the teeth are made of, for pictures and files of them. */
    look: skin.look,
    eyeLook: eyes.look,
    /** Where they are on the head at rest. */
    eyeballs: ballsOn(rest),
    /** What the lashes are on a face of the model. @param {Float32Array} positions */
    lashesOn: (positions) => ({ ...lashes.bodies(positions, centresOn(positions)), colour: lashes.colour }),
    /** Where their corners are on another. @param {Float32Array} positions */
    lashesAt: (positions) => lashes.bodiesAt(positions, centresOn(positions)),
    /** The glasses that are worn, part by part, and where their corners are on a face of the model; none where no face has had some on. */
    get glasses() {
      return glasses?.look ?? [];
    },
    /** @param {Float32Array} positions of a face at rest */
    glassesOn: (positions) => glasses?.on(positions, ballsOn(positions)) ?? null,
    /**
     * Until what is fetched for a colouring is there, or will not be; null where nobody has to wait.
     * @param {import('./colouring.js').Colouring} [now] @returns {Promise<void> | null}
     */
    equipping(now = colouring) {
      if (wearsGlasses(now)) fetchGlasses();
      return fetching;
    },
    /** Longer hair and a beard. */
    get tresses() {
      return tresses;
    },
    adorn,
    /** Whether something that is to be seen is still being made. */
    get isUnfinished() {
      return fetching !== null || skin.isUnfinished || tresses.some((one) => one.isGrowing);
    },
    /** Makes it at once, for who cannot wait. */
    finish() {
      skin.finish();
      for (const one of tresses) one.finish();
    },
    /**
     * Lets something paint it otherwise, and paints it as it was.
     * @template T @param {() => T} make @returns {T} what that makes
     */
    lend(make) {
      const before = colouring;
      const worn = tresses.map((one) => one.worn);
      try {
        return make();
      } finally {
        if (colouring !== before) {
          paint(before);
          // Its own hair may not have grown yet, and nobody else's stays until then.
          for (const [i, one] of tresses.entries()) if (one.worn !== worn[i]) one.finish();
        }
      }
    },
    /** Ends what is made beside the page. */
    dispose() {
      skin.dispose();
      glasses?.dispose();
      disposeHair();
    },
    teeth,
    update,
    highlight,
    paintHeat,
    /** What colours it would have. @param {import('./colouring.js').Colouring} then */
    pigments: (then) => pigments(tone, then),
    /** Of the skin at rest, linear. */
    tone,
    /** What it is painted in. */
    get colouring() {
      return colouring;
    },
    paint,
    wear,
    /** The graphics card is gone with what it was given, which the next one is given anew. */
    loseCard: () => worn?.dispose(),
    groupAt,
    /** The vertices that a corner of what is drawn lies on or between. */
    verticesAt: finer.rootsOf,
    /** The triangles of the model's mesh that are drawn as skin, and where their vertices are: at rest, and now. */
    surface: { triangles: ofSkin, rest, positions, normals },
    divide,
    /**
     * @param {typeof turnsOf} turns how far expressions turn the eyes
     * @param {(vertices: number[]) => typeof shiftsOf} shifts how far they move vertices
     */
    expressBy(turns, shifts) {
      turnsOf = turns;
      shiftsOf = shifts(teeth?.anchors ?? []);
      measure = shifts;
      steady = null;
    },
    /** @param {number} index of a vertex, on the face as it is now */
    vertex: (index) => new Vector3().fromArray(present, 3 * index),
    /** @param {string} name of a landmark, on the face as it is now */
    landmark(name) {
      const found = landmark(present, name, new Vector3());
      if (!found) throw new Error(`no landmark is called "${name}"`);
      return found;
    },
    /** Whether the skin shows heat, 0 or 1. */
    heatStrength: skin.uniforms.heatStrength,
    /** Whether a person's own colours are worn, and how much of them shows. */
    get wears() {
      return worn !== null;
    },
    wornStrength: skin.uniforms.worn,
    /** How strongly the two highlights show, 0 to 1. */
    markStrength: skin.uniforms.markStrength.value,
    /** Whether neither is to show, whatever is under a pointer. */
    unmarked: false,
  };
}

/**
 * Colours that a head wears in place of its skin's, as `PhotoEdit.texture` has them, and the looks in which they are worn as they are: others
 * change them by as much as the skin's own.
 * @typedef {{ size: number, rgba: Uint8ClampedArray, colouring: import('./colouring.js').Colouring }} Worn
 */

/**
 * Where glasses are fetched from when a face first has some on; what is to be done when they have come, and when they have not.
 * @typedef {{ come: () => Promise<typeof import('../glasses/glasses.js')>, onCome: () => void, onMiss: (why: unknown) => void }} Wardrobe
 */
