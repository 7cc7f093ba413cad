import {
  BufferAttribute,
  CanvasTexture,
  Color,
  Matrix3,
  Matrix4,
  Mesh,
  MeshPhysicalMaterial,
  SphereGeometry,
  Vector3,
} from 'three';
import { chance } from '../chance.js';
import { sharpen } from '../rendering/textures.js';

// The model gives an eyeball's place and size; the drawn eye is a smoother one at that place: a
// sphere with a cornea, and an iris seen through it by refraction. All lengths below are in
// radii of the eyeball.
const IRIS = 0.485;
const IRIS_DEPTH = 0.8;
/** The cornea is a cap of a smaller sphere that meets the eyeball at the edge of the iris. */
const CORNEA = 0.66;
const CORNEA_CENTRE = Math.sqrt(1 - IRIS * IRIS) - Math.sqrt(CORNEA * CORNEA - IRIS * IRIS);

const CORNEA_HEIGHT = CORNEA_CENTRE + CORNEA - 1;

/** How far the surface is from the centre, by the cosine of the angle to the gaze. */
function surface(/** @type {number} */ cosine) {
  if (cosine * cosine < 1 - IRIS * IRIS || cosine < 0) return 1;
  const across = CORNEA_CENTRE * CORNEA_CENTRE * (1 - cosine * cosine);
  return CORNEA_CENTRE * cosine + Math.sqrt(CORNEA * CORNEA - across);
}

function createGlobe() {
  const geometry = new SphereGeometry(1, 72, 64);
  geometry.rotateX(Math.PI / 2);
  const position = geometry.getAttribute('position');
  const point = new Vector3();
  for (let i = 0; i < position.count; i++) {
    point.fromBufferAttribute(position, i).normalize();
    // More rings where the cornea is: the cosine moves towards the gaze.
    const flat = Math.hypot(point.x, point.y);
    const angle = Math.acos(point.z);
    const bent = Math.PI * (angle / Math.PI) ** 1.45;
    if (flat > 1e-6) point.set((point.x / flat) * Math.sin(bent), (point.y / flat) * Math.sin(bent), Math.cos(bent));
    point.multiplyScalar(surface(point.z));
    position.setXYZ(i, point.x, point.y, point.z);
  }
  geometry.computeVertexNormals();
  // The seam of the sphere: its two columns of vertices need one normal.
  const normal = /** @type {BufferAttribute} */ (geometry.getAttribute('normal'));
  for (let ring = 0; ring <= 64; ring++) {
    const [a, b] = [ring * 73, ring * 73 + 72];
    point.fromBufferAttribute(normal, a);
    point.x += normal.getX(b);
    point.y += normal.getY(b);
    point.z += normal.getZ(b);
    point.normalize();
    if (ring === 0) point.set(0, 0, 1);
    if (ring === 64) point.set(0, 0, -1);
    normal.setXYZ(a, point.x, point.y, point.z);
    normal.setXYZ(b, point.x, point.y, point.z);
  }
  for (let column = 0; column <= 72; column++) {
    normal.setXYZ(column, 0, 0, 1);
    normal.setXYZ(64 * 73 + column, 0, 0, -1);
  }
  return geometry;
}

/** What a texel of the iris's map says, times this, is what the iris's colour is multiplied by. */
const IRIS_RANGE = 4;

/**
 * An iris without its colour: two layers of fibres, the collarette, the dark ring of the limbus, the pupil.
 */
function paintIris() {
  const size = 512;
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = size;
  const draw = canvas.getContext('2d');
  if (!draw) throw new Error('this browser gives no 2D canvas');
  const random = chance(11);
  const r = size / 2;
  draw.translate(r, r);
  /** @param {number} factor */
  const grey = (factor) => {
    const level = Math.round((255 * factor) / IRIS_RANGE);
    return `rgb(${level}, ${level}, ${level})`;
  };
  const base = draw.createRadialGradient(0, 0, r * 0.2, 0, 0, r);
  base.addColorStop(0, grey(0.75));
  base.addColorStop(0.36, grey(1.05));
  base.addColorStop(0.5, grey(1.1));
  base.addColorStop(0.82, grey(0.72));
  base.addColorStop(1, grey(0.16));
  draw.fillStyle = base;
  draw.fillRect(-r, -r, size, size);
  for (let n = 0; n < 1500; n++) {
    const angle = random() * 2 * Math.PI;
    const inner = random() < 0.5;
    const from = (inner ? 0.3 + 0.05 * random() : 0.42 + 0.1 * random()) * r;
    const to = (inner ? 0.48 + 0.14 * random() : 0.8 + 0.16 * random()) * r;
    const bend = (random() - 0.5) * 0.1;
    const bright = random();
    draw.globalAlpha = 0.1 + 0.28 * random();
    draw.strokeStyle = bright > 0.5 ? grey(inner ? 3.2 : 3.9) : grey(0.12);
    draw.lineWidth = (1 + 2.6 * random()) / 2;
    draw.beginPath();
    draw.moveTo(Math.cos(angle) * from, Math.sin(angle) * from);
    draw.quadraticCurveTo(
      Math.cos(angle + bend) * (from + to) * 0.5,
      Math.sin(angle + bend) * (from + to) * 0.5,
      Math.cos(angle + bend * 0.4) * to,
      Math.sin(angle + bend * 0.4) * to,
    );
    draw.stroke();
  }
  draw.globalAlpha = 1;
  const limbus = draw.createRadialGradient(0, 0, r * 0.76, 0, 0, r);
  limbus.addColorStop(0, 'rgba(0,0,0,0)');
  limbus.addColorStop(0.6, 'rgba(0,0,0,0.55)');
  limbus.addColorStop(1, 'rgba(0,0,0,0.96)');
  draw.fillStyle = limbus;
  draw.fillRect(-r, -r, size, size);
  const pupil = draw.createRadialGradient(0, 0, r * 0.27, 0, 0, r * 0.34);
  pupil.addColorStop(0, 'rgba(0,0,0,1)');
  pupil.addColorStop(0.55, 'rgba(0,0,0,0.98)');
  pupil.addColorStop(1, 'rgba(0,0,0,0)');
  draw.fillStyle = pupil;
  draw.fillRect(-r, -r, size, size);
  const map = new CanvasTexture(canvas);
  sharpen(map, 8);
  return map;
}

/** The colours of an eyeball, by where on it: in its radii, across the gaze. */
export const EYE_GLSL = /* glsl */ `
  uniform sampler2D irisMap;
  uniform vec3 irisInner;
  uniform vec3 irisOuter;
  uniform vec3 scleraTint;
  uniform sampler2D poreMap;
  vec3 irisColour(vec2 at) {
    float inside = min(length(at), 1.0);
    vec3 iris = mix(irisInner, irisOuter, smoothstep(0.36, 0.58, inside));
    iris *= ${IRIS_RANGE.toFixed(1)} * texture2D(irisMap, at / max(1.0, length(at)) * 0.5 + 0.5).r;
    // The collarette and the fibres catch more light on the side away from the lamp.
    return iris * (1.25 + 0.35 * smoothstep(0.3, 0.9, inside));
  }
  float irisShare(vec2 eye) { return 1.0 - smoothstep(0.93, 1.09, length(eye) / ${IRIS.toFixed(3)}); }
  // Redder towards the corners.
  vec3 scleraColour(vec2 eye, float side) {
    vec4 veins = texture2D(poreMap, eye * vec2(0.9, 1.6));
    vec3 sclera = mix(vec3(0.72, 0.69, 0.66), vec3(0.70, 0.52, 0.47), 0.55 * side);
    return scleraTint * sclera * mix(vec3(1.0), vec3(0.98, 0.9, 0.88), veins.a * (0.5 + 0.5 * side));
  }
  // Without the cornea.
  vec3 eyeColour(vec2 eye, float side) {
    return mix(scleraColour(eye, side), irisColour(eye / ${IRIS.toFixed(3)}), irisShare(eye));
  }
`;

/** Where lids are, which stay when the eye turns. */
const LIDS = /* glsl */ `
  varying vec3 vInHead;
  uniform vec3 upperLid;
  uniform vec3 lowerLid;
  float lidAt(vec3 lid) { return lid.x + vInHead.x * (lid.y + vInHead.x * lid.z); }
`;

/** More than an eyeball came out of the skin beside the lids of any face that was tried, mm. */
const FURTHER = 8;

const PLACE = /* glsl */ `
  varying vec3 vEye;
  varying vec3 vEyeView;
  varying vec3 vEyeNormal;
  ${LIDS}
  uniform mat3 gaze;
  uniform vec2 meet;
  uniform float widest;
  uniform float behind;
`;

const DECLARATIONS = /* glsl */ `
  varying vec3 vEye;
  varying vec3 vEyeView;
  varying vec3 vEyeNormal;
  ${EYE_GLSL}
  ${LIDS}
  uniform vec2 corners;
  uniform mat3 normalMatrix;
  float irisPart;
  float lidShade;
  vec2 irisAt;
`;

const COLOUR = /* glsl */ `
  {
    vec3 into = normalize(vEyeView);
    vec3 bent = refract(into, normalize(vEyeNormal), 1.0 / 1.336);
    // Where the ray meets the plane of the iris.
    irisAt = (vEye + bent * ((vEye.z - ${IRIS_DEPTH.toFixed(3)}) / max(0.05, -bent.z))).xy / ${IRIS.toFixed(3)};
    irisPart = irisShare(vEye.xy) * step(0.0, vEye.z);
    float side = smoothstep(corners.x, corners.y, abs(vInHead.x));
    diffuseColor.rgb = mix(scleraColour(vEye.xy, side), irisColour(irisAt), irisPart);

    // The lids shade the eye: a soft band under the upper one, a thin one over the lower one.
    lidShade = smoothstep(-0.1, 0.42, lidAt(upperLid) - vInHead.y) * smoothstep(-0.12, 0.2, vInHead.y - lidAt(lowerLid));
    lidShade = mix(lidShade, lidShade * 0.55, side) * mix(0.72, 1.0, smoothstep(0.1, 0.75, lidAt(upperLid) - vInHead.y));
    diffuseColor.rgb *= mix(vec3(0.42, 0.28, 0.24), vec3(1.0), lidShade);
  }
`;

const NORMAL = /* glsl */ `
  {
    // The iris is a shallow bowl behind the cornea: it is lit against the highlight.
    vec3 bowl = normalize(vec3(-irisAt * 0.32, 1.0));
    normal = normalize(mix(normal, normalize(normalMatrix * bowl), irisPart));
  }
`;

/**
 * Fits a sphere to points by linear least squares.
 * @param {Float32Array} positions @param {ArrayLike<number>} vertices
 * @param {Vector3} centre is set
 * @returns {number} the radius
 */
export function fitSphere(positions, vertices, centre) {
  // |p|^2 = 2 c.p + (r^2 - |c|^2), solved about the mean so that the numbers stay small.
  const n = vertices.length;
  let [cx, cy, cz] = [0, 0, 0];
  for (let i = 0; i < n; i++) {
    const o = 3 * vertices[i];
    cx += positions[o];
    cy += positions[o + 1];
    cz += positions[o + 2];
  }
  [cx, cy, cz] = [cx / n, cy / n, cz / n];
  let [xx, xy, xz, yy, yz, zz, xs, ys, zs, s] = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
  for (let i = 0; i < n; i++) {
    const o = 3 * vertices[i];
    const x = positions[o] - cx;
    const y = positions[o + 1] - cy;
    const z = positions[o + 2] - cz;
    const square = x * x + y * y + z * z;
    xx += x * x;
    xy += x * y;
    xz += x * z;
    yy += y * y;
    yz += y * z;
    zz += z * z;
    xs += x * square;
    ys += y * square;
    zs += z * square;
    s += square;
  }
  // About the mean the coordinates sum to nothing.
  const a = [
    [4 * xx, 4 * xy, 4 * xz, 0, 2 * xs],
    [4 * xy, 4 * yy, 4 * yz, 0, 2 * ys],
    [4 * xz, 4 * yz, 4 * zz, 0, 2 * zs],
    [0, 0, 0, n, s],
  ];
  for (let j = 0; j < 4; j++) {
    let pivot = j;
    for (let k = j + 1; k < 4; k++) if (Math.abs(a[k][j]) > Math.abs(a[pivot][j])) pivot = k;
    [a[j], a[pivot]] = [a[pivot], a[j]];
    for (let k = 0; k < 4; k++) {
      if (k === j) continue;
      const factor = a[k][j] / a[j][j];
      for (let m = j; m < 5; m++) a[k][m] -= factor * a[j][m];
    }
  }
  const [x, y, z, w] = a.map((row, j) => row[4] / row[j]);
  centre.set(cx + x, cy + y, cz + z);
  return Math.sqrt(w + x * x + y * y + z * z);
}

/**
 * The parabola nearest to points: y = c0 + c1 x + c2 x^2.
 * @param {Vector3[]} points @param {Vector3} out
 */
function fitParabola(points, out) {
  const m = [0, 1, 2].map(() => new Float64Array(4));
  for (const p of points) {
    const row = [1, p.x, p.x * p.x, p.y];
    for (let j = 0; j < 3; j++) for (let k = 0; k < 4; k++) m[j][k] += row[j] * row[k];
  }
  for (let j = 0; j < 3; j++) {
    for (let k = 0; k < 3; k++) {
      if (k === j) continue;
      const factor = m[k][j] / m[j][j];
      for (let i = j; i < 4; i++) m[k][i] -= factor * m[j][i];
    }
  }
  out.set(m[0][3] / m[0][0], m[1][3] / m[1][1], m[2][3] / m[2][2]);
}

/**
 * @param {{ vertices: number[], landmark: (name: string, out: Vector3) => Vector3 | null }[]} sockets
 *   one a side, the subject's right first
 * @param {import('three').Texture} pores
 */
export function createEyes(sockets, pores) {
  const globe = createGlobe();
  const iris = paintIris();
  const [irisInner, irisOuter] = [{ value: new Color() }, { value: new Color() }];
  const scleraTint = { value: new Color() };
  const look = { irisMap: { value: iris }, irisInner, irisOuter, scleraTint, poreMap: { value: pores } };
  const names = [
    ['ibug_36', 'ibug_37', 'ibug_38', 'ibug_39', 'ibug_40', 'ibug_41'],
    ['ibug_42', 'ibug_43', 'ibug_44', 'ibug_45', 'ibug_46', 'ibug_47'],
  ];
  const eyes = sockets.map((socket, side) => {
    const uniforms = {
      ...look,
      upperLid: { value: new Vector3(0.5, 0, 0) },
      lowerLid: { value: new Vector3(-0.5, 0, 0) },
      corners: { value: [0.6, 1.05] },
      /** Where the lids meet. */
      meet: { value: [-1, 1] },
      /** How much further than it the white goes on to where they do, to which side. */
      widest: { value: 0 },
      gaze: { value: new Matrix3() },
      behind: { value: 0 },
    };
    const material = new MeshPhysicalMaterial({
      roughness: 0.6,
      specularIntensity: 0.3,
      clearcoat: 1,
      clearcoatRoughness: 0.04,
    });
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, uniforms);
      shader.vertexShader = shader.vertexShader
        .replace(
          '#include <common>',
          `#include <common>\n${PLACE}`,
        )
        .replace(
          '#include <beginnormal_vertex>',
          /* glsl */ `#include <beginnormal_vertex>
          // Where lids meet beyond the eyeball, its white goes on to them.
          vInHead = gaze * position;
          float wider = widest * smoothstep(0.75, 1.0, vInHead.x * sign(widest));
          vInHead.x += wider;
          vec3 aside = vec3(gaze[0].x, gaze[1].x, gaze[2].x);
          objectNormal -= dot(objectNormal, aside) * (1.0 - 1.0 / (1.0 + 5.0 * abs(wider))) * aside;`,
        )
        .replace(
          '#include <begin_vertex>',
          /* glsl */ `#include <begin_vertex>
          vEye = position;
          vEyeNormal = normal;
          transformed += wider * aside;
          vEyeView = position - (inverse(modelViewMatrix) * vec4(0.0, 0.0, 0.0, 1.0)).xyz;`,
        )
        .replace(
          '#include <project_vertex>',
          /* glsl */ `#include <project_vertex>
          {
            // The model's lids clear its eyeballs, which have no cornea. Skin around them does not on every face.
            vec2 beyond = vec2(max(meet.x - vInHead.x, vInHead.x - meet.y), max(lidAt(lowerLid) - vInHead.y, vInHead.y - lidAt(upperLid)));
            float further = ${FURTHER.toFixed(1)} * smoothstep(0.02, 0.2, max(beyond.x, beyond.y));
            vec4 back = projectionMatrix * (mvPosition - vec4(0.0, 0.0, behind + further, 0.0));
            gl_Position.z = back.z / back.w * gl_Position.w;
          }`,
        );
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <common>', `#include <common>\n${DECLARATIONS}`)
        .replace('#include <color_fragment>', `#include <color_fragment>\n${COLOUR}`)
        .replace('#include <normal_fragment_maps>', NORMAL)
        .replace(
          '#include <aomap_fragment>',
          /* glsl */ `
          reflectedLight.indirectDiffuse *= mix(0.35, 0.8, lidShade);
          // The studio's soft boxes in the eye are what makes it look alive.
          // A mirror this small on the screen would blur them away, so the key one is drawn.
          {
            vec3 mirrored = inverseTransformDirection(reflect(-geometryViewDir, geometryClearcoatNormal), viewMatrix);
            vec3 lamp = normalize(vec3(-4.6, 3.1, 7.2));
            vec3 right = normalize(cross(vec3(0.0, 1.0, 0.0), lamp));
            vec2 at = vec2(dot(mirrored, right), dot(mirrored, cross(lamp, right))) / max(0.05, dot(mirrored, lamp));
            vec2 soft = max(vec2(0.07), 0.8 * fwidth(at));
            vec2 box = smoothstep(vec2(0.17, 0.2) + soft, vec2(0.17, 0.2) - soft, abs(at));
            clearcoatSpecularIndirect += vec3(0.85, 0.82, 0.78) * box.x * box.y * step(0.05, dot(mirrored, lamp));
            clearcoatSpecularIndirect *= smoothstep(0.0, 0.35, lidShade);
          }
          clearcoatSpecularDirect *= 0.35 * smoothstep(0.1, 0.7, lidShade);`,
        );
    };
    const mesh = new Mesh(globe, material);
    mesh.receiveShadow = true;
    mesh.name = side === 0 ? 'right eye' : 'left eye';

    const point = new Vector3();
    /** @param {Float32Array} positions */
    function update(positions) {
      const radius = fitSphere(positions, socket.vertices, mesh.position);
      mesh.scale.setScalar(radius);
      const local = names[side].map((name) => {
        const found = socket.landmark(name, point);
        return found ? found.clone().sub(mesh.position).divideScalar(radius) : new Vector3();
      });
      fitParabola([local[0], local[1], local[2], local[3]], uniforms.upperLid.value);
      fitParabola([local[3], local[4], local[5], local[0]], uniforms.lowerLid.value);
      const [right, left] = [local[0].x, local[3].x];
      uniforms.meet.value = [right, left];
      uniforms.widest.value = side === 0 ? Math.min(0, 1.6 * (right + 0.94)) : Math.max(0, 1.6 * (left - 0.94));
      const half = (left - right) / 2;
      uniforms.corners.value = [half * 0.55, half * 1.05];
    }
    /** @param {Vector3} turn an axis times an angle @param {boolean} moved whether the lids may have */
    function turn(turn, moved) {
      const angle = turn.length();
      mesh.quaternion.setFromAxisAngle(angle > 0 ? turn.clone().divideScalar(angle) : turn, angle);
      uniforms.gaze.value.setFromMatrix4(new Matrix4().makeRotationFromQuaternion(mesh.quaternion));
      uniforms.behind.value = moved ? CORNEA_HEIGHT * mesh.scale.x : 0;
    }
    return { mesh, update, turn };
  });
  return {
    meshes: eyes.map((eye) => eye.mesh),
    centres: eyes.map((eye) => eye.mesh.position),
    /** Where they are and how large. */
    get balls() {
      return eyes.map(({ mesh }) => ({ centre: mesh.position, radius: mesh.scale.x }));
    },
    /** What it goes by beside the eyeballs. */
    landmarks: names.flat(),
    /** What `EYE_GLSL` goes by. */
    look,
    /** @param {Float32Array} positions */
    update(positions) {
      for (const eye of eyes) eye.update(positions);
    },
    /** @param {ReturnType<typeof import('./pigments.js').pigments>} colours */
    paint({ iris: { inner, outer }, bright }) {
      // There is some melanin in the white as well.
      scleraTint.value.setRGB(1 - 0.14 * (1 - bright), 1 - 0.22 * (1 - bright), 1 - 0.34 * (1 - bright));
      irisInner.value.copy(inner);
      irisOuter.value.copy(outer);
    },
    /**
     * @param {Vector3[]} turns of the subject's right and left eye, an axis times an angle
     * @param {boolean} moved whether the lids may be anywhere but at rest
     */
    turn(turns, moved) {
      eyes.forEach((eye, side) => eye.turn(turns[side], moved));
    },
  };
}
