import { Plane, Raycaster, Vector2, Vector3 } from 'three';
import { element } from '../frame/element.js';

/** How far a pointer goes before it means to drag, px. */
const REACH = { mouse: 3, pen: 4, touch: 6 };
/**
 * A vertex and its mirror image are dragged one after the other, which moves the first again; after
 * two rounds both are where they should be to a few micrometres, as people are nearly symmetric.
 */
const ROUNDS = 2;

/**
 * The surface under the pointer follows it, within the selected feature: the face becomes the most
 * probable one in which that point is there. Both sides do the same unless Alt is down.
 *
 * @param {import('./editor.js').Editor} editor
 * @param {{
 *   canvas: HTMLCanvasElement,
 *   scene: ReturnType<typeof import('../stage/scene.js').createScene>,
 *   head: ReturnType<typeof import('../head/head.js').createHead>,
 *   selected: () => string | null,
 *   dragged: () => void,
 * }} parts `dragged` is called when the surface was let go
 */
export function createShaping(editor, { canvas, scene, head, selected, dragged }) {
  const { model, face } = editor;
  const { camera, controls } = scene;
  const raycaster = new Raycaster();
  const pointer = new Vector2();
  /**
   * @typedef {object} Grip
   * @property {number} pointer
   * @property {number} reach
   * @property {{ x: number, y: number }} from
   * @property {number} vertex
   * @property {Vector3} start where the vertex was
   * @property {Vector3} mirrorStart where its mirror image was
   * @property {Plane} plane through the vertex, facing the camera
   * @property {Vector3} offset from where the plane was hit to the vertex
   * @property {import('./history.js').State | null} base once it is dragged
   */
  /** @type {Grip | null} */
  let grip = null;
  /** @type {PointerEvent | null} */
  let waiting = null;

  const marks = [0, 1].map(() => element('div', { class: 'grip', hidden: true, 'aria-hidden': 'true' }));

  /** @param {PointerEvent} event */
  function aim(event) {
    const box = canvas.getBoundingClientRect();
    pointer.set(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    raycaster.setFromCamera(pointer, camera);
  }
  /** The vertex of the selected feature that is under the pointer. @param {PointerEvent} event */
  function vertexUnder(event) {
    const group = selected();
    if (!group) return null;
    aim(event);
    const [hit] = raycaster.intersectObjects(head.group.children);
    if (hit?.object !== head.skin || !hit.face || head.groupAt(hit.face.a) !== group) return null;
    const near = [hit.face.a, hit.face.b, hit.face.c].flatMap(head.verticesAt);
    return near.reduce((best, vertex) => (head.vertex(vertex).distanceTo(hit.point) < head.vertex(best).distanceTo(hit.point) ? vertex : best));
  }

  /** Where a vertex of the face itself is: what is shown of it may be in the middle of a blink, or have another beside it. @param {number} index */
  const own = (index) => new Vector3().fromArray(face.positions, 3 * index);

  function mark() {
    const shown = grip?.base ? [grip.vertex, model.mirror[grip.vertex]] : [];
    marks.forEach((dot, i) => {
      dot.hidden = shown[i] === undefined || (i === 1 && shown[1] === shown[0]);
      if (dot.hidden) return;
      const at = scene.onScreen(own(shown[i]));
      const box = canvas.getBoundingClientRect();
      dot.style.translate = `${at.x - box.left}px ${at.y - box.top}px`;
    });
  }

  /** @param {PointerEvent} event */
  function pull(event) {
    if (!grip) return;
    aim(event);
    const target = raycaster.ray.intersectPlane(grip.plane, new Vector3());
    if (!target) return;
    grip.base ??= editor.state;
    const { vertex, start, mirrorStart } = grip;
    target.add(grip.offset);
    const mirror = model.mirror[vertex];
    const both = !event.altKey;
    // In the middle of the face both sides go the same way only if it stays there.
    if (both && mirror === vertex) target.x = start.x;
    const away = target.clone().sub(start);
    const mirrored = new Vector3(-away.x, away.y, away.z).add(mirrorStart);
    editor.moveFrom(grip.base, (present) => {
      for (let round = 0; round < ROUNDS; round++) {
        present.drag(vertex, target.toArray());
        if (!both || mirror === vertex) break;
        present.drag(mirror, mirrored.toArray());
      }
    });
    mark();
  }

  // Before the camera's controls, which turn the head by the same gesture elsewhere.
  canvas.addEventListener(
    'pointerdown',
    (event) => {
      // Two fingers come closer, wherever the first was put.
      if (grip && event.pointerId !== grip.pointer) end();
      if (event.button !== 0 || event.shiftKey || grip || !event.isPrimary) return;
      const vertex = vertexUnder(event);
      if (vertex === null) return;
      const start = own(vertex);
      const plane = new Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), start);
      const hit = raycaster.ray.intersectPlane(plane, new Vector3());
      if (!hit) return;
      grip = {
        pointer: event.pointerId,
        reach: REACH[/** @type {keyof typeof REACH} */ (event.pointerType)] ?? REACH.mouse,
        from: { x: event.clientX, y: event.clientY },
        vertex,
        start,
        mirrorStart: own(model.mirror[vertex]),
        plane,
        offset: start.clone().sub(hit),
        base: null,
      };
      controls.enableRotate = false;
      document.addEventListener('keydown', escape, true);
      canvas.setPointerCapture(event.pointerId);
    },
    { capture: true },
  );
  canvas.addEventListener('pointermove', (event) => {
    if (grip?.pointer !== event.pointerId) return;
    if (!grip.base && Math.hypot(event.clientX - grip.from.x, event.clientY - grip.from.y) < grip.reach) return;
    // One change a frame, however many events.
    if (!waiting) {
      requestAnimationFrame(() => {
        if (waiting) pull(waiting);
        waiting = null;
      });
    }
    waiting = event;
  });
  /** @returns {boolean} whether it was dragged */
  function letGo() {
    waiting = null;
    const moved = Boolean(grip?.base);
    grip = null;
    controls.enableRotate = true;
    document.removeEventListener('keydown', escape, true);
    mark();
    return moved;
  }
  function end() {
    if (waiting) pull(waiting);
    if (!letGo()) return;
    editor.finish('surface');
    dragged();
  }
  /** @returns {boolean} whether there was something to take back */
  function cancel() {
    const moved = letGo();
    if (moved) editor.cancel();
    return moved;
  }
  /** @param {KeyboardEvent} event */
  function escape(event) {
    // The feature stays chosen: only the drag is given up.
    if (event.key === 'Escape' && cancel()) event.stopPropagation();
  }
  canvas.addEventListener('pointerup', (event) => grip?.pointer === event.pointerId && end());
  canvas.addEventListener('pointercancel', (event) => grip?.pointer === event.pointerId && cancel());

  return { marks };
}
