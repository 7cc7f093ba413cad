// A head as a mesh of your own in three.js: your material, your lights, phiz's vertices.
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
  SRGBColorSpace,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

const canvas = /** @type {HTMLCanvasElement} */ (document.querySelector('canvas'));
const form = /** @type {HTMLFormElement} */ (document.querySelector('form'));
const status = /** @type {HTMLElement} */ (document.querySelector('[role=status]'));

const response = await fetch(new URL('../../model.phiz', document.baseURI));
const model = await load(response).catch((why) => {
  status.textContent = why.message;
  throw why;
});
const face = model.face();

const geometry = new BufferGeometry();
const position = new BufferAttribute(face.positions.slice(), 3);
const normal = new BufferAttribute(face.normals.slice(), 3);
const colour = new BufferAttribute(new Float32Array(3 * model.vertexCount), 3);
const one = new Color();
for (let v = 0; v < model.vertexCount; v++) {
  const [r, g, b] = model.colours.subarray(3 * v, 3 * v + 3);
  one.setRGB(r / 255, g / 255, b / 255, SRGBColorSpace);
  colour.setXYZ(v, one.r, one.g, one.b);
}
geometry.setAttribute('position', position);
geometry.setAttribute('normal', normal);
geometry.setAttribute('color', colour);
// Without a texture no vertex need be repeated on a seam: triangles of vertices, not of corners.
geometry.setIndex(new BufferAttribute(model.triangles.map((corner) => model.uvVertices[corner]), 1));

const renderer = new WebGLRenderer({ canvas, antialias: true });
const scene = new Scene();
scene.background = new Color('#dfe3e6');
scene.add(new Mesh(geometry, new MeshStandardMaterial({ vertexColors: true, roughness: 0.6 })));
scene.add(new HemisphereLight('#ffffff', '#b09a8a', 1.6));
const sun = new DirectionalLight('#fff4e5', 2.4);
sun.position.set(-200, 250, 400);
scene.add(sun);

// Millimetres: a head is some 250 high.
const camera = new PerspectiveCamera(24, 1, 10, 5000);
camera.position.set(0, 0, 850);
const orbit = new OrbitControls(camera, canvas);
orbit.addEventListener('change', draw);

let asked = false;
function draw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    renderer.render(scene, camera);
  });
}

/** Takes over what the last call has changed: a slider of the nose moves the nose and its surround. */
function update([first, end] = [0, model.vertexCount]) {
  // The views are on wasm memory and valid until the next call: copy, and only the part that changed.
  position.array.set(face.positions.subarray(3 * first, 3 * end), 3 * first);
  normal.array.set(face.normals.subarray(3 * first, 3 * end), 3 * first);
  for (const attribute of [position, normal]) {
    attribute.addUpdateRange(3 * first, 3 * (end - first));
    attribute.needsUpdate = true;
  }
  draw();
}

form.addEventListener('input', ({ target }) => {
  const slider = /** @type {HTMLInputElement} */ (target);
  face.set(slider.name, slider.valueAsNumber);
  const [first, end] = face.changed;
  update([first, end]);
  status.textContent = `${end - first} of ${model.vertexCount} vertices were updated`;
});
form.querySelector('button')?.addEventListener('click', () => {
  face.randomize();
  for (const slider of form.querySelectorAll('input')) slider.value = String(face.get(slider.name));
  update();
});
new ResizeObserver(() => {
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
  camera.aspect = canvas.clientWidth / canvas.clientHeight;
  camera.updateProjectionMatrix();
  draw();
}).observe(canvas);
document.documentElement.dataset.ready = 'true';
