import { atRest, createHead, framing } from '../head/head.js';
import { createPreview } from '../head/preview.js';
import { createScene } from './scene.js';

/**
 * A model's median face in a scene of its own: in plain colours at once, with its skin, eyes and light when
 * the groundwork is there.
 *
 * @param {import('phiz').FaceModel} model needed until the view is complete
 * @param {HTMLCanvasElement} canvas laid out: the scene measures it
 * @param {import('../groundwork/lay.js').Laying} laying of the groundwork
 * @param {Parameters<typeof createScene>[2]} [covered] what lies over the canvas
 */
export function createView(model, canvas, laying, covered) {
  // The head at rest is painted on the median face, whatever is asked for.
  const median = model.face();
  const rest = atRest(model, median);
  median.free();
  // Before anything is drawn: it is what takes longest.
  const groundwork = laying.of(rest);
  const { subject, fade } = framing(model, rest.positions);
  const scene = createScene(canvas, subject, covered);
  const preview = createPreview(model, rest, fade);
  scene.scene.add(preview.mesh);
  return {
    scene,
    groundwork,
    /** In place of the quick head the real one. @param {import('../groundwork/groundwork.js').Groundwork} groundwork */
    complete(groundwork) {
      const head = createHead(model, rest, groundwork);
      preview.dispose();
      scene.scene.add(head.group);
      scene.light(groundwork.studio);
      // Hair that comes later is to be in view as well.
      scene.contain((...from) => {
        const each = head.tresses.map((one) => one.reach(...from));
        return [Math.min(...each.map(([low]) => low)), Math.max(...each.map(([, high]) => high))];
      });
      scene.widen((...from) => {
        const each = head.tresses.map((one) => one.breadth(...from));
        return [Math.max(0, ...each.map(([left]) => left)), Math.max(0, ...each.map(([, right]) => right))];
      });
      return head;
    },
  };
}
