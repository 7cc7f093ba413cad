import { ByteWriter } from './bytes.js';
import { checkAppearance, checkMeasured, optionsOf } from './checks.js';
import { aroundGaze, isEyeball } from './eyeballs.js';
import { meshOf, needFace, provenance } from './mesh.js';
import { tangentsOf } from './tangents.js';
import { atRest, expressionTargets, morphTargets } from './targets.js';

// glTF 2.0, the numbers of its enumerations.
const LINEAR = 9729;
const LINEAR_MIPMAP_LINEAR = 9987;
const CLAMP_TO_EDGE = 33071;
const UNSIGNED_SHORT = 5123;
const UNSIGNED_INT = 5125;
const FLOAT = 5126;
const ARRAY_BUFFER = 34962;
const ELEMENT_ARRAY_BUFFER = 34963;

/** glTF has metres. */
const METRES = 1e-3;
/** What is not moved by more than this (mm) by one sigma is not moved: of all controls at once nobody sees it. */
const STILL = 2e-3;
/** How far a normal of length 1 may be off: between two and three of 255 shades, 0.6 degrees. */
const SHADE = 0.01;

/** sRGB byte to linear. @param {number} byte */
function linear(byte) {
  const s = byte / 255;
  return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
}

/** @param {number} length */
const padded = (length) => (length + 3) & ~3;

/** The one buffer, and the views and accessors that say what is in it. */
class Buffer {
  /** @type {object[]} */
  views = [];
  /** @type {object[]} */
  accessors = [];
  /** @type {Uint8Array[]} */
  chunks = [];
  length = 0;

  /** @param {ArrayBufferView} data @param {number} [target] */
  view(data, target) {
    const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
    this.views.push({
      buffer: 0,
      byteOffset: this.length,
      byteLength: bytes.length,
      ...(target && { target }),
    });
    this.chunks.push(bytes, new Uint8Array(padded(bytes.length) - bytes.length));
    this.length += padded(bytes.length);
    return this.views.length - 1;
  }

  /** @param {object} accessor */
  accessor(accessor) {
    this.accessors.push(accessor);
    return this.accessors.length - 1;
  }
}

/** The least and the greatest of each component. @param {Float32Array} xyz */
function bounds(xyz) {
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  for (let o = 0; o < xyz.length; o += 3) {
    for (let k = 0; k < 3; k++) {
      const value = xyz[o + k];
      if (value < min[k]) min[k] = value;
      if (value > max[k]) max[k] = value;
    }
  }
  return { min, max };
}

/**
 * A vector a corner from one a vertex.
 * @param {Float32Array} xyz @param {Uint32Array} corners @param {number} scale
 */
function perCorner(xyz, corners, scale) {
  const out = new Float32Array(3 * corners.length);
  for (let i = 0; i < corners.length; i++) {
    const o = 3 * corners[i];
    out[3 * i] = xyz[o] * scale;
    out[3 * i + 1] = xyz[o + 1] * scale;
    out[3 * i + 2] = xyz[o + 2] * scale;
  }
  return out;
}

/**
 * Changes of normals without those that nobody sees, which are half of a file: what is shorter than
 * `SHADE` goes, and so that no edge is left where it begins, what is longer loses the less of it the longer
 * it is. Nothing is off by more than `SHADE`.
 * @param {Float32Array} xyz
 */
function withoutFaint(xyz) {
  const out = new Float32Array(xyz.length);
  for (let o = 0; o < xyz.length; o += 3) {
    const [x, y, z] = [xyz[o], xyz[o + 1], xyz[o + 2]];
    const square = x * x + y * y + z * z;
    if (square <= SHADE * SHADE) continue;
    const left = 1 - (SHADE * SHADE) / square;
    out[o] = x * left;
    out[o + 1] = y * left;
    out[o + 2] = z * left;
  }
  return out;
}

/**
 * Displacements as an accessor: most targets move a part of the face, and then only that is kept.
 * @param {Buffer} buffer @param {Float32Array} xyz three a vertex @param {Uint32Array} corners the vertex of each corner
 * @param {number} scale @param {number} still what does not move by more along any axis does not move
 */
function displacement(buffer, xyz, corners, scale, still) {
  const count = corners.length;
  const moving = new Uint32Array(count);
  let many = 0;
  for (let i = 0; i < count; i++) {
    const o = 3 * corners[i];
    if (Math.abs(xyz[o]) > still || Math.abs(xyz[o + 1]) > still || Math.abs(xyz[o + 2]) > still) moving[many++] = i;
  }
  const shape = { componentType: FLOAT, count, type: 'VEC3' };
  const wide = count > 0xffff;
  // Three floats of all corners, or of some with their numbers.
  if ((wide ? 16 : 14) * many > 12 * count) {
    const all = perCorner(xyz, corners, scale);
    return buffer.accessor({ bufferView: buffer.view(all, ARRAY_BUFFER), ...shape, ...bounds(all) });
  }
  // What is left out is zero, so zero is within the bounds; a sparse array is not empty.
  if (many === 0) return buffer.accessor({ ...shape, min: [0, 0, 0], max: [0, 0, 0] });
  const values = perCorner(xyz, moving.subarray(0, many).map((i) => corners[i]), scale);
  const { min, max } = bounds(values);
  const indices = wide ? moving.slice(0, many) : Uint16Array.from(moving.subarray(0, many));
  return buffer.accessor({
    ...shape,
    min: min.map((x) => Math.min(0, x)),
    max: max.map((x) => Math.max(0, x)),
    sparse: {
      count: many,
      indices: { bufferView: buffer.view(indices), componentType: wide ? UNSIGNED_INT : UNSIGNED_SHORT },
      values: { bufferView: buffer.view(values) },
    },
  });
}

/** Of length 1, as glTF wants them; what has no direction points up. @param {Float32Array} normals three a vertex */
function unit(normals) {
  const out = normals.slice();
  for (let i = 0; i < out.length; i += 3) {
    const length = Math.hypot(out[i], out[i + 1], out[i + 2]);
    if (length > 0) for (let k = i; k < i + 3; k++) out[k] /= length;
    else out[i + 1] = 1;
  }
  return out;
}

/** @param {ArrayLike<number>} rgb linear, three a vertex; what is not within 0 to 1 is cut off */
function colours16(rgb) {
  const colour = new Uint16Array((4 * rgb.length) / 3);
  for (let i = 0; i < colour.length / 4; i++) {
    for (let k = 0; k < 3; k++) colour[4 * i + k] = Math.round(65_535 * Math.max(0, Math.min(1, rgb[3 * i + k])));
    colour[4 * i + 3] = 65_535;
  }
  return colour;
}

/**
 * Binary glTF 2.0, in metres: one mesh whose first vertices are the model's in its order, with
 * vertex colours and, unless they are not wanted, a named morph target for each control and then for
 * each expression that the model has loaded. A weight of 1 moves the face by one standard deviation of
 * the control, or is all of the expression. The file's own face is at rest, with the weights of the
 * expression that it shows; without targets, what it shows is the mesh. With an appearance it has that
 * in place of colours, and its parts as meshes of their own.
 *
 * @param {import('phiz').Face} face
 * @param {{
 *   targets?: boolean, targetNormals?: boolean, appearance?: import('./index.js').Appearance,
 *   measured?: { controls: readonly import('./index.js').MorphTarget[], expressions: readonly import('./index.js').ExpressionTarget[] },
 * }} [options]
 */
export function toGlb(face, options) {
  const { targets = true, targetNormals = true, appearance, measured } = optionsOf('toGlb', options, ['targets', 'targetNormals', 'appearance', 'measured']);
  needFace(face);
  if (appearance) checkAppearance(appearance, targets);
  if (targets && measured) checkMeasured(measured, face.model.vertexCount);
  const { controls: morphs, expressions } = targets ? (measured ?? { controls: morphTargets(face), expressions: expressionTargets(face) }) : { controls: [], expressions: [] };
  const base = targets ? atRest(face) : face;
  const { positions, normals, colours, uvs, corners, triangles, parts } = meshOf(base);
  if (base !== face) base.free();
  const count = corners.length;
  const buffer = new Buffer();

  /** @param {Uint32Array} list @param {number} [vertices] how many they are of */
  function indicesOf(list, vertices = count) {
    const wide = vertices > 0xffff;
    return buffer.accessor({
      bufferView: buffer.view(wide ? list : Uint16Array.from(list), ELEMENT_ARRAY_BUFFER),
      componentType: wide ? UNSIGNED_INT : UNSIGNED_SHORT,
      count: list.length,
      type: 'SCALAR',
    });
  }
  const trianglesOf = (/** @type {import('phiz').Part} */ { first, count: many }) => triangles.subarray(3 * first, 3 * (first + many));
  /** @param {readonly import('phiz').Part[]} some */
  const allOf = (some) => Uint32Array.from(some.flatMap((part) => Array.from(trianglesOf(part))));
  const coordinates = appearance?.eyes ? aroundGaze(face, appearance.eyes.reach) : uvs;

  /** @type {object[]} */
  const images = [];
  /** @type {object[]} */
  const textures = [];
  /** @param {import('./index.js').Picture} picture @param {string} name */
  function texture({ mimeType, bytes }, name) {
    images.push({ name, mimeType, bufferView: buffer.view(bytes) });
    textures.push({ sampler: 0, source: images.length - 1 });
    return { index: textures.length - 1 };
  }
  const vectors = { componentType: FLOAT, count };
  const position = perCorner(positions, corners, METRES);
  const attributes = {
    POSITION: buffer.accessor({
      bufferView: buffer.view(position, ARRAY_BUFFER),
      ...vectors,
      type: 'VEC3',
      ...bounds(position),
    }),
    NORMAL: buffer.accessor({
      bufferView: buffer.view(perCorner(normals, corners, 1), ARRAY_BUFFER),
      ...vectors,
      type: 'VEC3',
    }),
    TEXCOORD_0: buffer.accessor({
      // glTF counts rows of a picture from its top.
      bufferView: buffer.view(coordinates.map((x, i) => (i % 2 ? 1 - x : x)), ARRAY_BUFFER),
      ...vectors,
      type: 'VEC2',
    }),
    ...(appearance && {
      TANGENT: buffer.accessor({
        bufferView: buffer.view(tangentsOf(positions, normals, corners, coordinates, triangles), ARRAY_BUFFER),
        ...vectors,
        type: 'VEC4',
      }),
    }),
    ...(!appearance && {
      COLOR_0: buffer.accessor({
        bufferView: buffer.view(colours16(Array.from({ length: 3 * count }, (_, i) => linear(colours[3 * corners[Math.floor(i / 3)] + (i % 3)]))), ARRAY_BUFFER),
        componentType: UNSIGNED_SHORT,
        normalized: true,
        count,
        type: 'VEC4',
      }),
    }),
  };

  const targetAccessors = [...morphs, ...expressions].map((target) => {
    /** @type {Record<string, number>} */
    const accessors = { POSITION: displacement(buffer, target.positions, corners, METRES, STILL) };
    if (targetNormals) accessors.NORMAL = displacement(buffer, withoutFaint(target.normals), corners, 1, 0);
    return accessors;
  });

  /** @type {object[]} */
  const materials = [];
  const primitive = (/** @type {number} */ indices, /** @type {object} */ material) => {
    materials.push(material);
    return { attributes, indices, material: materials.length - 1, ...(targetAccessors.length && { targets: targetAccessors }) };
  };
  const matt = { metallicFactor: 0, roughnessFactor: 0.55 };
  /** @type {object[]} */
  let primitives;
  if (appearance) {
    const { skin, eyes } = appearance;
    const surface = texture(skin.surface, 'skin surface');
    primitives = [
      primitive(indicesOf(eyes ? allOf(parts.filter((part) => !isEyeball(part))) : triangles), {
        name: 'skin',
        // Past an eyeball the wall behind it is seen from either side.
        doubleSided: true,
        pbrMetallicRoughness: { baseColorTexture: texture(skin.colour, 'skin colour'), metallicFactor: 0, metallicRoughnessTexture: surface },
        occlusionTexture: surface,
        normalTexture: texture(skin.normal, 'skin normal'),
      }),
    ];
    const eyeballs = allOf(parts.filter(isEyeball));
    if (eyes && eyeballs.length) {
      primitives.push(
        primitive(indicesOf(eyeballs), {
          name: 'eyes',
          pbrMetallicRoughness: { baseColorTexture: texture(eyes.colour, 'eyes'), metallicFactor: 0, roughnessFactor: 0.08 },
        }),
      );
    }
  } else {
    primitives = [primitive(indicesOf(triangles), { name: 'skin', pbrMetallicRoughness: matt })];
  }

  const { about } = face.model;
  const shown = face.expression;
  /** @param {import('./index.js').Part} part a mesh beside the face */
  function beside({ name, positions: points, normals: outward, colours: rgb, triangles: list, roughness, metalness = 0, opacity = 1, targets: moves }) {
    const many = points.length / 3;
    const shape = { componentType: FLOAT, count: many, type: 'VEC3' };
    const metres = points.map((x) => x * METRES);
    const named = Object.entries(targets ? moves : {});
    const each = Uint32Array.from({ length: many }, (_, v) => v);
    materials.push({
      name,
      doubleSided: true,
      pbrMetallicRoughness: { ...(opacity < 1 && { baseColorFactor: [1, 1, 1, opacity] }), metallicFactor: metalness, roughnessFactor: roughness },
      ...(opacity < 1 && { alphaMode: 'BLEND' }),
    });
    return {
      name,
      primitives: [
        {
          attributes: {
            POSITION: buffer.accessor({ bufferView: buffer.view(metres, ARRAY_BUFFER), ...shape, ...bounds(metres) }),
            NORMAL: buffer.accessor({ bufferView: buffer.view(unit(outward), ARRAY_BUFFER), ...shape }),
            COLOR_0: buffer.accessor({
              bufferView: buffer.view(colours16(rgb), ARRAY_BUFFER),
              componentType: UNSIGNED_SHORT,
              normalized: true,
              count: many,
              type: 'VEC4',
            }),
          },
          indices: indicesOf(list, many),
          material: materials.length - 1,
          ...(named.length && {
            targets: named.map(([, move]) => ({ POSITION: displacement(buffer, move, each, METRES, STILL) })),
          }),
        },
      ],
      ...(named.length && { weights: named.map(([target]) => shown[target] ?? 0), extras: { targetNames: named.map(([target]) => target) } }),
    };
  }
  const meshes = [
    {
      name: 'face',
      primitives,
      ...(targetAccessors.length && {
        weights: [...morphs.map(() => 0), ...expressions.map(({ name }) => shown[name] ?? 0)],
        extras: {
          targetNames: [...morphs, ...expressions].map(({ name }) => name),
          phiz: {
            weight: 'standard deviations',
            targets: morphs.map(({ name, group, direction }) => ({ name, group, direction })),
            expressions: expressions.map(({ name }) => name),
          },
        },
      }),
    },
    // An accessor of nothing is no glTF.
    ...(appearance?.parts ?? []).filter(({ positions: points, triangles: list }) => points.length > 0 && list.length > 0).map(beside),
  ];
  const json = {
    asset: {
      version: '2.0',
      generator: about.made_by,
      copyright: provenance(face.model).join('; '),
    },
    extras: { phiz: { model: about.title, code: face.code } },
    scene: 0,
    scenes: [{ nodes: meshes.map((_, i) => i) }],
    nodes: meshes.map(({ name }, mesh) => ({ name, mesh })),
    meshes,
    materials,
    ...(images.length && {
      images,
      textures,
      samplers: [{ magFilter: LINEAR, minFilter: LINEAR_MIPMAP_LINEAR, wrapS: CLAMP_TO_EDGE, wrapT: CLAMP_TO_EDGE }],
    }),
    accessors: buffer.accessors,
    bufferViews: buffer.views,
    buffers: [{ byteLength: buffer.length }],
  };
  const text = new TextEncoder().encode(JSON.stringify(json));
  const spaces = new Uint8Array(padded(text.length) - text.length).fill(0x20);
  const out = new ByteWriter(28 + padded(text.length) + buffer.length);
  out.u32(0x46546c67); // glTF
  out.u32(2);
  out.u32(28 + padded(text.length) + buffer.length);
  out.u32(padded(text.length));
  out.u32(0x4e4f534a); // JSON
  out.bytes(text);
  out.bytes(spaces);
  out.u32(buffer.length);
  out.u32(0x004e4942); // BIN
  for (const chunk of buffer.chunks) out.bytes(chunk);
  return out.finish();
}
