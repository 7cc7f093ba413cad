import { BufferAttribute, BufferGeometry, DoubleSide, Matrix4, Mesh, MeshPhysicalMaterial, ShaderChunk, Vector3 } from 'three';

// The model's mouth is an empty pouch. The page draws teeth, gums and a tongue in it: the upper row stands
// where the lips of the face at rest are, whatever they do; the lower one goes with the jaw.

/** Width and height of the crowns from the middle to the back, mm: usual adult ones. */
const UPPER = [[8.5, 10.5], [6.6, 9.2], [7.6, 10.2], [7, 8.4], [6.8, 8], [10, 7.4], [9.6, 7]];
const LOWER = [[5.3, 8.6], [5.8, 8.8], [6.6, 9.2], [7, 8.4], [7.1, 8], [10.6, 7.4], [10, 7]];
/** What the sizes above belong to: half the width between the corners of the lips' inner line, mm. */
const HALF_MOUTH = 22.3;
/** Half the arch's width and its length, mm: wider than usual, as the model's lips are a flatter arch. */
const ARCH = { upper: [29.5, 41], lower: [27, 38] };
const IVORY = [0.9, 0.725, 0.56];
const GUM = [0.5, 0.17, 0.16];
const TONGUE = [0.52, 0.2, 0.19];

// Lamps behind the head do not shine through it, and cast no shadows that would tell. Enamel lets light
// through: in the lips' shadow it is still lit from beside.
const LIGHTS = ShaderChunk.lights_fragment_begin
  .replace(
    'getDirectionalLightInfo( directionalLight, directLight );',
    /* glsl */ `$&
    directLight.color *= smoothstep(0.0, 0.4, dot(directLight.direction, (viewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).xyz));`,
  )
  .replaceAll('directionalLightShadow.shadowIntensity', '0.55 * directionalLightShadow.shadowIntensity');

/** Between lips that are no further apart than the first nothing is seen, mm, as of 19 in 20 faces at rest; past the second all is. */
export const OPEN = [1.9, 4.8];
/** When an expression parts lips by so much more than they are at rest, all is seen, mm: it parts them more beside their middles. */
const PARTED = 1.6;
/** And comes within so much, mm. */
const SOON = 0.3;

/** The corners and the middles of the lips' inner line; the chin from its right to its left. */
const NAMES = ['ibug_60', 'ibug_64', 'ibug_62', 'ibug_66', 'ibug_06', 'ibug_07', 'ibug_08', 'ibug_09', 'ibug_10'];
/** How far below their edges the lower gum may show under the skin, as sizes of teeth are. */
const UNDER_SKIN = [5, 17];
/** How far the lower gum stands back from the edges of its teeth, and how thick the skin before it is. */
const GUM_BACK = 2;
const THICK = 4;
/** More than any lower front teeth lean back; a gum that leans no more would still come out of few chins. */
const MOST_LEAN = 0.6;

/** Geometry that grows by grids of points, each with a colour. */
function createMould() {
  /** @type {number[]} */
  const positions = [];
  /** @type {number[]} */
  const colours = [];
  /** @type {number[]} */
  const triangles = [];
  /** @type {Map<string, number>} */
  const places = new Map();
  return {
    /**
     * Grids come round to where they began, and to points: what is in one place is one vertex.
     * @param {number} rows @param {number} columns
     * @param {(u: number, v: number) => { at: number[], colour: number[] }} point of u and v from 0 to 1
     */
    grid(rows, columns, point) {
      /** @type {number[]} */
      const vertices = [];
      for (let j = 0; j <= rows; j++) {
        for (let i = 0; i <= columns; i++) {
          const { at, colour } = point(i / columns, j / rows);
          const key = at.map((x) => Math.round(1e4 * x)).join();
          const vertex = places.get(key) ?? positions.length / 3;
          vertices.push(vertex);
          if (places.has(key)) continue;
          places.set(key, vertex);
          positions.push(...at);
          colours.push(...colour);
        }
      }
      for (let j = 0; j < rows; j++) {
        for (let i = 0; i < columns; i++) {
          const o = j * (columns + 1) + i;
          for (const corners of [[o, o + 1, o + columns + 2], [o, o + columns + 2, o + columns + 1]]) {
            const three = corners.map((corner) => vertices[corner]);
            if (new Set(three).size === 3) triangles.push(...three);
          }
        }
      }
    },
    cast() {
      const geometry = new BufferGeometry();
      geometry.setIndex(triangles);
      geometry.setAttribute('position', new BufferAttribute(Float32Array.from(positions), 3));
      geometry.setAttribute('color', new BufferAttribute(Float32Array.from(colours), 3));
      geometry.computeVertexNormals();
      return geometry;
    },
  };
}

/** @param {number} value @param {number} power */
const bulge = (value, power) => Math.sign(value) * Math.abs(value) ** power;
/** @param {number[]} colour @param {number} factor */
const shaded = (colour, factor) => colour.map((c) => c * factor);

/**
 * One row with its gum, around the origin: the middle of the front teeth's edges. `up` is 1 for teeth whose
 * roots are above.
 * @param {ReturnType<typeof createMould>} mould
 * @param {number[][]} sizes @param {number[]} arch @param {1 | -1} up
 */
function row(mould, sizes, [half, long], up) {
  // The arch is half an ellipse; teeth stand on it by their widths.
  const onArch = (/** @type {number} */ turn) => [half * Math.sin(turn), long * (Math.cos(turn) - 1)];
  /** The light that comes in between the lips. @param {number} turn */
  const light = (turn) => 1 - 0.9 * Math.min(1, Math.max(0, (turn - 0.2) / 0.95));
  for (const side of [-1, 1]) {
    let turn = 0;
    for (const [index, [width, height]] of sizes.entries()) {
      let end = turn;
      let [x, z] = onArch(turn);
      for (let gone = 0; gone < width; ) {
        end += 0.004;
        const [nx, nz] = onArch(end);
        gone += Math.hypot(nx - x, nz - z);
        [x, z] = [nx, nz];
      }
      const [cx, cz] = onArch((turn + end) / 2);
      const [ax, az] = onArch(turn);
      const along = [x - ax, z - az].map((d) => d / Math.hypot(x - ax, z - az));
      // Out of the mouth, across the arch.
      const out = [-along[1], along[0]];
      const grinder = index > 2;
      const thick = grinder ? 9 : 6.4;
      // Edges do not stand in one line: the second is short, the third pointed.
      const edge = [0, 0.6, 0.1, 0.4, 0.6, 0.9, 1.3][index];
      mould.grid(10, 14, (u, v) => {
        // A ball whose middle is flattened, cut to the tooth's outline.
        const round = 2 * Math.PI * u;
        const pole = Math.PI * v;
        const ring = bulge(Math.sin(pole), 0.34);
        const across = bulge(Math.cos(round), 0.48) * ring;
        const deep = bulge(Math.sin(round), grinder ? 0.5 : 0.75) * ring;
        // 0 at the biting edge, 1 at the root.
        const high = (1 - bulge(Math.cos(pole), 0.55)) / 2;
        const narrow = 1 - 0.2 * high * high;
        const thin = grinder ? 1 : 0.36 + 0.64 * high ** 0.8;
        const point = index === 2 ? -0.7 * (1 - Math.abs(across)) * (1 - high) : 0;
        const s = across * narrow * (width / 2) * 0.985;
        // The front face stays in place where the tooth is thin.
        const t = ((deep - 1) / 2) * thick * thin - 0.5 * (1 - high) ** 2 - 0.9 * high * high;
        const y = up * (edge + point + high * (height + 1.5));
        const colour = shaded(IVORY, light(turn) * (0.94 + 0.06 * Math.min(1, 4 * high)));
        return { at: [side * (cx + along[0] * s + out[0] * t), y, cz + along[1] * s + out[1] * t], colour };
      });
      turn = end;
    }
    const last = turn;
    // The gum rises and falls with the crowns and covers their roots.
    mould.grid(8, 42, (u, v) => {
      const here = u * last;
      const [x, z] = onArch(here);
      const normal = [Math.sin(here) * long, Math.cos(here) * half];
      const size = Math.hypot(normal[0], normal[1]);
      const scallop = 0.9 * Math.abs(Math.sin((here / last) * Math.PI * sizes.length));
      const roll = Math.PI * (v - 0.5);
      // The chin goes back sooner than what is below the nose, and a lower lip shows less of its gum.
      const tall = up > 0 ? 5 : 3.4;
      const y = up * (sizes[0][1] - 3.6 * u + scallop + tall * (0.9 + Math.sin(roll) * (1 - 0.25 * Math.cos(roll))));
      const t = -1.9 + 1.6 * Math.cos(roll) - 3.5 * v;
      return {
        at: [side * (x + (normal[0] / size) * t), y, z + (normal[1] / size) * t],
        colour: shaded(GUM, light(here) * (1 - 0.5 * v)),
      };
    });
  }
}

/** The tongue, at rest behind the lower teeth. @param {ReturnType<typeof createMould>} mould */
function tongue(mould) {
  mould.grid(16, 24, (u, v) => {
    const round = 2 * Math.PI * u;
    const pole = (Math.PI / 2) * v;
    const x = 17.5 * Math.sin(pole) * bulge(Math.cos(round), 0.8);
    const z = -26 + 19 * Math.sin(pole) * bulge(Math.sin(round), 0.8);
    const groove = 1.6 * Math.exp(-((x / 3.2) ** 2));
    const y = -9 + 7.5 * Math.cos(pole) ** 0.7 - groove * Math.cos(pole) - 0.004 * (z + 26) ** 2;
    return { at: [x, y, z], colour: shaded(TONGUE, 0.75 * Math.min(1, Math.max(0.12, 1 + (z + 10) / 38))) };
  });
}

/**
 * How a chin lies: its middle and the axes through it.
 * @param {Vector3[]} chin from its right to its left
 * @param {Matrix4} out
 */
function lie([far, near, tip, close, away], out) {
  const x = away.clone().add(close).sub(near).sub(far).normalize();
  const ahead = near.clone().add(tip).add(close).divideScalar(3).sub(far.clone().add(away).divideScalar(2));
  const y = ahead.cross(x).normalize();
  out.makeBasis(x, y, x.clone().cross(y));
  return out.setPosition(far.clone().add(near).add(tip).add(close).add(away).divideScalar(5));
}

/**
 * @param {Float32Array} rest positions of the head at rest, mm
 * @param {import('../groundwork/paint.js').Points} landmarks of it
 * @param {number[]} pouch the mouth cavity's vertices
 * @param {(landmark: string) => number} vertexOf the vertex at a landmark
 * @returns {{
 *   meshes: Mesh[],
 *   anchors: number[],
 *   update: (positions: ArrayLike<number>, shifts: ArrayLike<number>) => void,
 *   at: (positions: ArrayLike<number>, shifts: ArrayLike<number>) => Matrix4[],
 * } | null} null for a model without a mouth to open. `anchors` are the vertices that say where the rows
 *   are; `update` takes what an expression adds to them, 3 each, mm; `at` tells where the rows would be
 */
export function createTeeth(rest, landmarks, pouch, vertexOf) {
  const [corner, other, above, below, ...chin] = NAMES.map((name) => landmarks.get(name));
  if (!corner || !other || !above || !below || !chin.every(Boolean) || pouch.length === 0) return null;
  const scale = Math.abs(other[0] - corner[0]) / 2 / HALF_MOUTH;
  const middle = (other[0] + corner[0]) / 2;
  // The skin between the lower lip and the chin, in the middle, where it lies deepest; on other faces some of it is
  // nearer the lip.
  const inside = new Set(pouch);
  const dent = Array.from({ length: rest.length / 3 }, (_, v) => v).filter((v) => {
    const [x, y, z] = rest.subarray(3 * v, 3 * v + 3);
    const down = (below[1] - y) / scale;
    return !inside.has(v) && Math.abs(x - middle) < 2 * scale && down > UNDER_SKIN[0] && down < 2 * UNDER_SKIN[1] && z > below[2] - 25 * scale;
  });
  const anchors = [...NAMES.map(vertexOf), ...dent];

  const rows = /** @type {const} */ ([
    [1, UPPER, ARCH.upper],
    [-1, LOWER, ARCH.lower],
  ]).map(([up, sizes, arch]) => {
    const mould = createMould();
    row(mould, sizes, arch, up);
    if (up < 0) tongue(mould);
    const material = new MeshPhysicalMaterial({
      vertexColors: true,
      // The left half is the right one mirrored, and so are its triangles.
      side: DoubleSide,
      roughness: 0.36,
    });
    material.onBeforeCompile = (shader) => {
      shader.fragmentShader = shader.fragmentShader.replace('#include <lights_fragment_begin>', LIGHTS);
    };
    const mesh = new Mesh(mould.cast(), material);
    mesh.receiveShadow = true;
    mesh.matrixAutoUpdate = false;
    mesh.frustumCulled = false;
    // What is clicked is the mouth behind them.
    mesh.raycast = () => {};
    mesh.name = up > 0 ? 'upper teeth' : 'lower teeth';
    return { mesh, material };
  });
  const [upper, lower] = rows;
  const points = anchors.map(() => new Vector3());
  const still = anchors.map(() => new Vector3());
  const jaw = new Matrix4();
  const now = new Matrix4();

  /**
   * Where both rows are in a face.
   * @param {ArrayLike<number>} positions @param {ArrayLike<number>} shifts
   * @param {Matrix4} above is set @param {Matrix4} below is set
   * @returns how far the lips are apart, and how far they are at rest, as the sizes of teeth are
   */
  function place(positions, shifts, above, below) {
    anchors.forEach((v, i) => {
      points[i].fromArray(positions, 3 * v);
      still[i].set(points[i].x - shifts[3 * i], points[i].y - shifts[3 * i + 1], points[i].z - shifts[3 * i + 2]);
    });
    // The face that makes the expression has its teeth behind its lips.
    const [right, left, top, bottom] = still;
    const size = (left.x - right.x) / 2 / HALF_MOUTH;
    const [x, y] = [(left.x + right.x) / 2, (top.y + bottom.y) / 2];
    const before = Math.min(top.z, bottom.z) - 2.6 * size;
    const beneath = before - 2.2 * size;
    // The upper edges show a little below the line between the lips; the lower ones stand behind them.
    above.makeScale(size, size, size).setPosition(x, y - 2.6 * size, before);
    below.makeScale(size, size, size).setPosition(x, y - 1.3 * size, beneath);
    // Where the skin below the lip lies deep, teeth lean back.
    let lean = 0;
    for (const skin of still.slice(NAMES.length)) {
      const down = (y - skin.y) / size - 1.3;
      if (down < UNDER_SKIN[0] || down > UNDER_SKIN[1]) continue;
      lean = Math.max(lean, ((beneath - skin.z) / size + THICK - GUM_BACK) / down);
    }
    below.elements[6] = Math.min(MOST_LEAN, lean) * size;
    jaw.multiplyMatrices(lie(points.slice(4, NAMES.length), now), lie(still.slice(4, NAMES.length), jaw).invert());
    below.premultiply(jaw);
    return { gap: points[2].distanceTo(points[3]) / size, atRest: top.distanceTo(bottom) / size };
  }

  return {
    meshes: rows.map(({ mesh }) => mesh),
    anchors,
    update(positions, shifts) {
      const { gap, atRest } = place(positions, shifts, upper.mesh.matrix, lower.mesh.matrix);
      const open = Math.max(0, gap - OPEN[0]);
      const light = Math.min(1, Math.max(open / (OPEN[1] - OPEN[0]), Math.min(1, open / SOON) * ((gap - atRest) / PARTED)));
      for (const { mesh, material } of rows) {
        // What light is left between lips has been on their red, and less of it comes down to the lower row.
        const left = mesh === lower.mesh ? light * (0.7 + 0.3 * light) : light;
        const warm = Math.min(1, 2 * left);
        material.color.setRGB(left, left * (0.5 + 0.5 * warm), left * (0.35 + 0.65 * warm));
        material.specularIntensity = 0.45 * light;
        mesh.visible = light > 0;
        mesh.matrixWorldNeedsUpdate = true;
      }
    },
    at(positions, shifts) {
      const there = [new Matrix4(), new Matrix4()];
      place(positions, shifts, there[0], there[1]);
      return there;
    },
  };
}
