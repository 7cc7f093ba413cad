import {
  ACESFilmicToneMapping,
  Color,
  DirectionalLight,
  PCFShadowMap,
  PerspectiveCamera,
  Scene,
  Spherical,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { createAveraging } from '../rendering/averaging.js';
import { backdropUniforms, createBackdrop, paintBackdrop } from '../rendering/backdrop.js';
import { createEnvironment } from '../rendering/environment.js';
import { Failure } from '../frame/failure.js';
import { drawnByProcessor } from '../rendering/graphics.js';
import { text } from '../text.js';

const DEGREE = Math.PI / 180;

/** A picture rests when nothing was drawn for so long, ms. */
const RESTS = 150;

/** Azimuth and polar angle of each view, in radians. */
const VIEWS = {
  front: { theta: 0, phi: 88 * DEGREE },
  quarter: { theta: 38 * DEGREE, phi: 87 * DEGREE },
  profile: { theta: 90 * DEGREE, phi: 88 * DEGREE },
};

/** @typedef {keyof typeof VIEWS} View */
/**
 * The heights between which something is seen that far from a point, as they would be at that point's depth; mm.
 * @typedef {(centre: Vector3, distance: number) => readonly [low: number, high: number]} Reach
 */
/**
 * How far to the left and to the right of an axis something is seen from that far from it, mm.
 * @typedef {(axis: { x: number, axis: number }, theta: number, distance: number) => readonly [left: number, right: number]} Breadth
 */

/** Three-point light: a warm key with a soft shadow, a cool fill, a rim from behind. */
function createLights() {
  const key = new DirectionalLight(new Color(1, 0.955, 0.9), 2.35);
  key.position.set(-330, 360, 520);
  key.castShadow = true;
  // A processor would spend a fifth of a frame on the larger one. Edges are as soft in both.
  const sharp = drawnByProcessor() ? 1 : 2;
  key.shadow.mapSize.set(1024 * sharp, 1024 * sharp);
  key.shadow.radius = 1.6 * sharp;
  key.shadow.bias = -0.0006;
  key.shadow.normalBias = 0.9;
  const box = key.shadow.camera;
  box.left = box.bottom = -175;
  box.right = box.top = 175;
  box.near = 250;
  box.far = 1150;
  const fill = new DirectionalLight(new Color(0.9, 0.95, 1), 0.6);
  fill.position.set(480, 60, 320);
  const rim = new DirectionalLight(new Color(1, 0.97, 0.94), 1.5);
  rim.position.set(380, 260, -480);
  const hairLight = new DirectionalLight(new Color(0.9, 0.95, 1), 0.9);
  hairLight.position.set(-420, 180, -380);
  return [key, fill, rim, hairLight];
}

/**
 * Renderer, camera, lights; draws only when something asks for it.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {{ centre: Vector3, height: number, depth: number, axis: number }} subject what to look at, mm: the middle of a face, and the
 *   axis that it turns around
 * @param {(height: number) => readonly [top: number, bottom: number]} [covered] how much of a canvas of some height has
 *   other things over it, CSS pixels
 */
export function createScene(canvas, subject, covered = () => [0, 0]) {
  const context = canvas.getContext('webgl2', { antialias: !drawnByProcessor(), powerPreference: 'high-performance' });
  if (!context) throw new Failure(text.noWebGL);
  const renderer = new WebGLRenderer({ canvas, context });
  renderer.toneMapping = ACESFilmicToneMapping;
  renderer.toneMappingExposure = 0.88;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;
  // The head casts the only shadow: the map is drawn again when the head changes, not when the
  // camera moves.
  renderer.shadowMap.autoUpdate = false;

  const scene = new Scene();
  scene.environmentIntensity = 0.62;
  scene.add(createBackdrop());
  for (const light of createLights()) {
    light.position.add(subject.centre);
    light.target.position.copy(subject.centre);
    scene.add(light, light.target);
  }

  const camera = new PerspectiveCamera(22, 1, 20, 5000);
  const controls = new OrbitControls(camera, canvas);
  const still = window.matchMedia('(prefers-reduced-motion: reduce)');
  const damp = () => (controls.enableDamping = !still.matches);
  damp();
  still.addEventListener('change', damp);
  controls.dampingFactor = 0.09;
  controls.rotateSpeed = 0.75;
  controls.zoomSpeed = 0.8;
  controls.minPolarAngle = 10 * DEGREE;
  controls.maxPolarAngle = 135 * DEGREE;
  controls.zoomToCursor = true;
  // The head cannot be lost.
  controls.maxTargetRadius = 0.4 * subject.height;

  /** @type {Set<() => void>} */
  const beforeFrame = new Set();
  /** The frame that was asked for. */
  let scheduled = 0;
  let drawing = false;
  /** Covered by something else: nothing is drawn until that is gone. */
  let asleep = false;
  let frames = 0;
  const averaging = createAveraging(renderer);
  // What a card that is back is told to forget must be its own: all else is forgotten while it is gone.
  canvas.addEventListener('webglcontextlost', averaging.dispose);
  /** Once the page has nothing more urgent to do. */
  let refines = false;
  /** Until a picture that rests is as fine as it gets. */
  let resting = 0;
  let fine = true;
  /** @type {null | { from: Spherical, to: Spherical, way: Vector3, start: number }} */
  let flight = null;
  /** The one that was chosen last. @type {View} */
  let chosen = 'front';
  /** @type {null | { at: number, pose: (side: 'left' | 'right') => void }} */
  let wipe = null;
  /** What is drawn over the head. @type {null | ((renderer: WebGLRenderer, camera: PerspectiveCamera) => void)} */
  let over = null;

  function invalidate() {
    if (scheduled || asleep) return;
    scheduled = requestAnimationFrame(draw);
  }

  /** @param {NonNullable<typeof flight>} flight @param {number} part of it that is done, 0 to 1 */
  function fly({ from, to, way }, part) {
    const at = new Spherical(
      from.radius + (to.radius - from.radius) * part,
      from.phi + (to.phi - from.phi) * part,
      from.theta + (to.theta - from.theta) * part,
    );
    controls.target.copy(controls.cursor).addScaledVector(way, part - 1);
    camera.position.setFromSpherical(at).add(controls.target);
  }
  function aim() {
    drawing = true;
    controls.update();
    drawing = false;
  }

  /** @param {number} now */
  function draw(now) {
    // Who draws at once does it for whoever asked for a frame.
    cancelAnimationFrame(scheduled);
    scheduled = 0;
    if (flight) {
      const t = still.matches ? 1 : Math.min(1, Math.max(0, (now - flight.start) / 450));
      fly(flight, 1 - (1 - t) ** 3);
      if (t === 1) flight = null;
      else invalidate();
    }
    aim();
    for (const step of beforeFrame) step();
    render(canvas.clientWidth, canvas.clientHeight);
    frames += 1;
    rest();
  }

  /** What was just drawn is refined, unless something else is drawn soon. */
  function rest() {
    clearTimeout(resting);
    resting = 0;
    // Who asks for so few pixels does not look at edges. A page that is zoomed out has as many as the screen.
    fine = !refines || renderer.getPixelRatio() < 0.5;
    if (fine || scheduled) return;
    averaging.begin();
    resting = window.setTimeout(refine, RESTS);
  }

  function refine() {
    const round = resting;
    requestAnimationFrame(() => {
      if (round !== resting || scheduled) return;
      // Scenes on one page share what a wall is.
      for (const step of beforeFrame) step();
      fine = asleep || averaging.add(() => render(canvas.clientWidth, canvas.clientHeight), camera);
      frames += 1;
      if (!fine) refine();
    });
  }

  /** What is on the stage, into a picture of so many pixels by the renderer's ratio. @param {number} width @param {number} height */
  function render(width, height) {
    if (wipe) drawWiped(wipe, width, height);
    else renderer.render(scene, camera);
    over?.(renderer, camera);
  }

  /**
   * Two heads in one picture, each on its side of a line.
   * @param {NonNullable<typeof wipe>} sides @param {number} width @param {number} height
   */
  function drawWiped({ at, pose }, width, height) {
    // Pictures show what the stage does at its height, and more or less of it to the sides: the line is where it is in the view.
    const [wide, high] = size;
    const line = Math.min(width, Math.max(0, Math.round(width / 2 + ((at - 0.5) * wide * height) / high)));
    renderer.setScissorTest(true);
    for (const side of /** @type {const} */ (['left', 'right'])) {
      pose(side);
      renderer.shadowMap.needsUpdate = true;
      if (side === 'left') renderer.setScissor(0, 0, line, height);
      else renderer.setScissor(line, 0, width - line, height);
      renderer.render(scene, camera);
    }
    renderer.setScissorTest(false);
  }

  const portraitCamera = new PerspectiveCamera(22, 1, 50, 5000);
  /**
   * Small pictures from the front, drawn in a corner of the canvas and copied from there. The
   * caller poses the head each time, sets it back, and the stage is drawn again at once.
   * @param {{ pose: () => void, into: HTMLCanvasElement }[]} sitters all of one size
   * @returns {boolean} false when the graphics card is lost, or went on the way
   */
  function portraits(sitters) {
    if (sitters.length === 0 || renderer.getContext().isContextLost()) return false;
    const { width, height } = sitters[0].into;
    const ratio = renderer.getPixelRatio();
    const stageSize = backdropUniforms.backdropSize.value.clone();
    backdropUniforms.backdropSize.value.set(width, height);
    portraitCamera.aspect = width / height;
    portraitCamera.updateProjectionMatrix();
    const reach = (0.84 * subject.height) / (2 * Math.tan((portraitCamera.fov * DEGREE) / 2));
    portraitCamera.position.setFromSphericalCoords(reach, VIEWS.quarter.phi, 12 * DEGREE).add(subject.centre);
    portraitCamera.lookAt(subject.centre);
    renderer.setViewport(0, 0, width / ratio, height / ratio);
    renderer.setScissor(0, 0, width / ratio, height / ratio);
    renderer.setScissorTest(true);
    for (const { pose, into } of sitters) {
      pose();
      renderer.shadowMap.needsUpdate = true;
      renderer.render(scene, portraitCamera);
      into.getContext('2d')?.drawImage(canvas, 0, canvas.height - height, width, height, 0, 0, width, height);
    }
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, canvas.clientWidth, canvas.clientHeight);
    backdropUniforms.backdropSize.value.copy(stageSize);
    return !renderer.getContext().isContextLost();
  }

  // While they are damped, each frame moves the camera a little further.
  controls.addEventListener('change', () => {
    if (!drawing || controls.enableDamping) invalidate();
  });
  controls.addEventListener('start', () => (flight = null));

  /** Brings what the head mirrors. @param {ReturnType<typeof import('../groundwork/studio.js').studio>} studio */
  function light(studio) {
    scene.environment = createEnvironment(studio);
    renderer.shadowMap.needsUpdate = true;
    invalidate();
  }

  /** Width, height and pixel ratio; none while the canvas is not laid out. @type {number[]} */
  let size = [];

  /** @type {Reach} */
  let reach = () => [Infinity, -Infinity];
  /** @type {Breadth} */
  let breadth = () => [0, 0];

  /**
   * The distance from the head's axis at which head and hair fill what is free of the stage, and the height on it and how far to the right
   * of it to look at, mm.
   */
  function framed() {
    const [, height = 0] = size;
    const [top, bottom] = covered(height);
    // What lies over the stage leaves a margin of its own.
    const share = top + bottom > 0 ? 0.95 : 1;
    const tall = top + bottom > 0 ? (share * height) / Math.max(1, height - top - bottom) : 1;
    const { y } = subject.centre;
    const { theta, phi } = VIEWS[chosen];
    const head = Math.max(0.74 * subject.height, 1.1 * subject.depth * Math.sin(theta)) / camera.aspect;
    const away = (/** @type {number} */ seen) => seen / (2 * Math.tan((camera.fov * DEGREE) / 2));
    const from = away(Math.max(tall * subject.height, head));
    const [low, high] = reach(subject.centre, from);
    const [left, right] = breadth({ x: subject.centre.x, axis: subject.axis }, theta, from).map((side) => Math.max((head * camera.aspect) / 2, 1.02 * side));
    // Single hairs may be in the margin.
    const [half, slack] = [0.5 * share * subject.height, 0.012 * subject.height];
    const [least, most] = [Math.min(low + slack, y - half), Math.max(high - slack, y + half)];
    const seen = Math.max((tall * (most - least)) / share, (left + right) / camera.aspect);
    // The face is in the middle, but where there is no room for hair on one side of it.
    const room = (seen * camera.aspect) / 2;
    const aside = Math.max(0, right - room) - Math.max(0, left - room);
    // What is to fill the stage is the face, which is nearer than the axis from the front, and not from the side.
    const behind = (subject.centre.z - subject.axis) * Math.cos(theta);
    const middle = (least + most) / 2 - (seen * (bottom - top)) / (2 * Math.max(1, height));
    return { distance: away(seen) + behind, middle: middle - behind / Math.tan(phi), aside };
  }

  let fitted = 0;
  let beside = 0;
  function fit() {
    const { distance, middle, aside } = framed();
    const { theta } = VIEWS[chosen];
    controls.cursor.set(subject.centre.x + aside * Math.cos(theta), middle, subject.axis - aside * Math.sin(theta));
    controls.minDistance = distance * 0.28;
    controls.maxDistance = distance * 1.7;
    fitted = distance;
    beside = aside;
    return distance;
  }

  /** @param {View} name */
  function view(name) {
    if (!Object.hasOwn(VIEWS, name)) throw new Error(`there is no view "${name}": take ${Object.keys(VIEWS).join(', ')}`);
    chosen = name;
    const to = new Spherical(fit(), VIEWS[name].phi, VIEWS[name].theta);
    const from = new Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    // The short way round.
    while (from.theta - to.theta > Math.PI) from.theta -= 2 * Math.PI;
    while (to.theta - from.theta > Math.PI) from.theta += 2 * Math.PI;
    flight = { from, to, way: controls.cursor.clone().sub(controls.target), start: performance.now() };
    invalidate();
  }

  /** Hair has grown, or is gone: the view that was chosen is on all of it, unless somebody went elsewhere from there. */
  function reframe() {
    const { phi, theta } = VIEWS[chosen];
    if (!flight && new Vector3().setFromSphericalCoords(fitted, phi, theta).add(controls.cursor).distanceTo(camera.position) >= 1) return;
    const { distance, middle, aside } = framed();
    // Less is not worth a move.
    if (Math.abs(distance - fitted) + Math.abs(middle - controls.cursor.y) + Math.abs(aside - beside) > 0.01 * fitted) view(chosen);
  }

  /** A view that was asked for is there at once, for who takes a picture of it. */
  function arrive() {
    if (!flight) return;
    fly(flight, 1);
    flight = null;
    aim();
    invalidate();
  }

  /** Where the view is now: what is given back brings it there again. */
  function keep() {
    const [position, target, then] = [camera.position.clone(), controls.target.clone(), flight];
    return () => {
      camera.position.copy(position);
      controls.target.copy(target);
      flight = then;
      aim();
      invalidate();
    };
  }

  /**
   * Turns the head by hand: angles in radians, and a factor of the distance.
   * @param {number} theta @param {number} phi @param {number} [closer]
   */
  function turn(theta, phi, closer = 1) {
    flight = null;
    const at = new Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    at.theta += theta;
    at.phi = Math.min(controls.maxPolarAngle, Math.max(controls.minPolarAngle, at.phi + phi));
    at.radius *= closer;
    camera.position.setFromSpherical(at).add(controls.target);
    invalidate();
  }

  function resize() {
    const { clientWidth, clientHeight } = canvas;
    if (!clientWidth || !clientHeight) return;
    const now = [clientWidth, clientHeight, Math.min(window.devicePixelRatio, 2)];
    if (now.every((value, i) => value === size[i])) return;
    size = now;
    const before = fitted;
    const arm = camera.position.clone().sub(controls.target);
    controls.target.sub(controls.cursor);
    renderer.setPixelRatio(now[2]);
    renderer.setSize(clientWidth, clientHeight, false);
    renderer.getDrawingBufferSize(backdropUniforms.backdropSize.value);
    camera.aspect = clientWidth / clientHeight;
    camera.updateProjectionMatrix();
    const scale = fit() / before;
    controls.target.add(controls.cursor);
    camera.position.copy(controls.target).add(arm.multiplyScalar(scale));
    for (const end of flight ? [flight.from, flight.to] : []) end.radius *= scale;
    // A canvas that gets another size is blank, and this frame is shown before the next one is drawn.
    if (asleep || frames === 0) invalidate();
    else draw(performance.now());
  }

  // As if the canvas was a square, until it has a size: it may be hidden.
  const home = VIEWS.front;
  camera.position.setFromSphericalCoords(fit(), home.phi, home.theta).add(controls.target.copy(controls.cursor));
  const observer = new ResizeObserver(resize);
  observer.observe(canvas);
  /** @type {MediaQueryList} */
  let density;
  /** A window that goes to another display has the same size there, but may have other pixels. */
  function fitDensity() {
    resize();
    density = window.matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`);
    density.addEventListener('change', fitDensity, { once: true });
  }
  fitDensity();

  return {
    light,
    renderer,
    scene,
    camera,
    controls,
    beforeFrame,
    invalidate,
    view,
    reframe,
    arrive,
    keep,
    turn,
    /** Moves the head across the picture. @param {number} right @param {number} down CSS pixels */
    pan(right, down) {
      flight = null;
      controls.pan(right, down);
    },
    /** What is to be in view beside the head. @param {Reach} of */
    contain(of) {
      reach = of;
    },
    /** The same for the other way. @param {Breadth} of */
    widen(of) {
      breadth = of;
    },
    portraits,
    render,
    /** Draws at once: what the canvas holds is no longer the stage. */
    redraw() {
      renderer.shadowMap.needsUpdate = true;
      draw(performance.now());
    },
    /**
     * Splits the picture; null joins it again.
     * @param {typeof wipe} sides `at` is the line's place, a fraction of the stage's width
     */
    split(sides) {
      wipe = sides;
      invalidate();
    },
    /** Draws something over the head, whenever that is drawn; null ends it. @param {typeof over} drawing */
    overlay(drawing) {
      over = drawing;
      invalidate();
    },
    /** @param {boolean} now */
    sleep(now) {
      if (now === asleep) return;
      asleep = now;
      invalidate();
    },
    /** Call after the head has changed shape. */
    shapeChanged() {
      renderer.shadowMap.needsUpdate = true;
      invalidate();
    },
    /** @param {'light' | 'dark'} theme */
    setTheme(theme) {
      paintBackdrop(theme);
      invalidate();
    },
    /** Where a point (mm) is on the screen, CSS pixels. @param {Vector3} point */
    onScreen(point) {
      const box = canvas.getBoundingClientRect();
      const at = point.clone().project(camera);
      return {
        x: box.left + ((at.x + 1) / 2) * box.width,
        y: box.top + ((1 - at.y) / 2) * box.height,
      };
    },
    /** Whether pictures that rest get smooth edges from now on; the present one is drawn anew, shadows too. @param {boolean} wanted */
    refine(wanted) {
      refines = wanted;
      renderer.shadowMap.needsUpdate = true;
      invalidate();
    },
    /** Frames drawn so far: automation can tell an idle page from a busy one. */
    get frames() {
      return frames;
    },
    /** Whether the picture is as fine as it gets. */
    get isFine() {
      return fine && !scheduled;
    },
    /** Ends it: a frame that was drawn later would tie the renderer to textures that all scenes share. */
    dispose() {
      asleep = true;
      cancelAnimationFrame(scheduled);
      clearTimeout(resting);
      resting = 0;
      observer.disconnect();
      density.removeEventListener('change', fitDensity);
      still.removeEventListener('change', damp);
      beforeFrame.clear();
      controls.dispose();
      canvas.removeEventListener('webglcontextlost', averaging.dispose);
      averaging.dispose();
      renderer.dispose();
      // Browsers allow few contexts at a time.
      renderer.forceContextLoss();
    },
  };
}
