import { chance } from '../chance.js';
import { BROW_FORM } from '../head/colouring.js';
import { browLine, heightOf, movesOf, unmovedBrow } from '../hair/browform.js';
import { browLines, growBrows } from '../hair/browline.js';
import { reliefAround } from '../hair/relief.js';
import { brightnessOf } from './light.js';

// Which form brows have in a photo: where the skin is darker than around them, in a grid along the line that the model's own have.

/** Where the grid begins and ends: shares of the line from its outer end on. */
const ALONG = [-0.3, 1.25];
const COLUMNS = 26;
/** How far it goes down, where lids are, and up from the line, mm; and how far apart its rows are. */
const DOWN = -10;
const UP = 13;
const ROW = 1;
/** So many hairs tell how dense the model's own brows are, in cells so long (a share of the line) and high (mm), from one place to another. */
const HAIRS = 6000;
const CELL = [0.02, 0.5];
const FROM = [-0.4, -12];
const TO = [1.4, 14];
/** Photos, points and fits blur them by so many cells. */
const BLUR = [2, 2];
/** Brows that differ from the skin by less than this logarithm have no form that could be told. */
const FAINT = 0.1;
/** Where fewer of the cells are seen nothing is told. */
const FEWEST = 0.35;
/** A slider's end has to tell so much of what varies: what else is dark there is no brow's form. */
const USUAL = 0.04;
/** More than this is not left of what varies by brows that are seen: those of 15 heads that the page drew left 0.15 to 0.55, of what is none 0.58 and more. */
const MOST_LEFT = 0.56;
/** What is darker above brows than below by this part of how dark they are is a fringe; so many mm at both edges tell. */
const FRINGE = 0.5;
const EDGE = 3;
/** How high brows are that are looked at first. */
const RAISES = [0.1, 0.3, 0.7, 0.9];
/** Logarithms of what is seen are within these. */
const DARKEST = 2;
/** Below this, light is noise. */
const BLACK = 0.003;

/** @typedef {import('../hair/browform.js').BrowForm} BrowForm */
/** @typedef {{ corners: Uint32Array, shares: Float32Array }} Places of the head's skin, mixes of three vertices each */

/**
 * Tells the form of brows by what photos show around them.
 * @param {import('../groundwork/groundwork.js').Rest} rest of the head
 * @returns {{ places: Places, told: (albedos: Float32Array) => import('../head/colouring.js').Colouring } | null} null for a model without brows
 */
export function createBrowTeller(rest) {
  const found = browLine(rest.landmarks);
  if (!found) return null;
  const line = found;
  const rows = Math.round((UP - DOWN) / ROW) + 1;
  /** Of each cell, whatever its side. @type {{ x: number, y: number, row: number, w: number }[]} */
  const cells = [];
  for (let i = 0; i < COLUMNS; i++) {
    const w = ALONG[0] + ((ALONG[1] - ALONG[0]) * i) / (COLUMNS - 1);
    for (let j = 0; j < rows; j++) {
      const row = DOWN + j * ROW;
      cells.push({ x: line.outer - line.length * w, y: heightOf(line, w) + row, row, w });
    }
  }
  const [corners, shares] = [new Uint32Array(6 * cells.length), new Float32Array(6 * cells.length)];
  const reliefs = browLines(rest.landmarks).map((one) => reliefAround(one, rest));
  cells.forEach(({ x, y }, n) => {
    [-1, 1].forEach((side, k) => {
      const bound = reliefs[k].bind(side * x, y);
      // A place beside the head is a mix of nothing, which nobody sees.
      if (!bound) return;
      corners.set(bound.corners, 3 * (2 * n + k));
      shares.set(bound.weights, 3 * (2 * n + k));
    });
  });
  const own = densityOf(rest, line);

  /** Where hair is in a form, in each cell. @param {BrowForm} form */
  function predicted(form) {
    const moves = movesOf(form, line);
    return cells.map(({ x, y }) => {
      const [w, off] = unmovedBrow(line, moves, x, y);
      return own(w, off);
    });
  }

  return {
    /** Where the photo's albedo is asked. @type {Places} */
    places: { corners, shares },
    /**
     * @param {Float32Array} albedos four numbers a place: linear light, and how well it is seen
     * @returns {import('../head/colouring.js').Colouring} nothing where too little is seen
     */
    told(albedos) {
      const weights = new Float64Array(cells.length);
      const dark = cells.map((_, n) => {
        let [sum, all] = [0, 0];
        for (const k of [0, 1]) {
          const o = 4 * (2 * n + k);
          const sight = albedos[o + 3];
          if (!(sight > 0)) continue;
          sum -= sight * Math.log(Math.max(BLACK, brightnessOf([...albedos.subarray(o, o + 3)])));
          all += sight;
        }
        weights[n] = Math.min(1, all);
        return all > 0 ? sum / all : 0;
      });
      if (weights.reduce((sum, weight) => sum + weight, 0) < FEWEST * cells.length) return {};
      // How dark skin usually is there.
      const usual = dark.filter((_, n) => weights[n] > 0).sort((a, b) => a - b);
      const skin = usual[usual.length >> 1];
      for (const n of dark.keys()) dark[n] = Math.min(DARKEST, Math.max(-DARKEST, dark[n] - skin));
      /** What a form leaves unexplained, as a part of all that varies. @param {number[]} values */
      const cost = (values) => {
        const form = formOf(values);
        const { left, strength } = explained(dark, weights, predicted(form), cells);
        return { left, strength, cost: left + USUAL * values.reduce((sum, value) => sum + (2 * value - 1) ** 2, 0) };
      };
      let best = { values: BROW_FORM.map(() => 0.5), ...cost(BROW_FORM.map(() => 0.5)) };
      // Where nothing of them overlaps no step is better than another.
      for (const raise of RAISES) {
        const values = BROW_FORM.map((name) => (name === 'browRaise' ? raise : 0.5));
        const here = cost(values);
        if (here.cost < best.cost) best = { values, ...here };
      }
      for (const step of [0.2, 0.1, 0.05, 0.02]) {
        for (let moved = true; moved; ) {
          moved = false;
          for (const i of BROW_FORM.keys()) {
            for (const by of [-step, step]) {
              const values = [...best.values];
              values[i] = Math.min(1, Math.max(0, values[i] + by));
              const here = cost(values);
              if (here.cost < best.cost - 1e-9) {
                best = { values, ...here };
                moved = true;
              }
            }
          }
        }
      }
      if (best.strength < FAINT || best.left > MOST_LEFT) return {};
      const mean = (/** @type {(row: number) => boolean} */ is) => {
        const [sum, all] = cells.reduce(([sum, all], { row }, n) => (is(row) ? [sum + weights[n] * dark[n], all + weights[n]] : [sum, all]), [0, 0]);
        return all > 0 ? sum / all : 0;
      };
      if (mean((row) => row > UP - EDGE) - mean((row) => row < DOWN + EDGE) > FRINGE * best.strength) return {};
      return Object.fromEntries(BROW_FORM.map((name, i) => [name, best.values[i]]));
    },
  };
}

/** @param {number[]} values in the order of the sliders @returns {BrowForm} */
const formOf = ([breadth, arch, slant, apart, raise]) => ({ breadth, arch, slant, apart, raise });

/**
 * How dense the model's own brows are at a share of the line's length from its outer end and so many mm above it; 1 where they are densest.
 * @param {import('../groundwork/groundwork.js').Rest} rest @param {import('../hair/browform.js').BrowLine} line
 */
function densityOf(rest, line) {
  const [from, low] = FROM;
  const [wide, high] = CELL.map((cell, k) => Math.ceil((TO[k] - FROM[k]) / cell));
  let grid = new Float64Array(wide * high);
  growBrows(browLines(rest.landmarks), HAIRS, chance(37), ({ x, y, dx, dy }) => {
    for (let s = 0.1; s < 1; s += 0.2) {
      const [px, py] = [x + dx * s, y + dy * s * (1 - 0.28 * s)];
      const w = (line.outer - Math.abs(px)) / line.length;
      const [i, j] = [Math.round((w - from) / CELL[0]), Math.round((py - heightOf(line, w) - low) / CELL[1])];
      if (i >= 0 && j >= 0 && i < wide && j < high) grid[j * wide + i]++;
    }
  });
  for (let round = 0; round < 2; round++) {
    grid = blurred(grid, wide, 1, BLUR[0]);
    grid = blurred(grid, wide, wide, BLUR[1]);
  }
  const most = grid.reduce((a, b) => Math.max(a, b), 0) || 1;
  return (/** @type {number} */ w, /** @type {number} */ off) => {
    const [u, v] = [(w - from) / CELL[0], (off - low) / CELL[1]];
    const [i, j] = [Math.floor(u), Math.floor(v)];
    if (!(i >= 0 && j >= 0 && i < wide - 1 && j < high - 1)) return 0;
    const at = (/** @type {number} */ a, /** @type {number} */ b) => grid[(j + b) * wide + i + a];
    const [p, q] = [u - i, v - j];
    return ((at(0, 0) * (1 - p) + at(1, 0) * p) * (1 - q) + (at(0, 1) * (1 - p) + at(1, 1) * p) * q) / most;
  };
}

/** Means over so many cells to both sides, along one axis. @param {Float64Array} grid @param {number} wide @param {number} stride @param {number} reach */
function blurred(grid, wide, stride, reach) {
  return grid.map((_, n) => {
    let sum = 0;
    for (let k = -reach; k <= reach; k++) {
      const at = n + k * stride;
      const isSameRow = stride > 1 || Math.floor(at / wide) === Math.floor(n / wide);
      if (at >= 0 && at < grid.length && isSameRow) sum += grid[at];
    }
    return sum / (2 * reach + 1);
  });
}

/**
 * How well what is seen is so much of a prediction on skin that gets darker evenly in some direction: what is left of what varies, and how
 * much darker brows are.
 * @param {number[]} seen @param {Float64Array} weights @param {number[]} prediction @param {{ row: number, w: number }[]} cells
 */
function explained(seen, weights, prediction, cells) {
  // Weighted least squares; skin first, so that what it leaves is what brows have to tell.
  const columns = [() => 1, (/** @type {number} */ n) => cells[n].row / UP, (/** @type {number} */ n) => cells[n].w, (/** @type {number} */ n) => prediction[n]];
  const basis = columns.map((column) => seen.map((_, n) => column(n)));
  const dot = (/** @type {ArrayLike<number>} */ a, /** @type {ArrayLike<number>} */ b) => {
    let sum = 0;
    for (let n = 0; n < weights.length; n++) sum += weights[n] * a[n] * b[n];
    return sum;
  };
  let rest = seen;
  let all = 0;
  let strength = 0;
  basis.forEach((own, i) => {
    for (const other of basis.slice(0, i)) {
      const part = dot(own, other) / (dot(other, other) || 1);
      for (let n = 0; n < own.length; n++) own[n] -= part * other[n];
    }
    const part = dot(rest, own) / (dot(own, own) || 1);
    if (i === basis.length - 1) {
      all = dot(rest, rest);
      strength = part;
      // Brows are not fairer than skin.
      if (part < 0) return;
    }
    rest = rest.map((value, n) => value - part * own[n]);
  });
  return { left: dot(rest, rest) / (all || 1), strength };
}
