// Photos that are chosen or dropped at once, which are of one person: each is added when the one before is fitted. What is wrong with some of
// them is said when all are done with.
import { text } from '../text.js';
import { MOST_PHOTOS } from './album.js';

/**
 * @param {{ open: (file: File, same: boolean) => Promise<void>, say: (sentence: string, wrong: boolean) => void }} on `same` is whether
 *   it is added to the photo on the stage
 */
export function createQueue({ open, say }) {
  /** @type {File[]} */
  let files = [];
  /** @type {string[]} */
  let wrong = [];
  /** Whose photos they are, 0 until the first is fitted. */
  let person = 0;

  function forget() {
    files = [];
    wrong = [];
    person = 0;
  }
  return {
    /** Whether more of them are to come. */
    get goesOn() {
      return files.length > 0;
    },
    /** Whether there is more to say than of one alone. */
    get isOfMany() {
      return files.length + wrong.length > 0;
    },
    get person() {
      return person;
    },
    /** @param {readonly File[]} all one or more @param {number} [added] how many of the same person there are, if they are added to those @param {number} [of] who that is */
    start([file, ...more], added = 0, of = 0) {
      const room = MOST_PHOTOS - 1 - added;
      files = more.slice(0, room);
      wrong = more.length > room ? [text.photo.leftOut(MOST_PHOTOS, more.length - room)] : [];
      person = of;
      return open(file, of !== 0);
    },
    async next() {
      const file = files.shift();
      if (file) await open(file, person !== 0);
    },
    /** The first of them, or another, is fitted. @param {number} of */
    isOf(of) {
      person = of;
    },
    /** Says what is wrong with one of several once that of all of them can be read. @param {string} sentence @param {boolean} isWrong */
    say(sentence, isWrong) {
      if (isWrong) wrong.push(sentence);
      if (files.length > 0 || wrong.length === 0) say(sentence, isWrong);
      else say(wrong.splice(0).join(' '), true);
    },
    forget,
  };
}
