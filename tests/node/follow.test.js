import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Cancelled } from '../../www/src/photo/fitter.js';
import { createFollowing } from '../../www/src/photo/follow.js';

/** Something that follows a number, whose answers come when they are given. */
function staged() {
  const state = { now: 0, wanted: true, turn: 0 };
  /** @type {{ of: number, give: (answer: number) => void, fail: (why: unknown) => void }[]} */
  const questions = [];
  /** @type {number[]} */
  const taken = [];
  /** @type {unknown[]} */
  const failures = [];
  const following = createFollowing({
    ask: () => new Promise((give, fail) => questions.push({ of: state.now, give, fail })),
    take: (/** @type {number} */ answer) => taken.push(answer),
    failed: (why) => failures.push(why),
    wanted: () => state.wanted,
    turn: () => state.turn,
  });
  const change = (/** @type {number} */ to) => {
    state.now = to;
    return following.changed();
  };
  return { state, questions, taken, failures, change, following };
}
const soon = () => new Promise((done) => setImmediate(done));

test('what is followed is asked once at a time, and its last state is taken', async () => {
  const { questions, taken, change, following } = staged();
  const first = change(1);
  void change(2);
  void change(3);
  assert.deepEqual(questions.map(({ of }) => of), [1]);
  questions[0].give(1);
  await soon();
  // The second was no more when its turn came.
  assert.deepEqual([questions.map(({ of }) => of), taken], [[1, 3], [1]]);
  let isDone = false;
  void first.then(() => (isDone = true));
  await soon();
  assert.equal(isDone, false, 'it waits for the last');
  questions[1].give(3);
  await first;
  await following.done();
  assert.deepEqual(taken, [1, 3]);
  // And again.
  const later = change(4);
  questions[2].give(4);
  await later;
  assert.deepEqual(taken, [1, 3, 4]);
});

test('answers that nobody wants any more are dropped, and failures told but for what was stopped', async () => {
  const { state, questions, taken, failures, change } = staged();
  const first = change(1);
  state.turn += 1;
  questions[0].give(1);
  await first;
  assert.deepEqual(taken, []);
  const second = change(2);
  questions[1].fail(new Cancelled());
  await second;
  const third = change(3);
  void change(4);
  const why = new Error('no');
  questions[2].fail(why);
  await soon();
  // What came meanwhile is asked all the same.
  questions[3].give(4);
  await third;
  assert.deepEqual([failures, taken], [[why], [4]]);
  const last = change(5);
  state.wanted = false;
  questions[4].give(5);
  await last;
  await change(6);
  assert.deepEqual([questions.length, taken], [5, [4]]);
});
