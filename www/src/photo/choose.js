import { element } from '../frame/element.js';
import { text } from '../text.js';
import { boxOf } from './points.js';

/**
 * A frame around each face of the photo, of which one is to be chosen.
 *
 * @param {import('./view.js').View} view
 * @param {(face: number) => void} chosen
 */
export function createChoice(view, chosen) {
  /** @type {{ frame: HTMLElement, box: number[] }[]} */
  let frames = [];
  const root = element('div', { class: 'photo-faces', role: 'group', 'aria-label': text.photo.faces, hidden: true });
  view.over.append(root);

  function draw() {
    if (root.hidden) return;
    for (const { frame, box } of frames) {
      const [left, top] = view.onScreen(box[0], box[1]);
      const [right, bottom] = view.onScreen(box[2], box[3]);
      frame.style.transform = `translate(${left}px, ${top}px)`;
      frame.style.width = `${right - left}px`;
      frame.style.height = `${bottom - top}px`;
    }
  }
  view.onMove(draw);
  return {
    /** @param {ArrayLike<number>[]} faces points as x, y pairs */
    open(faces) {
      frames = faces.map((points, i) => {
        const box = boxOf(points);
        const frame = element(
          'button',
          { type: 'button', class: 'photo-face', 'aria-label': text.photo.face(i + 1, faces.length), onclick: () => chosen(i) },
          element('span', { 'aria-hidden': 'true' }, String(i + 1)),
        );
        // A press on a face is no drag of the photo.
        frame.addEventListener('pointerdown', (event) => event.stopPropagation());
        return { frame, box };
      });
      // As they stand in the photo, for those who go from one to the next.
      const across = [...frames].sort((a, b) => a.box[0] - b.box[0]);
      root.replaceChildren(...across.map(({ frame }) => frame));
      draw();
    },
    /** @param {boolean} now */
    show(now) {
      root.hidden = !now;
      draw();
    },
    focus: () => frames[0]?.frame.focus(),
  };
}
