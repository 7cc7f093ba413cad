import { chance } from '../chance.js';
import { readColouring, REST, whole } from './colouring.js';

/** How deep skin is, where a model tells the shares of a shape by these names. */
const TONES = /** @type {const} */ ({ african: 0.85, asian: 0.4, caucasian: 0.22 });

/** @typedef {Pick<import('phiz').Face, 'model' | 'attribute'>} Labelled */

/**
 * What a model's label says of a face, from 0 to 1; undefined without that label.
 * @param {Labelled} face @param {string} name
 */
export function toldOf(face, name) {
  const attribute = face.model.attributes.find((one) => one.name === name);
  if (!attribute) return undefined;
  const [least, most] = attribute.limits;
  return Math.min(1, Math.max(0, (face.attribute(name) - least) / (most - least)));
}

/**
 * What a model's labels say of a face, each from 0 to 1; what it has no labels for is absent.
 * @param {Labelled} face
 */
export function told(face) {
  const part = (/** @type {string} */ name) => toldOf(face, name);
  const shares = Object.entries(TONES).map(([name, tone]) => ({ name, tone, share: part(name) ?? 0 }));
  const sum = shares.reduce((total, { share }) => total + share, 0);
  return {
    sex: part('sex'),
    age: part('age'),
    tone: sum > 0 ? shares.reduce((total, { tone, share }) => total + tone * share, 0) / sum : undefined,
    caucasian: sum > 0 ? shares[2].share / sum : undefined,
    african: sum > 0 ? shares[0].share / sum : undefined,
  };
}

/** How manly someone is, whom labels tell to be this male. @param {number} sex */
export const manlyOf = (sex) => Math.min(1, Math.max(0, (sex - 0.35) / 0.3));
/** How deep lines are: with the years, and from one to another. @param {number} age @param {number} own both 0 to 1 */
const linesOf = (age, own = 0.5) => Math.max(0, 1.5 * age - 0.65 + 0.4 * own);
/** How far hair is grey at an age, if it is. @param {number} age 0 to 1 */
const greyOf = (age) => Math.max(0, 2 * age - 1);

/**
 * The colours of someone whose shape becomes another's: lines and grey hair come and go with the years, skin gets the depth that goes
 * with the shape, and a beard and a receding hairline go when the face is a man's no longer. All else stays.
 * @param {import('./colouring.js').Colouring} colouring
 * @param {ReturnType<typeof told>} before what labels say of the shape before @param {ReturnType<typeof told>} after and after it
 */
export function coloursAlong(colouring, before, after) {
  const colours = whole(colouring);
  const change = (/** @type {(value: number) => number} */ of, /** @type {number | undefined} */ from, /** @type {number | undefined} */ to) =>
    from === undefined || to === undefined ? 0 : of(to) - of(from);
  const [was, is] = [before.sex, after.sex].map((sex) => (sex === undefined ? 1 : manlyOf(sex)));
  const beard = is < was ? is / was : 1;
  return readColouring({
    ...colouring,
    skin: colours.skin + change((tone) => tone, before.tone, after.tone),
    lines: colours.lines + change(linesOf, before.age, after.age),
    grey: colours.grey + change(greyOf, before.age, after.age),
    beard: colours.beard * beard,
    beardLength: colours.beardLength * beard,
    hairline: colours.hairline * beard,
  });
}

/** Brows have chances of their own: with them or without, someone of a seed has the same colours. */
const BROWS = 0x5b0e;

/**
 * Which form brows have: a man's are rather broad and straight, and a woman's narrow and arched.
 * @param {number} manly 0 to 1 @param {() => number} random
 */
function browsOf(manly, random) {
  const about = (/** @type {number} */ mean, /** @type {number} */ most) => mean + most * (random() + random() - 1);
  return {
    browBreadth: about(0.5 + 0.24 * (manly - 0.5), 0.26),
    browArch: about(0.5 - 0.2 * (manly - 0.5), 0.35),
    browSlant: about(0.5, 0.25),
    browApart: about(0.5, 0.3),
    browRaise: about(0.5 - 0.1 * (manly - 0.5), 0.19),
  };
}

/** So dense a crop is one of hairs, of the slider. */
const DENSE = 0.7;
/** So have what beards and brows have beside the hair. */
const BESIDE = 0xbea2d;

/**
 * What beards and brows have of another colour than the hair: fair hair has darker brows, and often a redder beard, and beards turn grey
 * before the head does.
 * @param {number} fair how fair the hair is @param {number} years how far hair is grey at this age @param {() => number} random
 */
function besides(fair, years, random) {
  const about = (/** @type {number} */ mean, /** @type {number} */ most) => mean + most * (random() + random() - 1);
  return {
    beardShade: about(0.5, 0.12),
    beardRed: 0.5 + 0.4 * fair * random() ** 2,
    beardGrey: years > 0 ? about(0.5 + 0.2 * Math.min(1, 2 * years), 0.15) : 0.5,
    browShade: about(0.52 + 0.2 * fair, 0.08 + 0.1 * fair),
    browGrey: years > 0 ? about(0.5, 0.25) : 0.5,
  };
}

/**
 * Colours that someone of a face may have, the same for a seed: brown eyes and black hair are the most of the
 * world's, and fair hair, red hair and light eyes go with fair skin. What the model's labels say of the face
 * is kept to loosely: people of any shape have many colours.
 *
 * @param {import('phiz').Face} face
 * @param {number} seed
 * @returns {import('./colouring.js').Colouring}
 */
export function someone(face, seed) {
  const random = chance(seed);
  const { sex = 0.5, age = 0.5, tone, caucasian = 1, african = 0.15 } = told(face);
  const skin = tone === undefined ? random() ** 0.8 : Math.min(1, Math.max(0, tone + 0.35 * (random() + random() - 1)));
  const fair = Math.max(0, 1 - skin / 0.55) * Math.min(1, 2 * caucasian);
  const dark = () => 0.8 + 0.2 * random();
  const light = random() < fair;
  const manly = manlyOf(sex);
  const colours = {
    ...browsOf(manly, chance(seed ^ BROWS)),
    skin,
    blood: 0.15 + 0.35 * random(),
    lips: 0.25 + 0.35 * random(),
    brows: 0.3 + 0.5 * random(),
    hair: light ? 0.1 + 0.8 * random() : dark(),
    red: random() < 0.2 * fair ? random() : 0,
    grey: random() < 0.7 * greyOf(age) ? random() : 0,
    iris: random() < fair ? 0.9 * random() : dark(),
    crop: random() < 0.85 ? 0.3 + 0.7 * random() : 0,
    beard: random() < 0.4 * manly ? 0.15 + 0.6 * random() : 0,
    lines: linesOf(age, random()),
    freckles: random() < 0.5 * fair ? random() : 0,
  };
  const own = { ...colours, ...besides(Math.max(0, 1 - colours.hair / REST.hair), greyOf(age), chance(seed ^ BESIDE)) };
  const beardLength = colours.beard > 0.3 && random() < 0.6 ? 0.15 + 0.45 * random() ** 2 : 0;
  if (colours.crop === 0) return readColouring({ ...own, beardLength });
  const long = random() < 0.9 - 0.8 * manly;
  const coiled = random() < 1.4 * african - 0.2;
  return readColouring({
    ...own,
    beardLength,
    // What is dense and cropped has hairs that stand off; what is thin is painted.
    length: long ? 0.5 + 0.5 * random() : random() < 0.75 ? 0.12 + 0.24 * random() : colours.crop > DENSE ? 0.05 : 0,
    comb: 0.75 * random(),
    parting: 0.25 + 0.5 * random(),
    curl: coiled ? 0.7 + 0.3 * random() : 0.6 * random() ** 2,
    // Of men it recedes with the years, some sooner and some never.
    hairline: random() < manly * age ? age * random() : 0,
  });
}
