import { distances, heatColours, scaleEnd } from './heat.js';
import { sameWeights } from '../editing/history.js';
import { part } from '../frame/download.js';
import { text } from '../text.js';

/** Of what a face's outline is drawn, here and in what says whose it is: the blue that neither skin nor the wall has. */
export const OUTLINE = '#0a5c8a';

/**
 * What the stage shows: the face, or for a while another one; both, split by a line; its distance
 * from another as colours. The face itself is never touched.
 *
 * @param {{
 *   face: import('phiz').Face,
 *   head: ReturnType<typeof import('../head/head.js').createHead>,
 *   scene: ReturnType<typeof import('./scene.js').createScene>,
 *   colouring: (of?: import('../head/colouring.js').Colouring) => import('../head/colouring.js').Colouring,
 *   onScale: (millimetres: number) => void,
 * }} parts `colouring` tells in what colours those of a face are shown, or this one's; `onScale` is told where the heat map's colours end
 */
export function createDisplay({ face, head, scene, colouring, onScale }) {
  /** @type {import('phiz').Face | null} */
  let instead = null;
  /** Of the face that is shown instead. @type {Looks} */
  let looks = {};
  let plain = false;
  /** @type {{ other: import('phiz').Face, at: number, looks: Looks } | null} */
  let split = null;
  /** The face that distances are from. @type {import('phiz').Face | null} */
  let reference = null;
  /** The face whose contours are drawn over the head. @type {import('phiz').Face | null} */
  let outlined = null;
  /** What draws them, once somebody wanted it, and of what it has them. @type {{ lines: ReturnType<typeof import('./outline.js').createOutline>, code: string, expression: object } | null} */
  let outline = null;
  /** Who follows what is shown instead. @type {(() => void)[]} */
  const followers = [];
  /** Where its vertices were when they were asked for last. @type {{ code: string, expression: object, positions: Float32Array } | null} */
  let from = null;
  const away = new Float32Array(face.model.vertexCount);
  const colours = new Float32Array(3 * away.length);

  /** Another face beside this one, or in its place, makes the same face. @param {import('phiz').Face} other */
  function alike(other) {
    const { expression } = face;
    if (!sameWeights(other.expression, expression)) other.expression = expression;
    return other;
  }
  const shown = () => (instead ? alike(instead) : face);

  /** @param {Looks} of */
  function dress({ colours, worn = true }) {
    const now = colouring(colours);
    if (head.colouring !== now) head.paint(now);
    head.wornStrength.value = head.wears ? Number(worn) : 0;
  }

  /** The face that distances are from stays as it is while this one changes. @param {import('phiz').Face} other */
  function positionsOf(other) {
    const { code, expression } = alike(other);
    if (from?.code !== code || from.expression !== expression) from = { code, expression, positions: other.positions.slice() };
    return from.positions;
  }

  function heat() {
    if (!reference || plain) return head.paintHeat(null);
    // First what may be evaluated, and move the module's memory.
    const there = positionsOf(reference);
    distances(shown().positions, there, away);
    const end = scaleEnd(away);
    heatColours(away, end, colours);
    head.paintHeat(colours);
    onScale(end);
  }
  /** The other's contours are as its expression is, which is this one's. */
  function trace() {
    if (!outlined || !outline) return;
    const other = alike(outlined);
    const { code, expression } = other;
    if (outline.code === code && outline.expression === expression) return;
    outline = { ...outline, code, expression };
    outline.lines.set(other.positions, other.normals);
  }
  /** @param {readonly [number, number]} [range] */
  function refresh(range) {
    // First what may be evaluated, and move the module's memory.
    trace();
    // Two that are side by side take their turns as they are drawn.
    if (!split) head.update(shown(), range);
    heat();
    scene.shapeChanged();
  }
  function applySplit() {
    const sides = split;
    scene.split(
      sides && {
        at: sides.at,
        pose(side) {
          dress(side === 'left' ? sides.looks : looks);
          head.update(side === 'left' ? alike(sides.other) : shown());
          head.heatStrength.value = side === 'right' && reference && !plain ? 1 : 0;
        },
      },
    );
    if (!sides) dress(looks);
  }

  return {
    refresh,
    /** What is shown: this face, or for a while another one. */
    get shown() {
      const { code, expression } = shown();
      return { code, expression };
    },
    /** Another face is shown, or this one again. @param {() => void} follower */
    onShow(follower) {
      followers.push(follower);
    },
    /** The colours of what is shown have changed, or how much of them is to be seen. */
    repaint: () => dress(looks),
    /**
     * Shows another face; null goes back.
     * @param {import('phiz').Face | null} other
     * @param {Looks & { uncoloured?: boolean }} [options] its looks; without the heat map
     */
    show(other, { uncoloured = false, ...own } = {}) {
      instead = other;
      looks = own;
      plain = uncoloured && other !== null;
      dress(looks);
      refresh();
      for (const follow of followers) follow();
    },
    /**
     * The face's lids are shut so far at least, 0 to 1, in what is shown and nowhere else. Not when another
     * face is shown, or is beside it.
     * @param {number} amount @returns {boolean} whether they are
     */
    shut(amount) {
      if (instead || split || reference) return false;
      const own = face.expression;
      const { eyeBlinkLeft = 0, eyeBlinkRight = 0 } = own;
      if (amount > 0) face.expression = { ...own, eyeBlinkLeft: Math.max(eyeBlinkLeft, amount), eyeBlinkRight: Math.max(eyeBlinkRight, amount) };
      try {
        head.update(face);
      } finally {
        if (amount > 0) face.expression = own;
      }
      scene.shapeChanged();
      return true;
    },
    /** Draws what is shown at once, for whoever copies the picture. @throws where the graphics card was lost: there is none */
    draw() {
      head.finish();
      // Nor is what the pointer is on the face's.
      head.unmarked = true;
      try {
        scene.redraw();
      } finally {
        head.unmarked = false;
      }
      if (scene.renderer.getContext().isContextLost()) throw new Error(text.noCard);
    },
    /**
     * Another face left of a line; null takes it away.
     * @param {import('phiz').Face | null} other @param {number} [at] the line's place, 0 to 1
     * @param {Looks} [looks] of the other
     */
    split(other, at = 0.5, looks = {}) {
      split = other && { other, at, looks };
      applySplit();
      refresh();
    },
    /**
     * Colours the distance from a face, as it is whenever this one changes; null stops.
     * @param {import('phiz').Face | null} other
     */
    heat(other) {
      reference = other;
      refresh();
    },
    /**
     * Draws a face's contours over the head, as they are seen from where that is looked at from; null takes them away.
     * @param {import('phiz').Face | null} other
     * @throws Failure when what draws them does not come
     */
    async outline(other) {
      outlined = other;
      if (other && !outline) {
        const { createOutline } = await part(() => import('./outline.js'));
        outline ??= { lines: createOutline(face.model, head.neckEnd, OUTLINE), code: '', expression: {} };
      }
      trace();
      scene.overlay(outlined && outline && outline.lines.draw);
    },
    /**
     * Takes portraits; the stage is as before afterwards.
     * @param {{
     *   pose: () => { face: import('phiz').Face, colouring: import('../head/colouring.js').Colouring },
     *   into: HTMLCanvasElement,
     * }[]} sitters `pose` is asked just before the picture, so that one face can sit for all
     */
    portraits(sitters) {
      const marks = [...head.markStrength];
      head.markStrength.fill(0);
      head.heatStrength.value = 0;
      // Others do not wear this person's colours.
      const worn = head.wornStrength.value;
      head.wornStrength.value = 0;
      const done = head.lend(() =>
        scene.portraits(
          sitters.map(({ pose, into }) => ({
            pose() {
              const sitter = pose();
              head.update(sitter.face);
              head.paint(sitter.colouring, false);
              head.finish();
            },
            into,
          })),
        ),
      );
      head.markStrength[0] = marks[0];
      head.markStrength[1] = marks[1];
      head.wornStrength.value = worn;
      refresh();
      scene.redraw();
      return done;
    },
  };
}

/** @typedef {ReturnType<typeof createDisplay>} Display */
/**
 * What a face looks like beside its shape; without colours of its own it has those of the face that is worked on, and it
 * wears the photo, if one is worn: so much of it, 0 to 1, where it is between two faces.
 * @typedef {{ colours?: import('../head/colouring.js').Colouring, worn?: boolean | number }} Looks
 */
