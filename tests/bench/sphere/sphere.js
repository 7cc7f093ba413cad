// What the page's first face is measured against: three.js and one sphere of the same skin, lit by
// one light, as bare as a page can be.
import { BufferAttribute, DataTexture, DirectionalLight, Mesh, PerspectiveCamera, Scene, SphereGeometry, WebGLRenderer } from 'three';
import { drawnByProcessor } from '../../../www/src/rendering/graphics.js';
import { poreRelief } from '../../../www/src/groundwork/pores.js';
import { createSkin } from '../../../www/src/head/skin.js';
import { createTile } from '../../../www/src/rendering/textures.js';

const renderer = new WebGLRenderer({ antialias: !drawnByProcessor() });
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);
const scene = new Scene();
const light = new DirectionalLight('white', 2);
light.position.set(-1, 1, 2);
scene.add(light);

const geometry = new SphereGeometry(100, 192, 128);
const { count } = geometry.attributes.position;
geometry.setAttribute('rest', geometry.attributes.position);
geometry.setAttribute('restNormal', geometry.attributes.normal);
for (const [name, size] of Object.entries({ shade: 3, mark: 2, heat: 3 })) {
  geometry.setAttribute(name, new BufferAttribute(new Float32Array(size * count).fill(name === 'shade' ? 1 : 0), size));
}
const nothing = new DataTexture(new Uint8Array(4), 1, 1);
nothing.needsUpdate = true;
const unpainted = { map: nothing, frame: [-100, -100, 200, 200] };
const skin = createSkin({ pores: createTile(poreRelief()), face: unpainted, brows: unpainted, depth: 0, landmarks: new Map() });
scene.add(new Mesh(geometry, skin.material));
const camera = new PerspectiveCamera(22, innerWidth / innerHeight, 50, 5000);
camera.position.z = 700;
requestAnimationFrame(() => renderer.render(scene, camera));
