import { Raycaster, Vector2 } from 'three';

const CLICK_REACH = 6;

/**
 * Tells which feature is under the pointer, and which one was clicked: none, beside the head.
 *
 * @param {{
 *   canvas: HTMLCanvasElement,
 *   camera: import('three').Camera,
 *   head: ReturnType<typeof import('../head/head.js').createHead>,
 *   hover: (group: string | null, onSkin: boolean) => void,
 *   pick: (group: string | null, event: PointerEvent) => void,
 * }} on `onSkin`: whether it is the skin that the pointer is on there
 */
export function createPicking({ canvas, camera, head, hover, pick }) {
  const raycaster = new Raycaster();
  const pointer = new Vector2();
  /** @type {PointerEvent | null} */
  let waiting = null;
  /** @type {{ x: number, y: number } | null} */
  let down = null;
  let touches = 0;

  /** @param {PointerEvent} event @returns {{ group: string | null, onSkin: boolean }} */
  function under(event) {
    const box = canvas.getBoundingClientRect();
    pointer.set(
      ((event.clientX - box.left) / box.width) * 2 - 1,
      1 - ((event.clientY - box.top) / box.height) * 2,
    );
    raycaster.setFromCamera(pointer, camera);
    const [eye] = raycaster.intersectObjects(
      head.group.children.filter((child) => child !== head.skin),
    );
    const [skin] = raycaster.intersectObject(head.skin);
    if (eye && (!skin || eye.distance < skin.distance)) return { group: 'eyes', onSkin: false };
    return skin?.face ? { group: head.groupAt(skin.face.a), onSkin: true } : { group: null, onSkin: false };
  }

  /** The same for a pointer that something else holds. @param {PointerEvent} event */
  function groupOnHead(event) {
    return document.elementFromPoint(event.clientX, event.clientY) === canvas ? under(event).group : null;
  }

  canvas.addEventListener('pointermove', (event) => {
    if (event.pointerType === 'touch' || event.buttons) return;
    // One look-up a frame, however many events.
    if (!waiting) {
      requestAnimationFrame(() => {
        if (waiting) {
          const { group, onSkin } = under(waiting);
          hover(group, onSkin);
        }
        waiting = null;
      });
    }
    waiting = event;
  });
  canvas.addEventListener('pointerleave', () => {
    waiting = null;
    hover(null, false);
  });
  canvas.addEventListener('pointerdown', (event) => {
    touches += 1;
    down = touches === 1 && event.button === 0 ? { x: event.clientX, y: event.clientY } : null;
  });
  canvas.addEventListener('pointercancel', () => {
    touches = 0;
    down = null;
  });
  canvas.addEventListener('pointerup', (event) => {
    touches = Math.max(0, touches - 1);
    if (!down) return;
    const moved = Math.hypot(event.clientX - down.x, event.clientY - down.y);
    down = null;
    if (moved > CLICK_REACH) return;
    pick(under(event).group, event);
  });

  return { groupUnder: groupOnHead };
}
