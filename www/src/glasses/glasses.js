import { BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Group, Mesh, MeshDepthMaterial, MeshPhysicalMaterial, ShaderMaterial } from 'three';
import { valueIn, wearsGlasses } from '../head/colouring.js';
import { RUNS_OUT } from '../rendering/backdrop.js';
import { STUDIO_GLSL, studioUniforms } from '../rendering/environment.js';
import { armHalf, createFit, STATIONS } from './fit.js';
import { frontOf, KINDS } from './frame.js';
import { along, AROUND, rings, rounded, weave } from './sweep.js';
import { styleOf } from './style.js';
import { tintsOf } from './tint.js';

// A pair of glasses on a head: what is made once for a style, and where that is on a face.

/** From which station on an arm of metal has a tip of plastic over it. */
const SLEEVE = 17;
/** Rings of a pad, which is a flat ball, and stations of what holds it. */
const PAD_RINGS = 7;
const HOLDER = 7;
/** Glass mirrors more than this only where it is seen from aside; of both its sides together. */
const MIRRORS = 0.042;
/** And no more than this, of the studio's, where it is seen from aside. */
const MOST = 0.6;
/** Spots of tortoiseshell are about as large, mm. */
const SPOT = 6.5;
/** Styles that are kept, of a quarter of a megabyte each. */
const KEPT = 4;

const LENS_VERTEX = /* glsl */ `
  attribute float edge;
  attribute float high;
  uniform float heatStrength;
  varying vec3 vAt;
  varying vec3 vOut;
  varying float vEdge;
  varying float vHigh;
  void main() {
    vHigh = high;
    vec4 world = modelMatrix * vec4(position, 1.0);
    vAt = world.xyz;
    vOut = mat3(modelMatrix) * normal;
    vEdge = edge;
    // What is measured is the head.
    gl_Position = heatStrength > 0.5 ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * viewMatrix * world;
  }
`;
const LENS_FRAGMENT = /* glsl */ `
  ${STUDIO_GLSL}
  uniform vec3 tint;
  uniform float taken;
  uniform float rimless;
  varying vec3 vAt;
  varying vec3 vOut;
  varying float vEdge;
  varying float vHigh;
  void main() {
    vec3 n = normalize(vOut);
    vec3 toEye = normalize(cameraPosition - vAt);
    float facing = max(0.0, dot(n, toEye));
    float fresnel = ${MIRRORS.toFixed(3)} + ${(MOST - MIRRORS).toFixed(3)} * pow(1.0 - facing, 5.0);
    // What stands in a soft box is bright, and eyes are to be seen all the same: lenses are coated.
    vec3 mirrored = studioMirrored(reflect(-toEye, n), 0.0) * 0.62;
    mirrored = mirrored / (1.0 + 0.12 * mirrored) * fresnel * (1.0 + 0.3 * taken);
    // Tinted ones are darker above.
    float shaded = taken * mix(1.0, mix(0.5, 1.0, vHigh), min(1.0, 2.0 * (1.0 - taken)));
    float cover = mix(shaded, max(taken, 0.55), vEdge * rimless);
    vec3 own = mix(tint * studioLightOn(n) * 0.62, vec3(0.42, 0.5, 0.48), 0.7 * vEdge * rimless * (1.0 - taken)) * cover;
    // An edge in a rim is not seen.
    if (vEdge > 0.5 && rimless < 0.5) discard;
    gl_FragColor = vec4(own + mirrored, min(1.0, cover + 0.5 * fresnel));
    #include <tonemapping_fragment>
    #include <colorspace_fragment>
  }
`;

/** A number for a place of a grid, 0 to 1. @param {number} x @param {number} y @param {number} z */
function grain(x, y, z) {
  let n = (x * 374761393 + y * 668265263 + z * 1274126177) | 0;
  n = Math.imul(n ^ (n >>> 13), 1274126177);
  return ((n ^ (n >>> 16)) >>> 0) / 0xffffffff;
}
/** How much of a spot is at a place, 0 to 1. @param {number} x @param {number} y @param {number} z mm */
function spot(x, y, z) {
  const at = [x / SPOT, y / SPOT, z / SPOT];
  const low = at.map(Math.floor);
  const part = at.map((value, k) => value - low[k]).map((t) => t * t * (3 - 2 * t));
  let sum = 0;
  for (let i = 0; i < 8; i++) {
    const [dx, dy, dz] = [i & 1, (i >> 1) & 1, i >> 2];
    sum += grain(low[0] + dx, low[1] + dy, low[2] + dz) * (dx ? part[0] : 1 - part[0]) * (dy ? part[1] : 1 - part[1]) * (dz ? part[2] : 1 - part[2]);
  }
  return Math.min(1, Math.max(0, (sum - 0.5) * 3.2 + 0.25));
}

/**
 * What a style is made of, wherever it is then: corners that are placed by a fit.
 * @param {import('./style.js').Style} style
 */
function make(style) {
  const front = frontOf(style);
  const isPlastic = style.plastic > 0.5;
  const armRings = (/** @type {number} */ from) => STATIONS - from + 5;
  /** With room for what each face has elsewhere: first what is fixed to the front, then for either side arm, tip, pad and what holds that. @param {import('./frame.js').Kind} kind */
  function bodyOf(kind) {
    const { positions, normals, triangles, shift } = front.parts[kind];
    const fixed = shift.length;
    const list = [...triangles];
    let many = fixed;
    const add = (/** @type {number} */ rings) => {
      weave(rings, false, list, many);
      many += rings * AROUND;
    };
    for (let side = 0; side < 2; side++) {
      if (kind === 'main') add(armRings(0));
      if (kind === 'plastic' && !isPlastic) add(armRings(SLEEVE) + 5);
      if (kind === (isPlastic ? 'main' : 'plastic')) add(PAD_RINGS);
      if (kind === 'metal' && !isPlastic) add(HOLDER);
    }
    return {
      fixed,
      local: Float32Array.from(positions),
      out: Float32Array.from(normals),
      shift: Float32Array.from(shift),
      triangles: list,
      positions: new Float32Array(3 * many),
      normals: new Float32Array(3 * many),
    };
  }
  const bodies = { main: bodyOf('main'), metal: bodyOf('metal'), plastic: bodyOf('plastic') };
  const { lenses } = front;
  const glass = { fixed: lenses.shift.length, local: Float32Array.from(lenses.positions), out: Float32Array.from(lenses.normals), shift: Float32Array.from(lenses.shift), triangles: lenses.triangles, positions: new Float32Array(lenses.positions.length), normals: new Float32Array(lenses.positions.length), edge: Float32Array.from(lenses.edge), high: Float32Array.from({ length: lenses.shift.length }, (_, i) => 0.5 + lenses.positions[3 * i + 1] / style.height) };

  /** @param {typeof glass | typeof bodies['main']} body @param {import('./fit.js').Fitted} fitted */
  function placeFixed({ fixed, local, out, shift, positions, normals }, { scale, axes: [X, Y, Z], origin, aside }) {
    const [xx, xy] = X;
    const [yx, yy, yz] = Y;
    const [zx, zy, zz] = Z;
    const [ox, oy, oz] = origin;
    for (let i = 0, o = 0; i < fixed; i++, o += 3) {
      const x = scale * (local[o] + shift[i] * aside);
      const y = scale * local[o + 1];
      const z = scale * local[o + 2];
      positions[o] = ox + xx * x + yx * y + zx * z;
      positions[o + 1] = oy + xy * x + yy * y + zy * z;
      positions[o + 2] = oz + yz * y + zz * z;
      const nx = out[o];
      const ny = out[o + 1];
      const nz = out[o + 2];
      normals[o] = xx * nx + yx * ny + zx * nz;
      normals[o + 1] = xy * nx + yy * ny + zy * nz;
      normals[o + 2] = yz * ny + zz * nz;
    }
  }

  /** @param {import('./fit.js').Fitted} fitted */
  function place(fitted) {
    for (const body of [...Object.values(bodies), glass]) placeFixed(body, fitted);
    const at = { main: 3 * bodies.main.fixed, metal: 3 * bodies.metal.fixed, plastic: 3 * bodies.plastic.fixed };
    /** @param {keyof typeof at} kind @param {readonly import('./sweep.js').Station[]} way */
    const draw = (kind, way) => {
      at[kind] = rings(way, bodies[kind].positions, bodies[kind].normals, at[kind]);
    };
    for (const side of [0, 1]) {
      const points = fitted.arms[side];
      const way = along(points, UP, (i) => armHalf(style, i), isPlastic);
      draw('main', ended(way, armRings(0)));
      if (!isPlastic) {
        const sleeve = way.slice(SLEEVE).map((one, i) => {
          const thick = 0.5 * Math.min(1, 0.55 + 0.15 * i);
          return { ...one, a: one.a + thick, b: one.b + 1.9 * thick };
        });
        draw('plastic', ended(sleeve, armRings(SLEEVE) + 5, true));
      }
      const { from, at: on, facing } = fitted.pads[side];
      draw(isPlastic ? 'main' : 'plastic', pad(from, on, facing, isPlastic));
      if (!isPlastic) draw('metal', holder(from, on, facing));
    }
  }

  return { front, bodies, glass, place, isPlastic };
}

/** @type {import('./sweep.js').Point} */
const UP = [0, 1, 0];

/** A way with round ends, of just as many rings as there is room for. @param {readonly import('./sweep.js').Station[]} way @param {number} many @param {boolean} [both] ends are round */
function ended(way, many, both = false) {
  const done = capped(way, both);
  if (done.length !== many) throw new Error(`an arm has ${done.length} rings and room for ${many}`);
  return done;
}
/** @param {readonly import('./sweep.js').Station[]} way @param {boolean} both */
function capped(way, both) {
  const cap = (/** @type {import('./sweep.js').Station} */ end, /** @type {import('./sweep.js').Station} */ next) =>
    [0.5, 0.75, 0.9, 0.97, 1].map((t) => {
      const left = Math.max(0.02, Math.sqrt(1 - t * t));
      const reach = 0.9 * Math.min(end.b, 2) * t;
      const length = Math.hypot(end.at[0] - next.at[0], end.at[1] - next.at[1], end.at[2] - next.at[2]);
      return { ...end, at: /** @type {import('./sweep.js').Point} */ (end.at.map((value, k) => value + ((value - next.at[k]) / length) * reach)), a: end.a * left, b: end.b * left };
    });
  const last = way.length - 1;
  return [...(both ? cap(way[0], way[1]).reverse() : []), ...way, ...cap(way[last], way[last - 1])];
}

/** A pad lies flat on the skin; one of plastic is of a piece with the rim. @param {import('./sweep.js').Point} from @param {import('./sweep.js').Point} on @param {import('./sweep.js').Point} facing @param {boolean} isPlastic */
function pad(from, on, facing, isPlastic) {
  // Along the nose, upright to the way it faces.
  const d = facing[1];
  const y = Math.sqrt(1 - d * d);
  const long = /** @type {import('./sweep.js').Point} */ ([(-facing[0] * d) / y, (1 - d * d) / y, (-facing[2] * d) / y]);
  const v = facing;
  /** @type {import('./sweep.js').Point} */
  const u = [v[1] * long[2] - v[2] * long[1], v[2] * long[0] - v[0] * long[2], v[0] * long[1] - v[1] * long[0]];
  const apart = from.map((value, k) => value - on[k]);
  const off = Math.abs(apart[0] * v[0] + apart[1] * v[1] + apart[2] * v[2]);
  const [half, thick, broad] = isPlastic ? [6, Math.max(1.2, 0.55 * off), 2.6] : [5.6, 0.95, 3];
  return Array.from({ length: PAD_RINGS }, (_, i) => {
    const angle = (Math.PI * i) / (PAD_RINGS - 1);
    const [s, c] = [Math.max(0.02, Math.sin(angle)), -Math.cos(angle)];
    const at = /** @type {import('./sweep.js').Point} */ (on.map((value, k) => value + half * c * long[k] + thick * 0.8 * facing[k]));
    return { at, u, v, a: broad * s ** 0.8, b: thick * s ** 0.8 };
  });
}

/** The wire from the rim to a pad. @param {import('./sweep.js').Point} from @param {import('./sweep.js').Point} on @param {import('./sweep.js').Point} facing */
function holder(from, on, facing) {
  const to = /** @type {import('./sweep.js').Point} */ (on.map((value, k) => value + 1.6 * facing[k]));
  // Back from the rim first, then over to the pad.
  const over = [from[0] + 0.2 * (to[0] - from[0]), from[1] + 0.3 * (to[1] - from[1]), Math.min(from[2], to[2]) - 2.2];
  const points = Array.from({ length: HOLDER }, (_, i) => {
    const t = i / (HOLDER - 1);
    return /** @type {import('./sweep.js').Point} */ ([0, 1, 2].map((k) => (1 - t) ** 2 * from[k] + 2 * t * (1 - t) * over[k] + t * t * to[k]));
  });
  return along(points, UP, () => [0.42, 0.42]);
}

/**
 * @param {Parameters<typeof createFit>[0]} on the head at rest
 * @param {{ heatStrength: { value: number } }} uniforms of the skin
 */
export function createGlasses(on, { heatStrength }) {
  const { fit, vertices } = createFit(on);
  /** Where these are in a face that does nothing, while it does something. */
  const calm = new Float32Array(on.rest.length);
  /** The styles that were worn last, and what of them is on the card: two faces side by side are drawn in turn. @type {Worn[]} */
  const kept = [];
  /** @type {ReturnType<typeof make> | null} */
  let made = null;
  let lift = 0;
  /** @type {import('./style.js').Style | null} */
  let style = null;
  let tints = tintsOf({});
  let skin = new Color();

  const group = new Group();
  group.name = 'glasses';
  /** @param {import('three').Material} material */
  const hideInHeat = (material) => {
    material.onBeforeCompile = (shader) => {
      shader.uniforms.heatStrength = heatStrength;
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', '#include <common>\nuniform float heatStrength;')
        .replace('#include <project_vertex>', '#include <project_vertex>\nif (heatStrength > 0.5) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);');
    };
    return material;
  };
  const depth = hideInHeat(new MeshDepthMaterial());
  const materials = {
    main: new MeshPhysicalMaterial({ vertexColors: true }),
    metal: new MeshPhysicalMaterial({ vertexColors: true, metalness: 1, roughness: 0.3 }),
    plastic: new MeshPhysicalMaterial({ vertexColors: true, roughness: 0.35 }),
  };
  const meshes = Object.fromEntries(
    Object.entries(materials).map(([kind, material]) => {
      const mesh = new Mesh(new BufferGeometry(), hideInHeat(material));
      mesh.customDepthMaterial = depth;
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.name = `glasses ${kind}`;
      return [kind, mesh];
    }),
  );
  const glass = {
    tint: { value: new Color() },
    taken: { value: 0 },
    rimless: { value: 0 },
  };
  const lenses = new Mesh(
    new BufferGeometry(),
    new ShaderMaterial({ uniforms: { ...studioUniforms, ...glass, heatStrength }, vertexShader: LENS_VERTEX, fragmentShader: LENS_FRAGMENT, transparent: true, depthWrite: false, ...RUNS_OUT }),
  );
  lenses.name = 'lenses';
  // After lashes, which are behind them.
  lenses.renderOrder = 0.5;
  for (const mesh of [...Object.values(meshes), lenses]) {
    mesh.frustumCulled = false;
    // Who clicks means the face behind them.
    mesh.raycast = () => {};
    group.add(mesh);
  }
  group.visible = false;
  /** @type {readonly [ArrayLike<number>, readonly import('./fit.js').Eye[]] | null} */
  let present = null;

  /** The colours of a body's corners, linear. @param {import('./frame.js').Kind} kind */
  function coloursOf(kind) {
    if (!made) return new Float32Array(0);
    const { positions, local, fixed } = made.bodies[kind];
    const colours = new Float32Array(positions.length);
    const { colour, spots, metal } = tints.frame;
    // What is small and of metal is of that of the frame, if that is one.
    const trim = new Color('#b9975a');
    const base = kind === 'main' ? colour : kind === 'metal' ? trim.lerp(colour, metal) : null;
    const tip = new Color('#1b1310');
    const pads = new Color('#e9e2d8').lerp(skin, 0.82);
    const one = new Color();
    const each = (positions.length / 3 - fixed) / 2;
    for (let i = 0; i < positions.length / 3; i++) {
      if (kind === 'plastic') {
        one.copy((i - fixed) % each >= each - PAD_RINGS * AROUND ? pads : tip);
      } else if (base) {
        one.copy(base);
        if (kind === 'main') {
          const j = i - fixed;
          // Arms have a grain of their own, along their way.
          const at = j < 0 ? [local[3 * i], local[3 * i + 1], local[3 * i + 2]] : [60 + (j >= each ? 90 : 0), 3 * Math.sin((2 * Math.PI * (j % AROUND)) / AROUND), 6.5 * Math.floor((j % each) / AROUND)];
          one.lerp(spots, spot(at[0], at[1], at[2]));
        }
      }
      one.toArray(colours, 3 * i);
    }
    return colours;
  }

  function follow() {
    if (!group.visible || !made || !style || !present) return;
    made.place(fit(present[0], present[1], style, made.front, lift));
    for (const mesh of group.children) {
      const { attributes } = /** @type {Mesh} */ (mesh).geometry;
      attributes.position.needsUpdate = attributes.normal.needsUpdate = true;
    }
  }

  /** A style with what is drawn of it. @param {string} key @param {import('./style.js').Style} style @returns {Worn} */
  function tailor(key, style) {
    const made = make(style);
    /** @param {typeof made.glass | typeof made.bodies['main']} body */
    const geometryOf = (body) => {
      const geometry = new BufferGeometry();
      geometry.setIndex(body.triangles);
      geometry.setAttribute('position', new BufferAttribute(body.positions, 3).setUsage(DynamicDrawUsage));
      geometry.setAttribute('normal', new BufferAttribute(body.normals, 3).setUsage(DynamicDrawUsage));
      if ('edge' in body) for (const name of /** @type {const} */ (['edge', 'high'])) geometry.setAttribute(name, new BufferAttribute(body[name], 1));
      else geometry.setAttribute('color', new BufferAttribute(new Float32Array(body.positions.length), 3));
      return geometry;
    };
    const { main, metal, plastic } = made.bodies;
    return { key, style, made, dye: '', geometries: { main: geometryOf(main), metal: geometryOf(metal), plastic: geometryOf(plastic), lenses: geometryOf(made.glass) } };
  }

  /** @param {string} key @param {import('./style.js').Style} now */
  function wear(key, now) {
    const at = kept.findIndex((one) => one.key === key);
    const one = at < 0 ? tailor(key, now) : kept.splice(at, 1)[0];
    kept.unshift(one);
    for (const old of kept.splice(KEPT)) for (const geometry of Object.values(old.geometries)) geometry.dispose();
    made = one.made;
    style = one.style;
    for (const [kind, geometry] of Object.entries(one.geometries)) {
      const mesh = kind === 'lenses' ? lenses : meshes[kind];
      mesh.geometry = geometry;
      mesh.visible = (geometry.index?.count ?? 0) > 0;
    }
    return one;
  }

  return {
    group,
    /** The vertices whose shifts it wants to know. */
    vertices,
    /**
     * @param {ArrayLike<number>} positions of the face as it is @param {readonly import('./fit.js').Eye[]} eyes of it, the subject's right first
     * @param {ArrayLike<number> | null} shifts how far what it does moves `vertices`, 3 each, mm: glasses stay on a nose that is wrinkled, and
     *   do not shake with each blink
     */
    update(positions, eyes, shifts) {
      if (shifts) {
        for (let i = 0; i < vertices.length; i++) {
          const o = 3 * vertices[i];
          for (let k = 0; k < 3; k++) calm[o + k] = positions[o + k] - shifts[3 * i + k];
        }
      }
      present = [shifts ? calm : positions, eyes];
      follow();
    },
    /**
     * @param {import('../head/colouring.js').Colouring} colouring
     * @param {{ skin: Color, lift: number }} paints what the skin is of, and how far off it hair is that is cropped
     */
    paint(colouring, paints) {
      group.visible = wearsGlasses(colouring);
      if (!group.visible) return;
      const now = styleOf(colouring);
      tints = tintsOf(colouring);
      skin = paints.skin;
      lift = paints.lift;
      const one = wear(JSON.stringify(now), now);
      const dye = JSON.stringify([valueIn(colouring, 'frameColour'), skin.getHex()]);
      if (one.dye !== dye) {
        one.dye = dye;
        for (const kind of KINDS) {
          const { color } = one.geometries[kind].attributes;
          color.array.set(coloursOf(kind));
          color.needsUpdate = true;
        }
      }
      const { metal } = tints.frame;
      materials.main.metalness = metal;
      materials.main.roughness = 0.3 - 0.02 * metal;
      materials.main.clearcoat = 0.5 * (1 - metal);
      materials.main.clearcoatRoughness = 0.08;
      glass.tint.value.copy(tints.lens.colour);
      glass.taken.value = tints.lens.taken;
      glass.rimless.value = now.isRimless || now.half > 0.5 ? 1 : 0;
      follow();
    },
    /**
     * Where its corners are on any face of the model, by part, and how that was found; null where none is worn.
     * @param {ArrayLike<number>} positions at rest @param {readonly import('./fit.js').Eye[]} eyes
     */
    on(positions, eyes) {
      if (!made || !style || !group.visible) return null;
      const fitted = fit(positions, eyes, style, made.front, lift);
      made.place(fitted);
      const { bodies, glass } = made;
      const copy = (/** @type {{ positions: Float32Array, normals: Float32Array }} */ body) => ({ positions: body.positions.slice(), normals: body.normals.slice() });
      const all = { main: copy(bodies.main), metal: copy(bodies.metal), plastic: copy(bodies.plastic), lenses: copy(glass), fitted };
      follow();
      return all;
    },
    /** What the parts are made of, for files; none where no glasses are worn. */
    get look() {
      if (!made || !group.visible) return [];
      const { bodies, glass: sheet } = made;
      const { lens, frame } = tints;
      const of = (/** @type {import('./frame.js').Kind} */ kind) => ({ colours: coloursOf(kind), triangles: Uint32Array.from(bodies[kind].triangles) });
      const all = [
        { kind: /** @type {const} */ ('main'), name: 'glasses frame', ...of('main'), roughness: materials.main.roughness, metalness: frame.metal, opacity: 1 },
        { kind: /** @type {const} */ ('metal'), name: 'glasses metal', ...of('metal'), roughness: materials.metal.roughness, metalness: 1, opacity: 1 },
        { kind: /** @type {const} */ ('plastic'), name: 'glasses pads', ...of('plastic'), roughness: materials.plastic.roughness, metalness: 0, opacity: 1 },
        { kind: /** @type {const} */ ('lenses'), name: 'lenses', colours: Float32Array.from(sheet.positions, (_, i) => lens.colour.toArray()[i % 3]), triangles: Uint32Array.from(sheet.triangles), roughness: 0.05, metalness: 0, opacity: Math.max(0.08, lens.taken) },
      ];
      return all.filter(({ triangles }) => triangles.length > 0);
    },
    dispose() {
      for (const { geometries } of kept) for (const geometry of Object.values(geometries)) geometry.dispose();
      for (const material of [...Object.values(materials), lenses.material, depth]) material.dispose();
    },
  };
}

/**
 * A style that was worn, and what its corners are coloured for.
 * @typedef {{ key: string, style: import('./style.js').Style, made: ReturnType<typeof make>, dye: string, geometries: Record<import('./frame.js').Kind | 'lenses', BufferGeometry> }} Worn
 */
