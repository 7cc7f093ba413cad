import { Failure } from '../frame/failure.js';
import { stepOf } from '../frame/keys.js';
import { sameWeights } from '../editing/history.js';
import { atRest } from '../head/head.js';
import { text } from '../text.js';
import { MOST_PHOTOS, besides, createAlbum, fitOn, inWholePerCents, seenIn, shotOf } from './album.js';
import { createTeller } from './albedotold.js';
import { createChoice } from './choose.js';
import { createColours } from './colours.js';
import { createComparison } from './compare.js';
import { createControls } from './controls.js';
import { createCorrection } from './correct.js';
import { EXAMPLE, fetchExample } from './example.js';
import { findFaces, findPerson, prepareFinding, stopFinding } from './faces.js';
import { Cancelled, Over, createFitter } from './fitter.js';
import { createFollowing } from './follow.js';
import { colouringOf, glassesOf } from './looks.js';
import { createPlacing } from './place.js';
import { marksOf } from './detected.js';
import { INNER_FROM, around, boxOf, meanPoints } from './points.js';
import { createQueue } from './queue.js';
import { readPhoto } from './read.js';
import { savePhoto } from './save.js';
import { pictureOf, shownOf } from './shown.js';
import { createSides } from './sides.js';
import { standOnFace } from './stand.js';
import { createView } from './view.js';
import { createWarp } from './warp.js';

/** A face lower than this, px of the photo from brow to chin, has too few pixels to be told by. */
const LEAST_FACE = 40;

/** One that looks so much more into the camera, of a cosine, tells the looks better: from the side half of a face is seen. */
const MORE_FRONTAL = 0.04;

/** @typedef {import('./controls.js').Mode} Mode */

/**
 * The room for photos: a portrait becomes a face, and whatever is done to the face happens to the
 * portrait. Nothing of it leaves the page.
 *
 * @param {import('../editing/editor.js').Editor} editor
 * @param {{
 *   panel: HTMLElement,
 *   stage: HTMLElement,
 *   files: { modelUrl: URL, expressionsUrl: URL | null },
 *   expressions: { any: boolean, load: () => Promise<void> },
 *   display: import('../stage/display.js').Display,
 *   sleep: (asleep: boolean) => void,
 *   tone: import('three').Color,
 *   wear: (colours: import('./colours.js').Colours | null) => void,
 * }} parts `panel` takes the controls; what `display` shows the photo does, too; `sleep` stops the drawing of the head while it is covered; `wear` gives it
 *   the photo's colours, or its own
 */
export function createRoom(editor, { panel, stage, files, expressions, display, sleep, tone, wear }) {
  const { model, face } = editor;
  const fitter = createFitter(files, toolsLost);
  /** Made for the first photo. @type {ReturnType<typeof createTeller> | undefined} */
  let madeTeller;
  function teller() {
    if (madeTeller) return madeTeller;
    const median = model.face();
    try {
      return (madeTeller = createTeller(atRest(model, median)));
    } finally {
      median.free();
    }
  }

  /** @type {import('./read.js').Photo | null} */
  let photo = null;
  /** @type {ImageBitmap | null} */
  let onStage = null;
  /** The detector's points of each, px of the photo. @type {Float32Array[]} */
  let faces = [];
  /** Who stands around the points of the last fit, `undefined` before it was asked. @type {import('./faces.js').Person | null | undefined} */
  let person;
  /** The 68 points that were found, px of the photo. @type {ReturnType<typeof marksOf> | null} */
  let detected = null;
  /** What was fitted, to which points, as the photo has it. @type {{ fit: import('phiz').PhotoFit, points: Float64Array, pixels: ReturnType<typeof fitter.pixels> } | null} */
  let fitted = null;
  /** The looks that the head has as it is in the photo. @type {import('../head/colouring.js').Colouring} */
  let colouring = {};
  /** The number of the person in the photo, by which the history knows whose face it is. */
  let number = 0;
  /** How many there were: none has the number of another. */
  let people = 0;
  /** The person's own face, as the fit had it. @type {{ code: string, expression: Record<string, number> } | null} */
  let own = null;
  /** Other photos of this person. @type {import('./album.js').Portrait[]} */
  let others = [];
  /** Where among them the one on the stage stands. */
  let place = 0;
  /** Pictures that are to be closed once nobody has them. @type {Set<ImageBitmap>} */
  let held = new Set();
  /** What the face that is shown changes. @type {import('./warp.js').Field | null} */
  let field = null;
  let editable = false;
  /** Whether the head has the looks of this person. */
  let dressed = false;
  /** How far the photo that told them looks into the camera: a cosine. */
  let toldBy = 0;
  /**
   * The last photo whose face was fitted, with all that belongs to it, until another's is: who opens a photo that
   * cannot be taken still has this one.
   * @type {ReturnType<typeof present> | null}
   */
  let last = null;
  /** Each photo that is opened is a visit: what comes late for an earlier one is dropped. */
  let visit = 0;
  /** Files that began to be read: one that comes late is dropped. */
  let begun = 0;
  /** What was being done when the present file began to be read, which goes on if it is no photo. @type {Mode | null} */
  let beside = null;
  /** What was wrong with a file that came while a face was fitted, until that is done. */
  let unread = '';
  /** @type {Mode} */
  let mode = 'empty';
  /** Where a step back leads. @type {Mode} */
  let before = 'empty';
  /** Where points were moved before something was begun that can be stopped: they are there again then. @type {'place' | 'adjust' | null} */
  let moving = null;
  /** Whether what edits the photo has another fit than `fitted`, or was ended with one that was stopped. */
  let unedited = false;
  /** Whether somebody placed or moved points of this photo since it was fitted: they are still there for who leaves them. */
  let byHand = false;

  // The stage.
  const comparison = createComparison({ changed: draw, allowed: () => mode === 'ready' });
  const view = createView({ hold: comparison.hold });
  const warp = createWarp(view.canvas);
  const choice = createChoice(view, (i) => void take(i));
  const correction = createCorrection(view, {
    changed() {
      byHand = true;
      controls.again.disabled = false;
      controls.takeBack.disabled = !correction.canUndo;
    },
    leave: () => (controls.again.disabled ? controls.leaving : controls.again).focus(),
  });
  const placing = createPlacing(view, { changed: (points) => correction.open(photo, points) });
  const sides = createSides(turn);
  view.root.append(comparison.beforeAfter);
  // Over the head, under the buttons that stand on the stage.
  stage.querySelector('canvas')?.after(view.root, sides.root);

  const colours = createColours({
    fitter,
    detail: () => photo && fitted && fitter.detail(photo, fitted.points),
    tone,
    colouring: () => colouring,
    // Who draws somebody else has somebody else's skin.
    allowed: () => (editable || last !== null) && editor.photo === number,
    wear,
    complain: (sentence) => say(sentence, true),
  });

  const queue = createQueue({ open: (file, same) => open(file, file.name, same), say: (sentence, wrong) => say(sentence, wrong) });
  const album = createAlbum({ choose: (i) => void bringForward(i), takeAway: (i) => void takeAway(i) });

  const controls = createControls(panel, {
    open: (files) => void openAll(files),
    example: () => {
      queue.forget();
      void open(fetchExample, EXAMPLE);
    },
    cancel,
    retry: () => void search((visit += 1)),
    place: startPlacing,
    fit: () => void fit(correction.points),
    pointByPoint: () => {
      before = 'none';
      // Nothing was fitted to them yet.
      controls.again.disabled = false;
      show('adjust');
      correction.focus();
    },
    asDetected: () => {
      if (detected) correction.replace(detected.points);
    },
    takeBack() {
      correction.undo();
      // What is disabled has no focus, and keys would be the face's.
      if (!correction.canUndo) controls.leaving.focus();
    },
    leave: leaveAdjusting,
    correct: startAdjusting,
    more: (files) => void openAll(files, true),
    another: () => {
      // This one is still there for who changes their mind.
      keepLast();
      say(text.photo.several(faces.length));
      view.fit();
      showFaces();
    },
    close,
    own: () => own && editor.take(own, number),
    keep: (type) => void keep(type),
    last: () => void bringBack(text.photo.ready),
    change: [comparison.strengthSlider, comparison.button],
    colours: colours.root,
    album: album.root,
  });
  const { say } = controls;

  /** @param {Mode} next */
  function show(next) {
    if (next === 'busy') moving ??= mode === 'place' || mode === 'adjust' ? mode : null;
    else {
      moving = null;
      unread = '';
    }
    mode = next;
    const focused = document.activeElement;
    controls.show(mode, { photo: photo !== null, detected: detected !== null, several: faces.length > 1, last: last !== null, full: others.length + 1 >= MOST_PHOTOS });
    if (mode === 'ready' && photo && fitted) album.show(amongOthers({ photo, points: fitted.points }), place);
    sides.root.hidden = photo === null;
    choice.show(mode === 'choose');
    placing.show(mode === 'place');
    const points = mode === 'place' || mode === 'adjust';
    correction.show(points, mode === 'place');
    controls.takeBack.disabled = !correction.canUndo;
    correction.compare(mode === 'adjust' ? fittedPoints() : null);
    comparison.beforeAfter.hidden = mode !== 'ready' || !editable;
    if (mode === 'choose' || points) sides.turnTo('photo');
    turn();
    draw();
    // Who goes by keys goes on from what came for it.
    if (focused?.closest('[hidden]') && (panel.contains(focused) || view.root.contains(focused))) controls.focus(mode);
  }
  function turn() {
    const covered = photo !== null && sides.onPhoto;
    view.root.hidden = !covered;
    stage.classList.toggle('has-photo', photo !== null);
    stage.classList.toggle('shows-photo', covered);
    sleep(covered);
    dress();
  }
  function dress() {
    colours.offer();
    if (!photo || !sides.onPhoto) void colours.dress();
  }
  function draw() {
    if (!photo) return;
    const { held, strength, split } = comparison;
    const scale = shownOf(photo) * (fitted?.pixels.scale ?? 1);
    const changed = mode === 'ready' && !held ? field : null;
    warp.draw(changed, { strength, split: changed && split, scale });
    view.split(mode === 'ready' && !held ? split : null);
    if (warp.lost) say(text.lostContext, true);
  }
  const following = createFollowing({
    ask: () => fitter.field(display.shown),
    take(next) {
      field = next;
      draw();
    },
    failed: sayNotEdited,
    wanted: () => editable,
    // Another photo may have come, which asks for itself.
    turn: () => visit,
  });
  /** @returns {Promise<void>} until the photo is changed as the face is */
  async function follow() {
    controls.back.disabled = !own || (own.code === face.code && sameWeights(own.expression, face.expression));
    if (editable) await following.changed();
  }
  editor.onShape(() => {
    // Who goes on with this photo has read what was wrong with another.
    if (mode === 'ready' && controls.isWrong) say(text.photo.ready);
    void follow();
  });
  editor.onStep(dress);
  display.onShow(() => void follow());
  // While points are moved a step back is one of theirs.
  for (const part of [panel, view.root]) {
    part.addEventListener('keydown', (event) => {
      const step = mode === 'adjust' && stepOf(event);
      if (!step) return;
      event.preventDefault();
      correction[step]();
    });
  }

  /** Points of the fitted face, px of the photo. */
  function fittedPoints() {
    if (!fitted) return null;
    const { points, fit, pixels } = fitted;
    return points.map((value, i) => value + pixels.scale * fit.residuals[i >> 1][i % 2]);
  }

  /** The photo is seen as it was, until another fit. @param {string} why */
  function toolsLost(why) {
    unedited = true;
    if (!editable) return;
    editable = false;
    field = null;
    say(text.photo.notEdited(why), true);
    show(mode);
  }
  /** Nobody waits any more for what goes on. */
  function stop() {
    visit += 1;
    begun += 1;
    beside = null;
    stopFinding();
    fitter.cancel();
  }
  function cancel() {
    stop();
    queue.forget();
    editable = false;
    field = null;
    unedited = true;
    if (moving) {
      say(text.photo.cancelled);
      return show(moving);
    }
    keepLast();
    if (last) return void bringBack(text.photo.cancelled);
    say(text.photo.cancelled);
    show(photo ? 'none' : 'empty');
  }
  const present = () => ({ photo, onStage, faces, person, detected, fitted, colouring, toldBy, number, own, others, place, moved: byHand ? correction.points : null });
  function keepLast() {
    if (fitted) last = present();
  }
  /** Closes pictures that nobody has any more. */
  function settle() {
    const now = new Set(
      [{ photo, onStage, person, others }, ...(last ? [last] : [])].flatMap((of) =>
        [of.onStage, ...[of, ...of.others].flatMap((one) => [one.photo?.bitmap, one.person?.mask])].flatMap((picture) => picture ?? []),
      ),
    );
    for (const picture of held) if (!now.has(picture)) picture.close();
    held = now;
  }
  /** There is no photo any more; the face stays. */
  function close() {
    const wore = colours.worn;
    stop();
    queue.forget();
    editable = dressed = false;
    warp.clear();
    photo = onStage = person = detected = fitted = own = field = last = null;
    faces = [];
    others = [];
    number = 0;
    settle();
    colours.forget();
    say(wore ? text.photo.closed : '');
    show('empty');
    controls.focus('empty');
  }
  /** The last photo is there again as it was. @param {string} sentence why @param {boolean} [wrong] */
  async function bringBack(sentence, wrong = false) {
    if (!last) return;
    stopFinding();
    const { moved } = last;
    ({ photo, onStage, faces, person, detected, fitted, colouring, toldBy, number, own, others, place } = last);
    last = null;
    settle();
    // Nor is anything added to somebody else.
    if (queue.person !== number) queue.forget();
    await stand(moved, sentence, wrong);
  }
  /** The photo is one that was fitted: the stage shows it, and it can be changed. @param {Float64Array | null} moved points @param {string} sentence @param {boolean} [wrong] */
  async function stand(moved, sentence, wrong = false) {
    if (!photo || !onStage || !fitted) return;
    const here = (visit += 1);
    dressed = true;
    editable = false;
    field = null;
    tellQuality();
    layPhoto();
    layPoints(fitted.points);
    if (moved) correction.replace(moved);
    view.closeTo(around(fitted.points, 1));
    queue.say(sentence, wrong);
    controls.progress(null);
    show('busy');
    moving = null;
    unedited = true;
    try {
      // Whoever stopped a fit has stopped what edits, too.
      await fitter.edit(fitted.pixels, fitted.fit, seenIn(others));
      unedited = false;
    } catch (error) {
      if (here === visit && !(error instanceof Cancelled)) sayNotEdited(error);
    }
    if (here !== visit) return;
    // The photo is seen without it, and points can be corrected, which begins anew.
    editable = !unedited;
    await follow();
    if (here !== visit) return;
    show('ready');
    if (queue.goesOn) return queue.next();
    void colours.prepare();
  }

  /** @param {unknown} error */
  function sayNotEdited(error) {
    say(text.photo.notEdited(error instanceof Error ? error.message : String(error)), true);
  }
  /** @param {unknown} error @param {Mode} next */
  function complain(error, next) {
    say(error instanceof Error ? error.message : String(error), true);
    show(next);
  }

  /** @template T @param {T} here of the photo on the stage */
  const amongOthers = (here) => [...others.slice(0, place), here, ...others.slice(place)];
  /** All of this person that are fitted, in their order. @returns {import('./album.js').Portrait[]} */
  function inRow() {
    if (!photo || !fitted) return others;
    const { fit, points, pixels } = fitted;
    const detail = fitter.detail(photo, points) ?? undefined;
    const here = { photo, faces, person: person ?? null, detected, moved: byHand ? correction.points : null, points, pixels, detail, shot: shotOf(fit) };
    return amongOthers(here);
  }
  /** One of them is that of the stage. @param {import('./album.js').Portrait[]} row @param {number} i @returns {Promise<import('./album.js').Portrait | null>} null when something else came in between */
  async function takeOn(row, i) {
    const here = (visit += 1);
    const next = row[i];
    const picture = await pictureOf(next.photo);
    if (here !== visit) {
      picture.close();
      return null;
    }
    editable = false;
    field = null;
    others = row.filter((of) => of !== next);
    place = i;
    ({ photo, faces, person, detected } = next);
    onStage = picture;
    sides.turnTo('photo');
    return next;
  }
  /** Another photo of this person is changed. The face is the same, with what was made of it. @param {number} i in the row */
  async function bringForward(i) {
    if (mode !== 'ready' || i === place || !fitted || !own) return;
    const { fit } = fitted;
    try {
      const next = await takeOn(inRow(), i);
      if (!next) return;
      const { points, pixels, moved } = next;
      fitted = { fit: fitOn(fit, next, others), points, pixels };
      const { expression } = fitted.fit;
      const isOwn = sameWeights(face.expression, own.expression);
      own = { ...own, expression };
      settle();
      // What the person does in a photo is not what somebody wished to see in another.
      if (isOwn && !sameWeights(face.expression, expression)) editor.take({ code: face.code, expression }, number);
      await stand(moved, text.photo.ready);
      album.focus();
    } catch (error) {
      sayNotEdited(error);
    }
  }
  /** The shape is what the others tell. @param {number} i in the row */
  async function takeAway(i) {
    if (mode !== 'ready') return;
    const former = present();
    const row = inRow();
    const stays = row.filter((_, k) => k !== i);
    try {
      const next = await takeOn(stays, Math.min(i < place ? place - 1 : place, stays.length - 1));
      if (!next) return;
      // Who stops the fit has all of them.
      last = former;
      fitted = own = null;
      settle();
      layPhoto();
      layPoints(next.points);
      view.closeTo(around(next.points, 1));
      await fit(next.points);
    } catch (error) {
      sayNotEdited(error);
    }
  }

  /** @param {readonly File[]} files one or more @param {boolean} [same] whether they show the same person as the photo before */
  const openAll = (files, same = false) => (same ? queue.start(files, others.length + 1, number) : queue.start(files));
  /**
   * @param {Blob | (() => Promise<Blob>)} file or how it comes @param {string} name
   * @param {boolean} [same] whether it shows the same person as the photo before
   */
  async function open(file, name, same = false) {
    const mine = (begun += 1);
    beside ??= mode;
    unread = '';
    say(text.photo.reading);
    if (beside !== 'busy') {
      stopFinding();
      prepareFinding();
      controls.progress(null);
      show('busy');
    }
    let next, picture;
    try {
      next = await readPhoto(typeof file === 'function' ? await file() : file, name);
      picture = await pictureOf(next);
    } catch (error) {
      next?.bitmap.close();
      if (mine !== begun) return;
      const from = beside;
      beside = null;
      const sentence = error instanceof Failure ? error.message : text.photo.damaged;
      say(sentence, true);
      // The photo before stays, whole, and where it was; what was being done with it goes on, or is done.
      if (from === 'busy') {
        if (mode === 'busy') unread = sentence;
        return;
      }
      stopFinding();
      show(from);
      queue.say(queue.isOfMany ? text.photo.ofFile(name, sentence) : sentence, true);
      return queue.next();
    }
    if (mine !== begun) {
      picture.close();
      return next.bitmap.close();
    }
    const here = (visit += 1);
    if (beside === 'busy') {
      stopFinding();
      prepareFinding();
    }
    beside = null;
    show('busy');
    moving = null;
    keepLast();
    others = same ? inRow() : [];
    place = others.length;
    dressed = dressed && same;
    onStage = picture;
    photo = next;
    faces = [];
    person = undefined;
    detected = fitted = own = field = null;
    editable = byHand = false;
    settle();
    comparison.reset();
    sides.turnTo('photo');
    layPhoto();
    draw();
    await search(here);
  }

  /** @param {number} here */
  async function search(here) {
    if (!photo) return;
    controls.progress(0);
    controls.retry.hidden = false;
    say(text.photo.searching);
    show('busy');
    // The fit is wanted next; if it cannot be prepared, it says why then.
    fitter.prepare().catch(() => {});
    try {
      faces = await findFaces(photo, (fraction) => here === visit && controls.progress(fraction));
    } catch (error) {
      if (here === visit) complain(error, 'none');
      return;
    }
    if (here !== visit) return;
    if (faces.length === 0) {
      stopFinding();
      controls.retry.hidden = true;
      // Of several the others are gone on with.
      if (queue.goesOn) {
        queue.say(text.photo.ofFile(photo.name, text.photo.noFace), true);
        return queue.person && last ? bringBack(text.photo.ready) : queue.next();
      }
      say(text.photo.none, true);
      return show('none');
    }
    if (faces.length === 1) return take(0);
    say(text.photo.several(faces.length));
    showFaces();
  }
  /** One of several is to be chosen. */
  function showFaces() {
    choice.open(faces);
    show('choose');
    choice.focus();
  }

  /** Somebody in the photo is to be fitted, who may be another. */
  function forgetFit() {
    editable = false;
    // One whom other photos show has their looks.
    dressed = dressed && others.length > 0;
    person = undefined;
    fitted = own = field = null;
    settle();
  }

  /** One of the faces. @param {number} i */
  async function take(i) {
    keepLast();
    forgetFit();
    detected = marksOf(faces[i]);
    layPoints(detected.points);
    await fit(detected.points);
  }

  /** Without a person all of the photo may be one. @param {import('./read.js').Photo} photo @param {Float64Array} points */
  async function lookForPerson(photo, points) {
    controls.progress(null);
    say(text.photo.searchingPerson);
    show('busy');
    try {
      return await findPerson(photo, points);
    } catch {
      return null;
    }
  }

  /** @param {NonNullable<Awaited<ReturnType<typeof fitter.looks>>>} told */
  function wornBy({ looks, albedos, glasses }) {
    const { brows, lips } = albedos ? teller().told(albedos) : { brows: {}, lips: undefined };
    return colouringOf(looks, tone, { ...brows, ...glassesOf(glasses, looks) }, lips);
  }

  /** @param {Float64Array} points px of the photo */
  async function fit(points) {
    if (!photo) return;
    const here = visit;
    const box = boxOf(points);
    const tall = box[3] - box[1];
    if (tall < LEAST_FACE) {
      const sentence = text.photo.faceTooSmall(tall, LEAST_FACE);
      const byHand = mode === 'adjust' || mode === 'place';
      if (!byHand && faces.length > 1) {
        // Others may be larger.
        say(sentence, true);
        return showFaces();
      }
      if (last && !byHand) return bringBack(sentence, true);
      say(sentence, true);
      controls.retry.hidden = true;
      return show(byHand ? mode : 'none');
    }
    const from = mode === 'adjust' || mode === 'place' ? mode : 'none';
    editable = false;
    try {
      if (person === undefined) {
        const found = await lookForPerson(photo, points);
        if (here !== visit) return found?.mask.close();
        person = found;
        settle();
      }
      // What somebody placed is believed more: a jaw as other points are, and these as far as a face has them.
      const [jaw, inner] = [[0, 2 * INNER_FROM], [2 * INNER_FROM]].map(([from, to]) => !points.subarray(from, to).some((value, k) => value !== detected?.points[from + k]));
      const marks = { points, noise: inner ? detected?.noise : undefined, jawNoise: jaw ? detected?.jawNoise : undefined, irises: detected?.irises };
      const pixels = fitter.pixels(photo, marks, person);
      controls.progress(0);
      say(text.photo.fitting);
      show('busy');
      const [found] = await Promise.all([
        fitter.fit({ ...pixels, others: besides(others) }, (part) => here === visit && controls.progress(part)),
        expressions.any ? expressions.load() : undefined,
      ]);
      if (here !== visit) return;
      if (found.quality.refusal) {
        const asked = others.length > 0 ? ` ${text.photo.notTogether(others.length)}` : '';
        say(text.photo.refused(found.quality.refusal) + asked, true);
        before = fitted ? 'ready' : 'none';
        return show(from === 'none' ? 'adjust' : from);
      }
      const base = inWholePerCents(found);
      const { expression } = base;
      const beside = others.map((other, i) => ({ ...other, shot: base.others[i] }));
      unedited = true;
      await fitter.edit(pixels, base, seenIn(beside));
      const facing = Math.cos(found.camera.angles[0]) * Math.cos(found.camera.angles[1]);
      // Who corrects points, or adds a photo, has seen the looks, and may have changed them: if not, one that looks more into the camera
      // tells them anew. Without a light nobody knows them.
      const isToldBetter = others.length > 0 && facing > toldBy + MORE_FRONTAL && sameWeights(editor.colouring, colouring);
      const looks = dressed && !isToldBetter
        ? null
        : await fitter.looks(teller().places, standOnFace(model, found.code)).catch((error) => {
            if (error instanceof Over) throw error;
            return null;
          });
      if (here !== visit) return;
      if (!fitted) number = people += 1;
      editor.take({ code: found.code, expression, ...(looks && { colouring: wornBy(looks) }) }, number);
      own = { code: face.code, expression: face.expression };
      toldBy = looks ? facing : dressed ? toldBy : 0;
      if (!dressed || looks) colouring = editor.colouring;
      others = beside;
      fitted = { fit: { ...base, ...own }, points: points.slice(), pixels };
      unedited = byHand = false;
      last = null;
      settle();
      dressed = true;
      editable = true;
      colours.forget();
      field = null;
      view.closeTo(around(points, 1));
      tellQuality();
      queue.isOf(number);
      queue.say(unread || text.photo.ready, unread !== '');
      show('ready');
      if (queue.goesOn) return queue.next();
      await follow();
      // Whoever turns to the head next need not wait.
      if (here === visit) void colours.prepare();
    } catch (error) {
      if (here !== visit || error instanceof Cancelled) return;
      before = fitted ? 'ready' : 'none';
      // The same points may do another time.
      controls.again.disabled = false;
      complain(new Error(text.photo.notFitted(error instanceof Error ? error.message : String(error))), from === 'none' ? 'adjust' : from);
    }
  }

  /** How well the photo on the stage fits. */
  function tellQuality() {
    if (!fitted) return;
    const { rmsPx, rmsMm } = fitted.fit.quality;
    const sentences = [text.photo.quality(rmsPx * fitted.pixels.scale, rmsMm)];
    if (others.length > 0) sentences.unshift(text.photo.together(others.length + 1));
    if (!person) sentences.push(text.photo.noPerson);
    controls.quality.textContent = sentences.join(' ');
  }

  function startAdjusting() {
    if (!fitted) return;
    before = 'ready';
    controls.again.disabled = !byHand;
    if (!byHand) layPoints(fitted.points);
    view.closeTo(around(fitted.points, 0.18));
    say('');
    show('adjust');
    correction.focus();
  }
  function leaveAdjusting() {
    if (before !== 'ready' || !fitted) {
      // Nobody looks again for faces that were found.
      const isChoice = faces.length > 1;
      if (byHand) say(text.photo.left(text.photo.placeByHand));
      else if (isChoice) say(text.photo.several(faces.length));
      return isChoice ? showFaces() : show('none');
    }
    const sentence = byHand ? text.photo.left(text.photo.correct) : text.photo.ready;
    if (unedited) {
      keepLast();
      return void bringBack(sentence);
    }
    editable = true;
    say(sentence);
    show('ready');
    void follow();
  }
  /** The photo lies on the stage. */
  function layPhoto() {
    if (!photo || !onStage) return;
    controls.size.textContent = text.photo.size(photo.width, photo.height, photo.reduced);
    warp.setPhoto(onStage, photo.colorSpace);
    view.open(photo.width, photo.height);
  }
  /** Points that nobody moved. @param {Float64Array} points px of the photo */
  function layPoints(points) {
    byHand = false;
    correction.open(photo, points);
  }
  function startPlacing() {
    if (!photo) return;
    // Points of somebody who was fitted are that person's.
    const goesOn = byHand && !fitted;
    keepLast();
    forgetFit();
    const { width, height } = photo;
    if (goesOn) placing.take(correction.points);
    else {
      detected = null;
      placing.open(meanPoints(model), width / 2, 0.45 * height, 0.5 * Math.min(width, height));
      byHand = true;
    }
    say('');
    show('place');
    placing.focus();
  }

  /** @param {'image/png' | 'image/jpeg'} type */
  async function keep(type) {
    if (!photo || !fitted) return;
    say(text.exporting);
    // The sentence shows before the work begins.
    await new Promise((painted) => requestAnimationFrame(() => setTimeout(painted)));
    // Nor before the photo is as the face is now.
    await following.done();
    if (!photo || !fitted) return;
    try {
      const changed = field;
      const options = { strength: comparison.strength, scale: fitted.pixels.scale };
      const change = changed && options.strength > 0 ? (/** @type {OffscreenCanvasRenderingContext2D} */ context) => warp.render(context, changed, options) : null;
      const { file, bytes } = await savePhoto(photo, change, type);
      say(text.exported(file, bytes));
    } catch (error) {
      say(text.notExported(error instanceof Error ? error.message : String(error)), true);
    }
  }

  show('empty');
  return {
    openAll,
    /** What is wanted is on the head. */
    reveal: () => sides.turnTo('head'),
    /** The head has what it is to wear, for who shows it elsewhere than on the stage. */
    dress: colours.dress,
    /** For automation. */
    get state() {
      return {
        mode,
        width: photo?.width ?? 0,
        height: photo?.height ?? 0,
        faces,
        points: photo ? correction.points : null,
        fitted: fittedPoints(),
        fit: fitted?.fit ?? null,
        person: person ?? null,
        field,
        worn: colours.worn,
      };
    },
  };
}
