import { Color } from 'three';
import { BROW_FORM, REST, valueIn, whole } from './colouring.js';

// Skin. Light crosses the epidermis twice, and melanin takes from it by its absorption, 6.6e11 nm^-3.33 per cm
// of pure melanosomes (S. Jacques, "Optical properties of biological tissues", 2013), of which they fill 1.3 % in the
// fairest and 43 % in the deepest skin. Red, green and blue are taken at 610, 550 and 465 nm.
// Skin turns less brown with it than that says, since light also finds ways between melanosomes: blue is taken
// as the eye finds it right.
const MELANIN = [350, 460, 640];
/** There and back, cm. */
const EPIDERMIS = 2 * 0.008;
const FAIREST = 0.013;
const DEEPEST = 0.43;
/** What the surface and the melanin itself send back at once, whatever is below. */
const SURFACE = 0.018;
// By the square, so that a step is about as much darker anywhere.
const melanin = (/** @type {number} */ skin) => FAIREST + (DEEPEST - FAIREST) * skin ** 2;
/** What is left of the light from one end of its slider to the other: blood takes green and blue. */
const BLOOD = [0.97, 0.68, 0.66];

/** What is left where it is drawn: the skin's colour is seen through a little blood everywhere. */
export const THROUGH_BLOOD = [0.97, 0.875, 0.81];

/** What lips have of the skin's colour at rest, and what both ends have of that. */
const LIPS = [0.68, 0.37, 0.5];
/** How much less of that on the darkest skin: lips have melanin as well, and blood below it shows less, or they would be maroon. */
const BROWNED = [-0.1, 0.4, 0.95];
const PALE = [1.2, 1.75, 1.4];
const PAINTED = [0.87, 0.165, 0.19];
/** How much of the skin shows through lips at rest, and through paler ones. */
const UNPAINTED = 0.34;

/** @typedef {readonly [place: number, ...Color[]]} Stop */
/** @param {[number, ...string[]]} stop in sRGB @returns {Stop} */
const stop = ([place, ...colours]) => [place, ...colours.map((colour) => new Color(colour))];
/** Hair, from fair to black. */
const HAIR = [stop([0, '#b99a68']), stop([0.35, '#7a5c3b']), stop([REST.hair, '#2e1f17']), stop([1, '#0d0a09'])];
const RED = new Color('#8f3f19');
const GREY = new Color('#a3a09b');
/** Brows turn grey later than the head, hair by hair, and keep dark ones. */
const BROWS_GREY = 0.58;
/** So far from rest hairs carry brows, of any of these sliders. */
const BROWED = 0.06;
const BROWS = ['brows', ...BROW_FORM];
/** Lashes at rest, as the screen shows them. They follow brows by less: they are paler only at their ends. */
const LASHES = [0.075, 0.045, 0.035];
const FOLLOWS = 0.45;

/** Hair of this length and longer is as dense as it can be. */
const SHORTEST = 0.025;

/** Irises without melanin are blue, with a little of it green and hazel: near the pupil and around it. */
const IRIS = [
  stop([0, '#687074', '#51606f']),
  stop([0.22, '#70746a', '#586669']),
  stop([0.38, '#6f6240', '#575f49']),
  stop([0.52, '#74532a', '#565334']),
  stop([REST.iris, '#6b4a2a', '#57452e']),
  stop([1, '#33200f', '#22150c']),
];

/**
 * @param {readonly Stop[]} stops @param {number} at @param {number} column
 * @returns {Color}
 */
function between(stops, at, column) {
  const next = Math.max(1, stops.findIndex(([place]) => place >= at));
  const [from, to] = [stops[next - 1], stops[next]];
  const [one, other] = /** @type {Color[]} */ ([from[column], to[column]]);
  return one.clone().lerp(other, (at - from[0]) / (to[0] - from[0]));
}

/**
 * The colour of hair, linear.
 * @param {number} hair @param {number} red @param {number} grey
 */
export function hairColour(hair, red, grey) {
  return between(HAIR, hair, 1).lerp(RED.clone().multiplyScalar(0.35 + 1.3 * (1 - hair)), 0.85 * red).lerp(GREY, 0.9 * grey);
}

/**
 * The colour of skin, linear.
 * @param {Color} tone of the skin at rest @param {number} skin @param {number} blood
 */
export function skinColour(tone, skin, blood) {
  const more = melanin(skin) - melanin(REST.skin);
  const [r, g, b] = [tone.r, tone.g, tone.b].map((under, k) => {
    const through = SURFACE + (under - SURFACE) * Math.exp(-more * MELANIN[k] * EPIDERMIS);
    return Math.min(0.92, through * BLOOD[k] ** (blood - REST.blood));
  });
  return new Color(r, g, b);
}

/**
 * What grows in a beard, or in brows, may be lighter or darker, redder or greyer than the hair on the head: in the middle it is as that
 * is, and at the ends as none is and as all is.
 * @param {number} own the hair's @param {number} beside where the slider is
 */
export const besideOf = (own, beside) => (beside < 0.5 ? 2 * beside * own : own + (2 * beside - 1) * (1 - own));
/** The other way: where the slider of what grows there is. @param {number} own the hair's @param {number} theirs */
export function asideOf(own, theirs) {
  if (theirs === own) return 0.5;
  return theirs < own ? theirs / own / 2 : 0.5 + (theirs - own) / (1 - own) / 2;
}

/**
 * The colours of hairs, of which so many have turned grey.
 * @param {number} hair @param {number} red @param {number} turned
 */
function tones(hair, red, turned) {
  const [young, old] = [hairColour(hair, red, 0), hairColour(hair, red, 1)];
  /** Those that have not turned grey, those that have, how many have, and all together. */
  return { young, old, turned, all: young.clone().lerp(old, turned) };
}

/** How bright skin is beside that at rest, to the eye; 1 at most. @param {Color} tone at rest @param {Color} skin */
const brightness = (tone, skin) => Math.min(1, Math.sqrt((skin.g + 0.01) / (tone.g + 0.01)));

/** The colours of an iris, linear. @param {number} iris */
export const irisColours = (iris) => ({ inner: between(IRIS, iris, 1), outer: between(IRIS, iris, 2) });

/**
 * The colours to paint with, linear.
 * @param {Color} tone of the skin at rest
 * @param {import('./colouring.js').Colouring} colouring
 */
export function pigments(tone, colouring) {
  const { skin, blood, lips, brows, hair, red, grey, iris, crop, beard, length, comb, parting, curl, lines, freckles, beardLength, thin, beardThin, hairline, moustache, chinBeard, cheekBeard, browBreadth, browArch, browSlant, browApart, browRaise, beardShade, beardRed, beardGrey, browShade, browGrey } =
    whole(colouring);
  const own = skinColour(tone, skin, blood);
  // Pale lips have no more blood than the skin; full ones are painted.
  const [most, factors] = lips < REST.lips ? [REST.lips, PALE] : [1 - REST.lips, PAINTED];
  const far = Math.abs(lips - REST.lips) / most;
  const dark = 1 - brightness(tone, skinColour(tone, skin, REST.blood));
  const [lipRed, lipGreen, lipBlue] = LIPS.map((factor, k) => factor ** (1 - BROWNED[k] * dark) * factors[k] ** far);
  const grown = {
    hair: tones(hair, red, grey),
    beard: tones(besideOf(hair, beardShade), besideOf(red, beardRed), besideOf(grey, beardGrey)),
    brows: tones(besideOf(hair, browShade), red, besideOf(BROWS_GREY * grey, browGrey)),
  };
  // Lashes are as brows are, but go on with the hair where those keep dark ones.
  const atRest = between(HAIR, REST.hair, 1);
  const { all: strands } = tones(besideOf(hair, browShade), red, besideOf(grey, browGrey));
  const [lr, lg, lb] = [strands.r / atRest.r, strands.g / atRest.g, strands.b / atRest.b].map((ratio, k) => LASHES[k] * ratio ** FOLLOWS);
  // What has length is as dense as it can be, but for what is thinned.
  const dense = Math.max(crop, (1 - thin) * Math.min(1, length / SHORTEST));
  return {
    skin: own,
    /** How much darker than at rest, for what lies on the skin: 1 at rest. */
    bright: brightness(tone, own),
    /** How much of the skin their colour covers: some shows through lips that are not painted. */
    lipCover: lips > REST.lips ? 1 - UNPAINTED * (1 - far) : 1 - UNPAINTED,
    lips: own.clone().multiply(new Color(lipRed, lipGreen, lipBlue)),
    /** Of what grows, by where. */
    grown,
    lashes: new Color(lr, lg, lb),
    /** 0 is none, 2 twice as many as at rest. */
    bushy: 2 * brows,
    /** How far hairs stand on what is painted of brows: at rest they are as on the head that shows first, which is paint alone. */
    browed: Math.min(1, Math.max(...BROWS.map((name) => Math.abs(valueIn(colouring, name) - REST[name]))) / BROWED),
    browForm: { length: 1, curl: 0, breadth: browBreadth, arch: browArch, slant: browSlant, apart: browApart, raise: browRaise },
    /** How dense hair and beard are, 0 to 1. @type {[number, number]} */
    dense: [dense, Math.max(beard, 0.8 * (1 - beardThin) * Math.min(1, 8 * beardLength))],
    /** How far off the skin a crop's surface is, mm: below strands, where there are some. */
    lift: 3.5 * crop * Math.max(0, 1 - length / SHORTEST) + dense * Math.min(1, 12 * length),
    /** How many of the strands that have length there are, 0 to 1. @type {[number, number]} */
    standing: [Math.max(crop, 1 - thin), Math.min(1, Math.max(beard, 1 - beardThin) / 0.8)],
    /** How much of each part has gone, as `parts.js` has them: of a beard, and as far as hair recedes. @type {[number, number, number, number]} */
    gone: [1 - moustache, 1 - chinBeard, 1 - cheekBeard, 0.83 * hairline],
    lines,
    freckles,
    style: { length, comb, parting, curl },
    whiskers: { length: beardLength, curl: 0.35 + 0.4 * curl },
    iris: irisColours(iris),
  };
}
