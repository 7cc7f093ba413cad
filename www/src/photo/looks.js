import { SPOTTED, frameColour, tintOf } from '../glasses/tint.js';
import { lensesOf, rimOf } from '../glasses/style.js';
import { smoothstep } from '../groundwork/paint.js';
import { REST, readColouring, valueIn } from '../head/colouring.js';
import { sliderOfLength } from '../hair/length.js';
import { scatters } from '../hair/scattered.js';
import { THROUGH_BLOOD, asideOf, hairColour, irisColours, skinColour } from '../head/pigments.js';
import { BLACK, brightnessOf, logarithms } from './light.js';
import { lipsTold } from './liptold.js';

// From what a photo tells of a person's colours and hair to the sliders that look like it.

/** What the skin's pigment looks like where it is lit, over what the photo has: blood, and its exposure. As in the skin's shader. */
const SHOWN = THROUGH_BLOOD.map((part) => 0.8 / part);
/** What hair looks like where it is lit, over its pigment, beside what goes from hair to hair. */
export const HAIR_SHOWN = 1.6;
/** Hair that stands off less is cropped, mm: the fitted head is off by as much. */
const CROPPED = 6;
/** Hair that hangs less beside the face hangs around an ear, mm. */
const AROUND_EARS = 20;
/** From there on hair reaches the shoulders, where nobody sees how much longer it is. */
const TO_SHOULDERS = 90;
/** Longer hair begins so far above the ear, mm. */
const ABOVE_EAR = 35;
/** A fringe covers more than this part of the forehead. */
const FRINGE = 0.35;
/** A fringe that is swept aside covers so much more of one half of the forehead than of the other. */
const SWEPT = 0.4;
/** And its strands lean so much. */
const LEANS = 0.35;
/** From the hairline to the brows, mm, along hair that does not lie flat. */
const FOREHEAD = 48;
/** Stubble is darker than cheeks by the first of these logarithms, a beard by the second. */
const BEARDS = [0.13, 0.4];
/** So much of the skin is behind its hair. */
const BEARD_COVER = 0.93;
/** Its colour is another one than the hair's if it is so far from that: logarithms. Of 8 drawn heads with both of one colour none was told farther apart than 2.2, and those of which one was white are at 3 and more. */
const APART = 2.5;
/** The green of an iris that is dark, and by how much the logarithm of blue is below that of green in one with a hue. */
const DARK_IRIS = 0.05;
const HUELESS = 0.4;
/** Of one that mirrors more, grey, and by how much the logarithms of its red and green are apart. Blue ones have 0.4. */
const GREY_IRIS = 0.09;
const GREY = 0.27;
/** Under brown skin nearly all irises are: from the first of these on the slider of skin on what mirrors may be brighter and bluer, from the second on by this factor. */
const BROWN_SKIN = [0.35, 0.5];
const BROWN_MIRRORS = 2;
/** And others have to be seen better by so much: a square of logarithms. Lids that are taken for a part of the iris make it paler and less blue. */
const BROWN_USUAL = 0.18;
/** Between these an iris on its slider becomes brown. */
const BROWN_IRIS = [0.45, 0.62];

/** @typedef {readonly number[]} Linear red, green and blue */

/**
 * The place on one or more sliders that has the least of something.
 * @param {number[]} steps of each slider
 * @param {(...places: number[]) => number} cost
 */
function least(steps, cost) {
  /** @type {{ places: number[], cost: number }} */
  let best = { places: [], cost: Infinity };
  /** @param {number[]} chosen */
  function search(chosen) {
    if (chosen.length === steps.length) {
      const here = cost(...chosen);
      if (here < best.cost) best = { places: chosen, cost: here };
      return;
    }
    const count = steps[chosen.length];
    for (let i = 0; i <= count; i++) search([...chosen, i / count]);
  }
  search([]);
  return best.places;
}

/** The square of the distance of two colours. @param {number[]} a @param {number[]} b logarithms */
const apart = (a, b) => a.reduce((sum, value, k) => sum + (value - b[k]) ** 2, 0);

/** Red, green and blue that are no farther apart have no hue: logarithms. No light makes skin so. */
const NO_HUE = 0.04;
/** @param {Linear} colour */
const isGrey = (colour) => Math.max(...logarithms(colour)) - Math.min(...logarithms(colour)) < NO_HUE;

/** What cameras leave of the colour of skin beside its brightness: what is guessed should be no sunburn. */
const PALER = 0.65;
/**
 * The colour of skin of which a photo tells no more than how bright it is, as a photo would have it.
 * @param {number} brightness @param {import('three').Color} tone of the head's skin at rest
 */
export function skinAsBright(brightness, tone) {
  const seen = (/** @type {number} */ skin) => {
    const { r, g, b } = skinColour(tone, skin, REST.blood);
    return [r / SHOWN[0], g / SHOWN[1], b / SHOWN[2]];
  };
  const [skin] = least([50], (skin) => Math.abs(brightnessOf(seen(skin)) - brightness));
  return seen(skin).map((value, _, own) => brightnessOf(own) + PALER * (value - brightnessOf(own)));
}

/** @param {Linear} colour @param {import('three').Color} tone */
function skinOf(colour, tone) {
  const wanted = logarithms(colour.map((value, k) => value * SHOWN[k]));
  const [skin, blood] = least([50, 20], (skin, blood) => {
    const own = skinColour(tone, skin, blood);
    // What lamps and cameras do to reds is not blood.
    return apart(wanted, logarithms([own.r, own.g, own.b])) + 0.15 * (blood - REST.blood) ** 2;
  });
  return { skin, blood };
}

/**
 * @param {Linear} colour @param {boolean} colourless of a photo without colours, whose hair may have any
 * @returns {import('../head/colouring.js').Colouring}
 */
function hairOf(colour, colourless) {
  if (colourless) {
    const wanted = brightnessOf(colour);
    const [hair] = least([40], (hair) => {
      const { r, g, b } = hairColour(hair, 0, 0).multiplyScalar(HAIR_SHOWN);
      return Math.abs(scatters([r, g, b]) * brightnessOf([r, g, b]) - wanted);
    });
    return { hair };
  }
  const wanted = logarithms(colour);
  const [hair, red, grey] = least([40, 10, 10], (hair, red, grey) => {
    const own = hairColour(hair, red, grey).multiplyScalar(HAIR_SHOWN);
    own.multiplyScalar(scatters([own.r, own.g, own.b]));
    return apart(wanted, logarithms([own.r, own.g, own.b])) + 0.12 * red + 0.12 * grey;
  });
  return { hair, red, grey };
}

/**
 * Irises are told by their hue: how bright they are is a matter of lids. What is dark and has no hue is most often
 * brown, as at rest, below what it mirrors.
 * @param {Linear} colour @param {number} skin the slider's @returns {import('../head/colouring.js').Colouring}
 */
function irisOf(colour, skin) {
  const hue = (/** @type {number[]} */ [r, g, b]) => [r - g, b - g, 0.3 * g];
  const wanted = hue(logarithms(colour));
  // No blue iris is that dark: what is, and grey or bluish, mirrors the sky.
  const brown = Math.min(1, Math.max(0, (skin - BROWN_SKIN[0]) / (BROWN_SKIN[1] - BROWN_SKIN[0])));
  const more = 1 + brown * (BROWN_MIRRORS - 1);
  const grey = colour[1] < GREY_IRIS * more && Math.abs(wanted[0]) < GREY * more;
  // Blue and green ones are less red than green, and who has brown ones of a clear hue is more so.
  const faint = wanted[0] > 0 && wanted[0] < GREY;
  const dark = colour[1] < DARK_IRIS && (wanted[1] > -HUELESS || faint);
  if (dark || (grey && wanted[1] > -HUELESS)) return {};
  const [iris] = least([50], (iris) => {
    const { inner, outer } = irisColours(iris);
    const other = 1 - smoothstep(BROWN_IRIS[0], BROWN_IRIS[1], iris);
    return apart(wanted, hue(logarithms([(inner.r + outer.r) / 2, (inner.g + outer.g) / 2, (inner.b + outer.b) / 2]))) + BROWN_USUAL * brown * other;
  });
  return { iris };
}

/** What grows in a beard, which is seen with skin between. @param {Linear} beard @param {Linear} skin @returns {Linear} */
const hairOfBeard = (beard, skin) => beard.map((value, k) => Math.max(BLACK, value - (1 - BEARD_COVER) * skin[k]) / BEARD_COVER);

/**
 * What a beard has of another colour than the hair.
 * @param {import('../head/colouring.js').Colouring} hair the hair's sliders @param {import('../head/colouring.js').Colouring} beard what they would be of the beard
 */
function besideHair(hair, beard) {
  const [own, theirs] = [hair, beard].map((colours) => ['hair', 'red', 'grey'].map((name) => valueIn(colours, name)));
  const [a, b] = [own, theirs].map(([hair, red, grey]) => logarithms(hairColour(hair, red, grey).toArray()));
  if (Math.sqrt(apart(a, b)) < APART) return {};
  return Object.fromEntries(['beardShade', 'beardRed', 'beardGrey'].map((name, k) => [name, asideOf(own[k], theirs[k])]));
}

/** @param {import('phiz').PhotoHair} hair @param {boolean} colourless @returns {import('../head/colouring.js').Colouring} */
function styleOf({ colour, cover, off, hangs, forehead, aside, lean }, colourless) {
  const crop = cover > 0.6 ? 0.9 : 0.58;
  const short = off < CROPPED ? 0 : Math.min(66, Math.max(20, 3 * off));
  const mm = hangs > TO_SHOULDERS ? 200 : hangs > AROUND_EARS ? hangs + ABOVE_EAR : short;
  // What covers a forehead is long enough to.
  const length = sliderOfLength(forehead > FRINGE ? Math.max(mm, FOREHEAD * forehead) : mm);
  const comb = forehead > FRINGE ? 0.85 : hangs > AROUND_EARS ? 0.5 : 0.3;
  // It is swept to where it covers more, and where it leans to.
  const swept = Math.max(-1, Math.min(1, aside / SWEPT + lean / LEANS));
  return { ...hairOf(colour, colourless), crop, length, comb, ...(forehead > FRINGE && { parting: 0.5 + 0.5 * swept }) };
}

/** Frames without colours: of silver, of horn, and black. */
const GREY_FRAMES = [0, 0.48, REST.frameColour];
/** Who sees no edges of a rim before a dark lens takes it for a broad one; glass without a rim is held by gold. */
const BEFORE_DARK = 0.68;
const RIMLESS = { lensForm: 0.4, lensSize: 0.55, lensHeight: 0.36, rim: 0, frameColour: 0.14 };
/** Lenses that take no more of the light are clear: what is behind them is a cheek's shadow. Others seem to take less than they do by this factor, as they mirror some. */
const CLEAR = 0.15;
const MIRRORED = 1.15;
/** Rims that are no broader, of the slider, are wires, of metal or lacquered: none is of these colours, which are horn's. */
const WIRE = 0.34;
const HORN = [0.29, 0.55];

/**
 * The glasses of a photo.
 * @param {import('./glassestold.js').Glasses | null} glasses @param {import('phiz').PhotoLooks} looks
 * @returns {import('../head/colouring.js').Colouring}
 */
export function glassesOf(glasses, { skin }) {
  if (!glasses) return {};
  const { form, rim, half, frame, taken } = glasses;
  const tint = taken > CLEAR ? tintOf(MIRRORED * taken) : 0;
  if (!form) return { glasses: 1, ...RIMLESS, tint };
  const broad = rim === null ? BEFORE_DARK : rimOf(rim);
  const steps = (isGrey(skin) ? GREY_FRAMES : Array.from({ length: 101 }, (_, i) => i / 100)).filter((at) => broad > WIRE || at < HORN[0] || at > HORN[1]);
  const wanted = frame && logarithms(frame.map((value, k) => value * skin[k]));
  const far = (/** @type {number} */ at) => {
    const { colour, spots } = frameColour(at);
    return wanted ? apart(wanted, logarithms(colour.lerp(spots, SPOTTED).toArray())) : 0;
  };
  return {
    glasses: 1,
    ...lensesOf(form),
    rim: broad,
    halfRim: half ? 1 : 0,
    ...(wanted && { frameColour: steps.reduce((best, at) => (far(at) < far(best) ? at : best)) }),
    tint,
  };
}

/**
 * The colouring that looks like a person in a photo. What a photo does not tell is at rest.
 * @param {import('phiz').PhotoLooks} looks
 * @param {import('three').Color} tone of the head's skin at rest
 * @param {import('../head/colouring.js').Colouring} [also] the form of brows, and glasses
 * @param {Float32Array} [ofLips] their albedos, as `lipsTold` takes them
 */
export function colouringOf({ skin, irises, beard, beardColour, hair }, tone, also = {}, ofLips) {
  const colourless = isGrey(skin);
  const ofBeard = beardColour && hairOf(hairOfBeard(beardColour, skin), colourless);
  const ofHair = hair ? styleOf(hair, colourless) : { ...ofBeard, crop: 0, length: 0 };
  const own = skinOf(colourless ? skinAsBright(brightnessOf(skin), tone) : skin, tone);
  const lips = ofLips && !colourless ? lipsTold(ofLips, skin, tone, own) : null;
  return readColouring({
    ...own,
    ...also,
    ...(lips !== null && { lips }),
    ...(irises && !colourless && irisOf(irises, own.skin)),
    // Whose hair is not seen, or gone, has some in a beard.
    ...ofHair,
    ...(hair && ofBeard && besideHair(ofHair, ofBeard)),
    ...(beard > BEARDS[1] ? { beard: 0.7, beardLength: 0.08 } : beard > BEARDS[0] ? { beard: 0.3 } : {}),
  });
}
