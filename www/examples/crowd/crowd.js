// A hundred faces of one model. They share its memory and its topology; far away a face needs few
// triangles, and as all have the same, they are chosen once.
import { MeshoptSimplifier } from 'meshoptimizer';
import { load } from 'phiz';
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  HemisphereLight,
  Mesh,
  MeshStandardMaterial,
  PerspectiveCamera,
  Scene,
  Sphere,
  SRGBColorSpace,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

const ROWS = 10;
const COUNT = ROWS * ROWS;
/** How far apart people stand, mm. */
const APART = 270;
/** Triangles of the model that a face in the crowd has. */
const KEPT = 0.2;

const canvas = /** @type {HTMLCanvasElement} */ (document.querySelector('canvas'));
const form = /** @type {HTMLFormElement} */ (document.querySelector('form'));
const status = /** @type {HTMLElement} */ (document.querySelector('[role=status]'));
const select = /** @type {HTMLSelectElement} */ (document.querySelector('select'));
const slider = /** @type {HTMLInputElement} */ (document.querySelector('input'));

const response = await fetch(new URL('../../model.phiz', document.baseURI));
const model = await load(response).catch((why) => {
  status.textContent = why.message;
  throw why;
});
await MeshoptSimplifier.ready;

const median = model.face();
const rest = median.positions.slice();
median.free();
// What is inside the head is not seen from here.
const seen = model.parts.filter(({ name }) => name === 'skin' || name.includes('eyeball'));
const whole = seen.flatMap(({ first, count }) =>
  Array.from(model.triangles.subarray(3 * first, 3 * (first + count)), (corner) => model.uvVertices[corner]),
);
// Colours count too, or brows would run into the forehead.
const [triangles] = MeshoptSimplifier.simplifyWithAttributes(
  Uint32Array.from(whole),
  rest,
  3,
  Float32Array.from(model.colours, (byte) => byte / 255),
  3,
  [1, 1, 1],
  null,
  3 * Math.round((KEPT * whole.length) / 3),
  1,
  ['LockBorder'],
);
/** The vertices that are left, and the triangles of those. */
const kept = [...new Set(triangles)].sort((a, b) => a - b);
const place = new Map(kept.map((vertex, i) => [vertex, i]));
const index = new BufferAttribute(Uint16Array.from(triangles, (vertex) => place.get(vertex) ?? 0), 1);
const colour = new BufferAttribute(new Float32Array(3 * kept.length), 3);
const one = new Color();
kept.forEach((vertex, i) => {
  const [r, g, b] = model.colours.subarray(3 * vertex, 3 * vertex + 3);
  one.setRGB(r / 255, g / 255, b / 255, SRGBColorSpace);
  colour.setXYZ(i, one.r, one.g, one.b);
});

const renderer = new WebGLRenderer({ canvas, antialias: true });
const scene = new Scene();
scene.background = new Color('#dfe3e6');
scene.add(new HemisphereLight('#ffffff', '#b09a8a', 1.7));
const sun = new DirectionalLight('#fff4e5', 2.3);
sun.position.set(-300, 500, 600);
scene.add(sun);
const material = new MeshStandardMaterial({ vertexColors: true, roughness: 0.65 });
const bounds = new Sphere(new Vector3(), 200);

const people = Array.from({ length: COUNT }, (_, i) => {
  const geometry = new BufferGeometry();
  const position = new BufferAttribute(new Float32Array(3 * kept.length), 3);
  const normal = new BufferAttribute(new Float32Array(3 * kept.length), 3);
  geometry.setIndex(index);
  geometry.setAttribute('position', position);
  geometry.setAttribute('normal', normal);
  geometry.setAttribute('color', colour);
  geometry.boundingSphere = bounds;
  const mesh = new Mesh(geometry, material);
  const [column, row] = [i % ROWS, Math.floor(i / ROWS)];
  // Each row stands higher and farther back, as in a class photograph.
  mesh.position.set((column - (ROWS - 1) / 2 + (row % 2) / 2 - 0.25) * APART, (row - (ROWS - 1) / 2) * 250, -row * 120);
  scene.add(mesh);
  return { face: model.face(), position, normal };
});

/** @param {typeof people[number]} person */
function update({ face, position, normal }) {
  for (const [attribute, values] of /** @type {const} */ ([[position, face.positions], [normal, face.normals]])) {
    const { array } = attribute;
    for (let i = 0, to = 0; i < kept.length; i++) {
      const from = 3 * kept[i];
      array[to++] = values[from];
      array[to++] = values[from + 1];
      array[to++] = values[from + 2];
    }
    attribute.needsUpdate = true;
  }
}

const camera = new PerspectiveCamera(26, 1, 100, 20000);
const orbit = new OrbitControls(camera, canvas);
orbit.target.z = -ROWS * 60;
orbit.addEventListener('change', draw);
let asked = false;
/** Milliseconds of work for the last event: every face, every vertex. */
let work = 0;
function draw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    renderer.render(scene, camera);
  });
}
function report() {
  status.textContent = `${COUNT} faces of ${model.vertexCount} vertices in ${work.toFixed(1)} ms`;
  canvas.dataset.work = work.toFixed(2);
}

/** @param {(person: typeof people[number]['face'], i: number) => void} change */
function everyone(change) {
  const start = performance.now();
  people.forEach((person, i) => {
    change(person.face, i);
    update(person);
  });
  work = performance.now() - start;
  report();
  draw();
}

for (const { name } of model.controls) select.append(new Option(name));
select.value = 'nose 1';
/** Events may come faster than frames: the last one counts. */
let waiting = false;
slider.addEventListener('input', () => {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    everyone((face) => face.set(select.value, slider.valueAsNumber));
  });
});
let crowd = 0;
function meet() {
  crowd += 1;
  everyone((face, i) => void face.randomize({ seed: crowd * COUNT + i }));
}
form.querySelector('button')?.addEventListener('click', meet);
new ResizeObserver(() => {
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
  camera.aspect = canvas.clientWidth / canvas.clientHeight;
  const reach = Math.max(ROWS * 250, (ROWS * APART) / camera.aspect) / (2 * Math.tan((camera.fov * Math.PI) / 360));
  camera.position.set(0, 0, reach + 150);
  camera.updateProjectionMatrix();
  orbit.update();
  draw();
}).observe(canvas);
meet();
document.documentElement.dataset.ready = 'true';
