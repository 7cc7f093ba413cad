import { Raycaster, Triangle, Vector2, Vector3 } from 'three';
import { placed, placeNear } from '../head/marking.js';

/**
 * Which place of the skin is under a point of the screen, and where on the screen a place is.
 *
 * @param {{
 *   canvas: HTMLCanvasElement,
 *   scene: ReturnType<typeof import('./scene.js').createScene>,
 *   head: ReturnType<typeof import('../head/head.js').createHead>,
 * }} parts
 */
export function createSpotting({ canvas, scene, head }) {
  const { camera } = scene;
  const { triangles, rest, positions, normals } = head.surface;
  const raycaster = new Raycaster();
  const [at, out, toEye] = [new Vector3(), new Vector3(), new Vector3()];

  return {
    /**
     * The place that is seen there; null beside the skin, and on what covers it.
     * @param {number} x @param {number} y CSS pixels
     * @returns {import('../head/marks.js').Place | null}
     */
    under(x, y) {
      const box = canvas.getBoundingClientRect();
      raycaster.setFromCamera(new Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2), camera);
      const [hit] = raycaster.intersectObjects(head.group.children);
      if (hit?.object !== head.skin || !hit.face) return null;
      // On the head at rest, where all of it is as it was when it was made.
      const { position, rest: there } = head.skin.geometry.attributes;
      const corners = [hit.face.a, hit.face.b, hit.face.c].map((corner) => new Vector3().fromBufferAttribute(position, corner));
      const weights = Triangle.getBarycoord(hit.point, corners[0], corners[1], corners[2], new Vector3());
      if (!weights) return null;
      at.set(0, 0, 0);
      [hit.face.a, hit.face.b, hit.face.c].forEach((corner, k) => at.addScaledVector(out.fromBufferAttribute(there, corner), weights.getComponent(k)));
      return placeNear(triangles, rest, at);
    },
    /** @param {import('../head/marks.js').Place} place @returns {{ x: number, y: number, isSeen: boolean }} CSS pixels of the canvas; whether the skin there faces who looks */
    onScreen(place) {
      placed(triangles, positions, place, at);
      placed(triangles, normals, place, out);
      const isSeen = out.dot(toEye.copy(camera.position).sub(at)) > 0;
      at.project(camera);
      return { x: ((at.x + 1) / 2) * canvas.clientWidth, y: ((1 - at.y) / 2) * canvas.clientHeight, isSeen };
    },
    /** How far two places are from each other, mm. @param {import('../head/marks.js').Place} one @param {import('../head/marks.js').Place} other */
    apart: (one, other) => placed(triangles, positions, one, at).distanceTo(placed(triangles, positions, other, out)),
    /** How large a millimetre is there, CSS pixels. @param {import('../head/marks.js').Place} place */
    scale(place) {
      placed(triangles, positions, place, at);
      return canvas.clientHeight / (2 * Math.tan((camera.fov * Math.PI) / 360) * at.distanceTo(camera.position));
    },
    /** Where it is on the head: its feature, and how far to its left of its middle and above the tip of its nose, mm. @param {import('../head/marks.js').Place} place */
    whereabouts(place) {
      const { x, y } = placed(triangles, positions, place, at);
      return { group: head.groupAt(triangles[3 * place.triangle]), left: x, above: y - head.landmark('ibug_30').y };
    },
    /** Turns the head so that the place is seen, if it is not. @param {import('../head/marks.js').Place} place */
    turnTo(place) {
      placed(triangles, positions, place, at);
      placed(triangles, normals, place, out).normalize();
      toEye.copy(camera.position).sub(at).normalize();
      if (out.dot(toEye) > 0.35) return;
      let way = Math.atan2(out.x, out.z) - Math.atan2(toEye.x, toEye.z);
      way -= 2 * Math.PI * Math.round(way / (2 * Math.PI));
      scene.turn(way, 0);
    },
  };
}

/** @typedef {ReturnType<typeof createSpotting>} Spotting */
