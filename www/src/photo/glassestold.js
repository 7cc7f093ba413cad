import { GROOVE, sheet } from '../glasses/frame.js';
import { outline, unsized } from '../glasses/outline.js';
import { BROADEST, LENS_HEIGHTS, LENS_WIDTHS, THINNEST, mix } from '../glasses/style.js';
import { BLACK, LINEAR, brightnessOf } from './light.js';

// Which glasses somebody wears in a photo: where a rim would be before the eyes of the fitted head, what is there is darker, or brighter,
// than what is on both sides of it, all around.

/** What is looked at before either eye: to the temple from the middle of the face, and up from the eyes, so many mm apart. */
const FROM = { x: -2, y: -46 };
const CELL = 0.5;
const [WIDE, HIGH] = [168, 176];
/** How far ahead of the cornea the front is; the nose moves it, which `aside` makes up for. mm */
const AHEAD = 15.5;
/** Points of an outline. */
const MANY = 48;
/** Beside a rim, so many mm from it, is what it is compared with; its own edges are so far in it, or as a part of it. */
const BESIDE = 1.3;
const EDGE = { mm: 0.6, part: 0.3 };
/** A place tells no more than this logarithm, and against a rim no more than that. */
const MOST = 0.8;
const AGAINST = -0.2;
/** So much of a rim has to be in the photo. */
const SEEN = 0.6;

/** Where the search begins: round, oval, rectangular, pilot's, upswept, of a brow line, and large. */
const KINDS = [
  { form: 0, size: 0.25, high: 0.9, sweep: 0.5 },
  { form: 0.05, size: 0.5, high: 0.42, sweep: 0.5 },
  { form: 0.7, size: 0.6, high: 0.38, sweep: 0.5 },
  { form: 0.3, size: 0.85, high: 0.66, sweep: 0.05 },
  { form: 0.3, size: 0.55, high: 0.45, sweep: 0.92 },
  { form: 0.3, size: 0.45, high: 0.55, sweep: 0.5 },
  { form: 0.5, size: 0.75, high: 0.58, sweep: 0.6 },
];
const RIMS = [1.2, 2.8];
const CENTRES = [-1, 3];
const HEIGHTS = [-8, -5, -2];
const ASIDES = [-5, -2.5, 0, 2.5, 5];
/** From the best of each kind and so many of all it goes on in steps of these parts of a move. */
const GONE_ON = 6;
const STEPS = [1, 0.5, 0.25];
/** What is moved at once: some only make a way where others stay. */
const MOVES = /** @type {readonly Partial<Candidate>[]} */ ([
  { x: 2 }, { y: 2 }, { aside: 2 }, { size: 0.16 }, { high: 0.12 }, { rim: 0.8 }, { form: 0.2 }, { sweep: 0.16 },
  { size: 0.16, x: 1.12 }, { size: 0.16, x: -1.12 }, { high: 0.08, y: 1 }, { high: 0.08, y: -1 }, { size: 0.16, high: -0.1 },
  { rim: 0.8, size: -0.11 }, { x: 1, aside: 1 }, { x: 1, aside: -1 },
]);
/** Lenses are so far from the pupils: to the temples, up, and both to the subject's left, mm. */
const WITHIN = { x: [-6, 10], y: [-14, 8], aside: [-8, 8] };

/**
 * Whole rims differ by this logarithm below both lenses and by that in the worst of the four halves. Of 92 heads that the page drew 28 of the 29 with such
 * had 0.24 and 0.13 or more, 41 without glasses, and two portraits, 0.17 and 0.12 at most: what is around eyes are brows, which are above them.
 */
const BELOW = 0.2;
const WORST = 0.13;
/** And they have a bridge, which differs by so much, by more where no rim is seen below: without it was 0.08 at most, with one 0.23 or more. */
const BRIDGE = 0.18;
const BRIDGE_ALONE = 0.3;
/** In photos with fewer px a mm brows that are near to each other look like that. */
const FINE = 0.7;
/**
 * A rim that is above the lenses alone differs by so much on both sides, and so do its ends beside nose and temple, at these parts of half the height: where none
 * is seen below, brows, which have none, had 0.28 at most there.
 */
const ABOVE = 0.35;
const FLANK = [0.3, 0.75];
/** What hides so much less below the lenses than above is a thread that holds them, or their edge. */
const THREAD = 0.45;
/** Bridges are looked for so far above the eyes, below brows that meet, of these half heights, with so much of an arch, mm. */
const AT_BRIDGE = [-6, 7];
const BRIDGE_HALVES = [0.75, 1.5, 2.2];
const ARCH = 2;
const BESIDE_BRIDGE = 1.5;
/** How far a profile through the rim goes to both sides, mm, and where in it the rim is. */
const PROFILE = [-6, 9];
const IN_PROFILE = [-1.5, 4];
/** What is on a side of a rim is so near to it, mm. */
const SIDE = { lens: 4, skin: 5 };
/** An edge that differs by less than this logarithm tells no breadth: that of a frame before a dark lens. */
const LEAST_EDGE = 0.35;
/** Rims of both sides are as broad up to this factor: what is seen broader is seen worse. */
const ALIKE = 1.4;
/** Skin that is seen through a lens, and beside it, below the eye: mm from the edge of the rim. */
const THROUGH = [-7, -3];
const BELOW_LENS = [1.5, 5];

/**
 * What may be worn: the outline of `style.js` by its sliders, how broad the rim is, mm, how far the lenses' middles are from that of the face, to
 * the temples and up, and both of them to the subject's left, mm.
 * @typedef {{ form: number, size: number, high: number, sweep: number, rim: number, x: number, y: number, aside: number }} Candidate
 */
/** Logarithms of the green and blue light, and the light: red, green and blue. @typedef {{ light: Float32Array, rgb: Float32Array }} Side */

/** How many px a mm at the face has. @param {import('phiz').PhotoCamera} camera */
const pxOfMm = ({ focal, translation }) => focal / translation[2];
const clamp = (/** @type {number} */ value) => (value > MOST ? MOST : value < AGAINST ? AGAINST : value);
const median = (/** @type {number[]} */ values) => values.sort((a, b) => a - b)[values.length >> 1];

/**
 * What the photo has where the front of glasses would be, before the subject's left eye and before the right one, as in a mirror.
 * @param {{ rgba: Uint8ClampedArray, width: number, height: number }} photo
 * @param {import('phiz').PhotoCamera} camera @param {import('../glasses/fit.js').Stand} stand
 * @returns {Side[]}
 */
function unrolled({ rgba, width, height }, { focal, centre, rotation, translation }, { scale, axes: [X, Y, Z], eyes, pupils }) {
  return [1, -1].map((way) => {
    const light = new Float32Array(WIDE * HIGH).fill(NaN);
    const rgb = new Float32Array(3 * WIDE * HIGH);
    const [p, c, colour] = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
    for (let j = 0; j < HIGH; j++) {
      for (let i = 0; i < WIDE; i++) {
        const [x, y] = [FROM.x + i * CELL, FROM.y + j * CELL];
        const z = AHEAD + sheet(x - pupils / 2, y, { width: USUAL_WIDTH });
        for (let k = 0; k < 3; k++) p[k] = eyes[k] + scale * (X[k] * way * x + Y[k] * y + Z[k] * z);
        for (let k = 0; k < 3; k++) c[k] = rotation[3 * k] * p[0] + rotation[3 * k + 1] * p[1] + rotation[3 * k + 2] * p[2] + translation[k];
        const [u, v] = [0, 1].map((k) => centre[k] + (focal * c[k]) / c[2] - 0.5);
        const [left, top] = [Math.floor(u), Math.floor(v)];
        if (!(left >= 0 && top >= 0 && left < width - 1 && top < height - 1)) continue;
        const [s, t] = [u - left, v - top];
        for (let k = 0; k < 3; k++) {
          const o = 4 * (top * width + left) + k;
          colour[k] = (LINEAR[rgba[o]] * (1 - s) + LINEAR[rgba[o + 4]] * s) * (1 - t) + (LINEAR[rgba[o + 4 * width]] * (1 - s) + LINEAR[rgba[o + 4 * width + 4]] * s) * t;
        }
        const at = j * WIDE + i;
        rgb.set(colour, 3 * at);
        // Gold is about as bright as skin, and less blue.
        light[at] = Math.log(BLACK + (colour[1] + colour[2]) / 2);
      }
    }
    return { light, rgb };
  });
}
/** The width of the lens that a front is bent as. */
const USUAL_WIDTH = 50;

/** The cell of a place; -1 beside all of them. @param {number} x @param {number} y */
function cellOf(x, y) {
  const i = Math.round((x - FROM.x) / CELL);
  const j = Math.round((y - FROM.y) / CELL);
  return i >= 0 && j >= 0 && i < WIDE && j < HIGH ? j * WIDE + i : -1;
}
/** @param {Float32Array} light @param {number} x @param {number} y */
const lightAt = (light, x, y) => light[cellOf(x, y)] ?? NaN;

/** Where a rim and what is beside it is looked at, mm out of the outline: before it on the lens, in its two edges, and beyond it. @param {{ rim: number }} of */
function looksAt({ rim }) {
  const edge = Math.min(EDGE.part * rim, EDGE.mm);
  return { before: -GROOVE - BESIDE, into: edge - GROOVE, out: rim - GROOVE - edge, beyond: rim - GROOVE + BESIDE };
}

/** @param {Candidate} of @returns {import('../glasses/style.js').Lens} */
function outlined({ form, size, high, sweep }) {
  const width = mix(...LENS_WIDTHS, size);
  return { form, sweep: 2 * sweep - 1, width, height: width * mix(...LENS_HEIGHTS, high) };
}

/**
 * Tells the glasses that somebody wears.
 * @param {Parameters<typeof unrolled>[0]} photo as it was fitted
 * @param {import('phiz').PhotoCamera} camera of the fit
 * @param {import('../glasses/fit.js').Stand} stand of glasses on the fitted face
 * @returns {Glasses | null} null for a bare face, or where too little of it is seen
 */
export function tellGlasses(photo, camera, stand) {
  const sides = unrolled(photo, camera, stand);
  /** @type {Map<string, ReturnType<typeof outline>>} */
  const known = new Map();
  /** @type {Map<string, ReturnType<typeof unsized>>} */
  const boxes = new Map();
  /** Many have the same. @param {Candidate} of */
  function outlineOf(of) {
    const form = `${of.form} ${of.sweep}`;
    const key = `${form} ${of.size} ${of.high}`;
    let found = known.get(key);
    if (found) return found;
    const lens = outlined(of);
    let box = boxes.get(form);
    if (!box) boxes.set(form, (box = unsized(lens, 4 * MANY)));
    known.set(key, (found = outline(lens, MANY, box)));
    return found;
  }
  /**
   * How much darker the rim is than what is beside it, and how much brighter; of each `step`th point.
   * @param {Candidate} of
   */
  function rimOf(of, step = 1) {
    const ring = outlineOf(of);
    const { before, into, out, beyond } = looksAt(of);
    let dark = 0;
    let bright = 0;
    let count = 0;
    for (let side = 0; side < 2; side++) {
      const { light } = sides[side];
      const x = of.x + (side ? -of.aside : of.aside);
      for (let i = 0; i < ring.length; i += step) {
        // Of thousands of candidates: plain numbers.
        const one = ring[i];
        const u = x + one.x;
        const v = of.y + one.y;
        const inner = lightAt(light, u + before * one.nx, v + before * one.ny) - lightAt(light, u + into * one.nx, v + into * one.ny);
        const outer = lightAt(light, u + beyond * one.nx, v + beyond * one.ny) - lightAt(light, u + out * one.nx, v + out * one.ny);
        if (!(inner + outer < Infinity)) continue;
        dark += clamp(inner) + clamp(outer);
        bright += clamp(-inner) + clamp(-outer);
        count += 2;
      }
    }
    return count < (SEEN * 4 * ring.length) / step ? [-1, -1] : [dark / count, bright / count];
  }

  const limits = { ...WITHIN, x: WITHIN.x.map((x) => x + stand.pupils / 2), form: [0, 1], size: [0, 1], high: [0, 1], sweep: [0, 1], rim: [THINNEST, BROADEST] };
  /** @type {{ of: Candidate, bright: number, score: number }[]} */
  const all = [];
  /** The best of each kind, and the best of all. */
  const starts = new Set(
    KINDS.map((kind) => {
      const from = all.length;
      for (const rim of RIMS) {
        for (const centre of CENTRES) {
          for (const y of HEIGHTS) {
            for (const aside of ASIDES) {
              const of = { ...kind, rim, x: stand.pupils / 2 + centre, y, aside };
              rimOf(of, 2).forEach((score, bright) => all.push({ of, bright, score }));
            }
          }
        }
      }
      return all.slice(from).reduce((best, one) => (one.score > best.score ? one : best));
    }),
  );
  for (const one of all.sort((a, b) => b.score - a.score).slice(0, GONE_ON)) starts.add(one);
  let best = { of: all[0].of, bright: 0, score: -1 };
  for (const { of, bright } of starts) {
    let here = { of, bright, score: rimOf(of)[bright] };
    for (const step of STEPS) {
      for (let moved = true; moved; ) {
        moved = false;
        for (const move of MOVES) {
          for (const way of [-step, step]) {
            const next = { ...here.of };
            for (const [name, by] of /** @type {[keyof Candidate, number][]} */ (Object.entries(move))) {
              const [least, most] = limits[name];
              next[name] = Math.min(most, Math.max(least, next[name] + way * by));
            }
            const score = rimOf(next)[bright];
            if (score > here.score + 1e-6) {
              here = { of: next, bright, score };
              moved = true;
            }
          }
        }
      }
    }
    if (here.score > best.score) best = here;
  }

  /** @param {Candidate} of @param {1 | -1} sign -1 for a rim that is brighter than skin @returns {Glasses | null} */
  function told(of, sign) {
    const [leftAbove, leftBelow, rightAbove, rightBelow] = differing(of, sign, [(_, v) => v > 0, (_, v) => v < 0]);
    const [above, below] = [Math.min(leftAbove, rightAbove), (leftBelow + rightBelow) / 2];
    const bridge = bridgeOf(of);
    const isWhole = below > BELOW && Math.min(above, leftBelow, rightBelow) > WORST && bridge > BRIDGE;
    if (!isWhole && (bridge < BRIDGE_ALONE || pxOfMm(camera) < FINE)) return null;
    const flanks = differing(of, sign, [(u, v) => u < 0 && v > FLANK[0] && v < FLANK[1], (u, v) => u > 0 && v > FLANK[0] && v < FLANK[1]]);
    if (!isWhole && Math.min(above, ...flanks) < ABOVE) return { form: null, rim: 0, half: false, frame: null, taken: takenBy(of, of.rim) };
    const { form, sweep, width, height } = outlined(of);
    const { rim, from } = breadthOf(of, sign, !isWhole);
    const out = from + GROOVE;
    const half = !isWhole || (rim !== null && hiddenBy(of, sign, rim, -1) < THREAD * hiddenBy(of, sign, rim, 1));
    return { form: { form, sweep, width: width + 2 * out, height: height + 2 * out }, rim, half, frame: frameOf(of, rim ?? of.rim, half), taken: takenBy(of, rim ?? of.rim) };
  }

  /** How much the rim differs in some parts of it, before the left eye and then before the right one. @param {Candidate} of @param {1 | -1} sign @param {readonly ((u: number, v: number) => boolean)[]} parts by a place in the half box */
  function differing(of, sign, parts) {
    const { before, into, out, beyond } = looksAt(of);
    const { width, height } = outlined(of);
    const sums = [...parts, ...parts].map(() => [0, 0]);
    walk(of, (side, { x, y }, at) => {
      const { light } = sides[side];
      const differs = clamp(sign * (light[at(before)] - light[at(into)])) + clamp(sign * (light[at(beyond)] - light[at(out)]));
      if (!(differs < Infinity)) return;
      parts.forEach((is, i) => {
        if (!is((2 * x) / width, (2 * y) / height)) return;
        const sum = sums[side * parts.length + i];
        sum[0] += differs / 2;
        sum[1]++;
      });
    });
    return sums.map(([sum, count]) => (count > 0 ? sum / count : 0));
  }

  /** Goes along the outline, on both sides. @param {Candidate} of @param {(side: number, one: ReturnType<typeof outline>[number], at: (out: number) => number) => void} visit `at` is the cell so many mm out of it */
  function walk(of, visit) {
    for (const side of [0, 1]) {
      const x = of.x + (side ? -of.aside : of.aside);
      for (const one of outlineOf(of)) visit(side, one, (out) => cellOf(x + one.x + out * one.nx, of.y + one.y + out * one.ny));
    }
  }

  /** How much a bar between the lenses differs from what is above and below it. @param {Candidate} of */
  function bridgeOf(of) {
    const { width } = outlined(of);
    const edge = Math.max(3, of.x - width / 2 - 1);
    let most = 0;
    for (let y = AT_BRIDGE[0]; y <= AT_BRIDGE[1]; y += CELL) {
      for (const half of BRIDGE_HALVES) {
        let [dark, bright, count] = [0, 0, 0];
        for (let x = -0.8 * edge; x <= 0.8 * edge; x += CELL) {
          const rise = y + ARCH * (1 - (x / edge) ** 2);
          const { light } = sides[x + of.aside < 0 ? 1 : 0];
          const away = Math.abs(x + of.aside);
          const bar = lightAt(light, away, rise);
          const [over, under] = [lightAt(light, away, rise + half + BESIDE_BRIDGE) - bar, lightAt(light, away, rise - half - BESIDE_BRIDGE) - bar];
          if (!(over + under < Infinity)) continue;
          dark += Math.min(MOST, over, under);
          bright += Math.min(MOST, -over, -under);
          count++;
        }
        if (count > 0) most = Math.max(most, dark / count, bright / count);
      }
    }
    return most;
  }

  /** How broad the rim is, mm, null where its edges are not seen, and how far out of the outline it begins. @param {Candidate} of @param {1 | -1} sign @param {boolean} half above alone @returns {{ rim: number | null, from: number }} */
  function breadthOf(of, sign, half) {
    // Each side has its own, as nothing is quite where the fit has it: what is seen less broad is seen better.
    const [a, b] = [0, 1].map((side) => breadthOn(side, of, sign, half)).sort((a, b) => (a.rim ?? Infinity) - (b.rim ?? Infinity));
    if (a.rim === null || b.rim === null || b.rim > ALIKE * a.rim) return a;
    return { rim: (a.rim + b.rim) / 2, from: (a.from + b.from) / 2 };
  }
  /** @param {number} on the side @param {Candidate} of @param {1 | -1} sign @param {boolean} half @returns {{ rim: number | null, from: number }} */
  function breadthOn(on, of, sign, half) {
    /** @type {{ d: number, value: number }[]} */
    const profile = [];
    for (let d = PROFILE[0]; d <= PROFILE[1]; d += CELL / 2) {
      /** @type {number[]} */
      const values = [];
      walk(of, (side, { y }, at) => {
        if (side !== on || (half && y < 0)) return;
        const value = sides[side].light[at(d)];
        // Blur is one of light, not of its logarithm.
        if (value < Infinity) values.push(sign * Math.exp(value));
      });
      if (values.length > 0) profile.push({ d, value: median(values) });
    }
    const within = profile.filter(({ d }) => d > IN_PROFILE[0] && d < IN_PROFILE[1]);
    if (within.length === 0) return { rim: null, from: -GROOVE };
    const middle = within.reduce((a, b) => (b.value < a.value ? b : a));
    // A lens that is darker than its rim goes over into it.
    if (profile[0].value < middle.value) return { rim: null, from: -GROOVE };
    const most = (/** @type {(d: number) => boolean} */ is) => Math.max(...profile.filter(({ d }) => is(d)).map(({ value }) => value));
    const [inside, outside] = [most((d) => d < middle.d && d >= middle.d - SIDE.lens), most((d) => d > middle.d && d <= middle.d + SIDE.skin)];
    /** Where the profile is half as high again. @param {number} level @param {1 | -1} way */
    const crossed = (level, way) => {
      const half = (level + middle.value) / 2;
      let i = profile.indexOf(middle);
      while (profile[i + way].value < half) i += way;
      const [a, b] = [profile[i], profile[i + way]];
      return a.d + ((half - a.value) / (b.value - a.value)) * (b.d - a.d);
    };
    const differs = Math.abs(Math.log(Math.min(inside, outside) / middle.value));
    if (!(Math.min(inside, outside) > middle.value && differs > LEAST_EDGE)) return { rim: null, from: -GROOVE };
    const from = crossed(inside, -1);
    const seen = crossed(outside, 1) - from;
    return { rim: Math.min(BROADEST, Math.max(THINNEST, seen)), from };
  }

  /** How many mm of what is beside it a rim hides. @param {Candidate} of @param {1 | -1} sign @param {number} rim @param {1 | -1} where above the middle, or below */
  function hiddenBy(of, sign, rim, where) {
    const { before, beyond } = looksAt({ rim });
    /** @type {number[]} */
    const all = [];
    walk(of, (side, { y }, at) => {
      if (where * y < 0) return;
      const lit = (/** @type {number} */ d) => sign * Math.exp(sides[side].light[at(d)]);
      const beside = Math.min(lit(before), lit(beyond));
      let hidden = 0;
      for (let d = before + CELL; d < beyond; d += CELL) hidden += Math.max(0, CELL * (1 - lit(d) / beside) * sign);
      if (hidden < Infinity) all.push(hidden);
    });
    return all.length > 0 ? median(all) : 0;
  }

  /** The colours of some cells, one by one. @param {(take: (side: number, cell: number) => void) => void} gather @returns {[number, number, number] | null} */
  function colourOf(gather) {
    /** @type {number[][]} */
    const values = [[], [], []];
    gather((side, cell) => {
      if (sides[side].light[cell] < Infinity) values.forEach((list, k) => list.push(sides[side].rgb[3 * cell + k]));
    });
    return values[0].length > 0 ? /** @type {[number, number, number]} */ (values.map(median)) : null;
  }
  /** Skin beside the lenses, below the eyes. @param {Candidate} of @param {number} rim @param {readonly number[]} between */
  const skinOf = (of, rim, [from, to]) =>
    colourOf((take) =>
      walk(of, (side, { ny }, at) => {
        if (ny < -0.6) for (let d = from; d <= to; d += CELL) take(side, at(d > 0 ? rim - GROOVE + d : d));
      }),
    );

  /** The rim's colour as a part of the skin's. @param {Candidate} of @param {number} rim @param {boolean} half */
  function frameOf(of, rim, half) {
    const skin = skinOf(of, rim, BELOW_LENS);
    const frame = colourOf((take) =>
      walk(of, (side, { y }, at) => {
        if (!half || y > 0) take(side, at(rim / 2 - GROOVE));
      }),
    );
    return skin && frame && /** @type {[number, number, number]} */ (frame.map((value, k) => Math.max(BLACK, value) / Math.max(BLACK, skin[k])));
  }
  /** How much the lenses take of the light of the skin behind them. @param {Candidate} of @param {number} rim */
  function takenBy(of, rim) {
    const [bare, through] = [skinOf(of, rim, BELOW_LENS), skinOf(of, rim, THROUGH)];
    return bare && through ? Math.max(0, 1 - (BLACK + brightnessOf(through)) / (BLACK + brightnessOf(bare))) : 0;
  }

  return best.score > 0 ? told(best.of, best.bright ? -1 : 1) : null;
}

/**
 * Glasses that were told. `form` is of the lenses as `style.js` has it, null where they have no rim and so no edge that is seen; `rim` is how broad that
 * is, mm, null where nobody knows; `half` whether there is one above alone; `frame` its colour as a part of that of the skin around it, linear; and `taken`
 * how much of the light the lenses take.
 * @typedef {{
 *   form: import('../glasses/style.js').Lens | null, rim: number | null, half: boolean,
 *   frame: readonly [number, number, number] | null, taken: number,
 * }} Glasses
 */
