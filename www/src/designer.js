import { createAbout } from './frame/about.js';
import { createAddress, locksOfTab } from './keep/address.js';
import { decodeColouring, decodeExpression, encodeColouring, joinHash, splitHash } from './keep/addresscode.js';
import { createAutosave } from './keep/autosave.js';
import { createBare } from './stage/bare.js';
import { createColours } from './panel/colours.js';
import { createCompare } from './faces/compare.js';
import { createDisplay } from './stage/display.js';
import { createDistributions } from './panel/distribution.js';
import { createEditor } from './editing/editor.js';
import { element } from './frame/element.js';
import { part } from './frame/download.js';
import { createExports } from './keep/exports.js';
import { createExpressions } from './panel/expressions.js';
import { measureTurns } from './head/eyeturns.js';
import { createExplanation } from './frame/explain.js';
import { createFeatures, featuresOf } from './panel/features.js';
import { createGlow } from './stage/glow.js';
import { growHair } from './hair/onhead.js';
import { layFinework } from './head/finework.js';
import { createLibrary } from './keep/library.js';
import { createLimits } from './panel/limits.js';
import { createMarks } from './panel/marks.js';
import { createSpotting } from './stage/spotting.js';
import { createMarking } from './head/marking.js';
import { lockAgain } from './keep/locks.js';
import { createExpressionFile } from './frame/loading.js';
import { createMeanings } from './panel/meanings.js';
import { createMix } from './faces/mix.js';
import { keepOffline } from './keep/offline.js';
import { createOwnSkin } from './panel/ownskin.js';
import { createPanel } from './panel/panel.js';
import { createPhotoTab } from './photo/tab.js';
import { createPicking } from './stage/picking.js';
import { createPortraits } from './stage/portraits.js';
import { createPrinted } from './frame/print.js';
import { createRandom } from './panel/random.js';
import { createSaved } from './keep/saved.js';
import { createShaping } from './editing/shaping.js';
import { measureShifts } from './head/shifts.js';
import { tapping, text, titleOf } from './text.js';
import { createToast } from './frame/toast.js';
import { createToolbar } from './frame/toolbar.js';
import { createTour } from './frame/tour.js';
import { createViewpoint } from './stage/viewpoint.js';

/** The sections in which the face is taken hold of. */
const SHAPING = ['features', 'meanings'];

/** @typedef {NonNullable<ReturnType<ReturnType<typeof createAutosave>['last']>>} Last */

/**
 * The face to begin with: the tab's own, when the page was loaded again; or the link's, or the last visit's, or the median.
 * @param {import('phiz').FaceModel} model
 * @param {Last | null} last
 * @param {ReturnType<typeof locksOfTab>} again what the tab's own face had locked
 */
function firstFace(model, last, again) {
  const { code, expression, colouring } = splitHash(location.hash);
  let refused = false;
  if (code || expression || colouring || again) {
    try {
      const colours = coloursOf(colouring);
      const face = code ? model.fromCode(code) : model.face();
      if (again) lockAgain(face, again);
      // A link to what was worked on last is the way back to it.
      else if (last && joinHash(last) === joinHash({ code: face.code, expression, colouring })) lockAgain(face, last);
      return { face, expression, colours, refused, restored: false };
    } catch {
      refused = true;
    }
  } else if (last) {
    try {
      const face = model.fromCode(last.code);
      lockAgain(face, last);
      return { face, expression: last.expression, colours: coloursOf(last.colouring), refused, restored: true };
    } catch {
      // It is of an older model with the same name: it is put aside.
    }
  }
  return { face: model.face(), expression: '', colours: {}, refused, restored: false };
}

/** @param {string} colouring encoded @returns {import('./head/colouring.js').Colouring | null} null when it cannot be read */
function coloursOf(colouring) {
  try {
    return decodeColouring(colouring);
  } catch {
    // The shape is worth more than they are.
    return null;
  }
}

/**
 * Everything that shapes the face, around the stage that shows it.
 *
 * @param {import('phiz').FaceModel} model
 * @param {import('./stage/stage.js').Stage} stage
 * @param {ReturnType<typeof import('./frame/models.js').chosenModel>} chosen
 */
export async function createDesigner(model, stage, chosen) {
  const { canvas, head, scene, theme } = stage;
  head.divide(model);
  const median = model.face();
  const medianCode = median.code;
  median.free();
  const autosave = createAutosave(chosen.name);
  const last = autosave.last();
  const again = locksOfTab();
  const { face, expression, colours: read, refused, restored } = firstFace(model, last, again);
  const colours = read ?? {};
  const editor = createEditor(model, face, colours);
  // Presses of a key may be one step together; what a pointer does is one by itself.
  document.addEventListener('pointerdown', editor.part, true);
  const toast = createToast();

  const touch = window.matchMedia('(pointer: coarse)').matches;
  const hint = element('p', { class: 'hint' }, tapping(text.hint));
  const glow = createGlow(head, scene);
  const bare = createBare(editor, stage.root, repaint);
  stage.root.append(hint, toast.root, createViewpoint(canvas, scene, bare.button));

  const display = createDisplay({ face, head, scene, colouring: bare.colouring, onScale: (millimetres) => compare.setScale(millimetres) });
  const library = createLibrary(model, chosen.name);
  const portraits = createPortraits(model, display);

  const random = createRandom(editor, { library, portraits, say: toast.say });
  const distributions = createDistributions(model);
  const limits = createLimits();
  const features = createFeatures(editor, {
    distributions,
    limits,
    random,
    preview: glow.hover,
    // What is open is what a drag shapes, once there was something to drag.
    pick: (group) => selected !== null && select(group),
  });
  const picking = createPicking({
    canvas,
    camera: scene.camera,
    head,
    hover(group, onSkin) {
      // It is a place that is looked for, and no feature.
      if (marks.isPlacing) {
        canvas.style.cursor = onSkin ? 'crosshair' : '';
        return glow.hover(null);
      }
      canvas.style.cursor = onSkin && group === selected ? 'move' : group ? 'pointer' : '';
      glow.hover(group);
    },
    pick: (group, { clientX, clientY }) => (marks.isPlacing ? marks.putAt(clientX, clientY) : select(group)),
  });
  /** The feature whose surface can be dragged: the one that was clicked. @type {string | null} */
  let selected = null;
  /** @param {string | null} group */
  function select(group) {
    if (group === null && selected === null) return;
    selected = group;
    glow.select(group);
    stage.root.classList.toggle('is-shaping', group !== null);
    hint.classList.remove('is-done');
    if (group === null) {
      hint.textContent = tapping(text.hint);
      return;
    }
    panel.choose('features');
    features.choose(group);
    hint.textContent = (touch ? text.hintDragTouch : text.hintDrag)(titleOf(group).toLowerCase());
  }
  const shaping = createShaping(editor, {
    canvas,
    scene,
    head,
    selected: () => selected,
    dragged: () => hint.classList.add('is-done'),
  });
  stage.root.append(...shaping.marks);
  canvas.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape') return;
    if (marks.isPlacing) marks.leave();
    else select(null);
  });
  const mix = createMix(editor, {
    groups: featuresOf(model),
    limits,
    library,
    portraits,
    display,
    canvas,
    groupUnder: picking.groupUnder,
    preview: glow.hover,
    wearsPhoto: () => worn.photo !== null,
    reveal: () => photo.reveal(),
    say: toast.say,
  });
  const file = createExpressionFile(model, chosen.expressions, () => {
    head.expressBy(measureTurns(model), (vertices) => measureShifts(model, vertices));
    // Some of the faces that are shown small may have one.
    portraits.retake();
  });
  const expressions = createExpressions(editor, file, display);
  /** What the head has on: a photo's colours while its face is that of the photo, or else a picture of the person's own. */
  const worn = /** @type {Record<'photo' | 'own', import('./head/head.js').Worn | null>} */ ({ photo: null, own: null });
  /** @param {'photo' | 'own'} which @param {import('./head/head.js').Worn | null} colours */
  function wear(which, colours) {
    worn[which] = colours;
    head.wear(worn.photo ?? worn.own);
    scene.shapeChanged();
  }
  const ownSkin = createOwnSkin({ colouring: () => editor.colouring, wear: (colours) => wear('own', colours), say: toast.say });
  const marks = createMarks(editor, { canvas, spotting: createSpotting({ canvas, scene, head }), beforeFrame: scene.beforeFrame, paints: head.pigments, say: toast.say });
  stage.root.append(marks.pins);
  const colouring = createColours(editor, head.pigments, ownSkin.root, marks);
  const meanings = createMeanings(editor, { distributions, limits });
  const compare = createCompare(editor, { library, display, stage: stage.root, wears: () => head.wears, reveal: () => photo.reveal(), say: toast.say });
  const saved = createSaved(editor, { library, portraits, display, canvas, expressions: file, say: toast.say });
  const photo = createPhotoTab(editor, {
    stage: stage.root,
    files: { modelUrl: chosen.url, expressionsUrl: chosen.expressions },
    expressions: file,
    display,
    sleep: scene.sleep,
    tone: head.tone,
    wear: (colours) => wear('photo', colours),
    choose: () => panel.choose('photo'),
  });
  const explanation = createExplanation(editor);
  /** @param {string} section */
  function turnedTo(section) {
    explanation.about(section);
    if (section !== 'features') select(null);
    // Elsewhere a click leads away from what is being done.
    hint.hidden = !SHAPING.includes(section);
  }
  const panel = createPanel(text.panel, turnedTo, [
    { name: 'features', title: text.modes.features, root: features.root, shown: features.shown },
    ...(meanings.any ? [{ name: 'meanings', title: text.modes.meanings, ...meanings }] : []),
    ...(file.any ? [{ name: 'expressions', title: text.modes.expressions, ...expressions }] : []),
    { name: 'colours', title: text.modes.colours, ...colouring },
    { name: 'mix', title: text.modes.mix, ...mix },
    { name: 'compare', title: text.modes.compare, ...compare },
    { name: 'saved', title: text.modes.saved, ...saved },
    { name: 'photo', title: text.modes.photo, ...photo },
  ]);
  const about = createAbout(model, chosen.name, () => tour.start());
  theme.follow(portraits.retake);
  const address = createAddress(editor, file, toast.say);
  createToolbar(editor, stage.tools, {
    reset() {
      // It also takes away what was said of the face before.
      toast.say(face.locked.length > 0 ? text.locked : face.lockedMeasures.length > 0 ? text.lockedLengths : '');
      editor.reset();
    },
    randomise: () => random.randomise(),
    copyLink: address.copy,
    theme: theme.toggle,
    take: () => exports.showModal(),
    help: about.show,
  });
  stage.furnish(panel.root);
  const tour = createTour({
    choose(section) {
      panel.choose(section);
      // What it tells of sliders is true of a feature's.
      if (section === 'features') features.chooseFeature();
    },
  });
  // Beside the stage, which makes room for it.
  stage.root.before(explanation.root);
  stage.root.append(explanation.open, tour.invitation);
  const exports = createExports({
    face,
    view: scene,
    head,
    expressions: file,
    named: () => library.nameOf(editor.likeness),
    colouring: () => editor.colouring,
    legend: () => compare.legend,
    async settle() {
      // What a photo covers wears it when somebody looks.
      await photo.dress();
      display.refresh();
    },
  });
  const printed = createPrinted(face, {
    stage: stage.root,
    named: () => library.nameOf(editor.likeness),
    other: () => compare.other,
    draw: display.draw,
  });
  document.body.append(about.root, exports, ...tour.parts, printed);

  editor.onShape((range) => {
    display.refresh(range);
  });
  editor.onColours(repaint);
  function repaint() {
    display.repaint();
    // Hair casts shadows.
    scene.shapeChanged();
  }
  // While hair follows a slider the view stays, and when another face is shown for a moment.
  let combing = false;
  function frame() {
    requestAnimationFrame(() => {
      if (!combing && !head.isUnfinished && head.colouring === editor.colouring) scene.reframe();
    });
  }
  editor.onColours(() => (combing = true));
  editor.onStep(() => {
    combing = false;
    frame();
  });
  const come = () => {
    scene.shapeChanged();
    frame();
  };
  head.adorn(growHair, layFinework, createMarking, come, {
    come: () => part(() => import('./glasses/glasses.js')),
    onCome() {
      come();
      // Some of the faces that are shown small may have some on.
      portraits.retake();
    },
    onMiss: (why) => toast.say(text.noGlasses(why instanceof Error ? why.message : String(why))),
  });
  head.paint(colours);
  editor.onRefusal((why) => toast.say(text.refused(why)));
  canvas.addEventListener('webglcontextlost', () => {
    head.loseCard();
    toast.say(text.lostContext);
  });
  canvas.addEventListener('webglcontextrestored', () => scene.shapeChanged());
  display.refresh();

  window.designer = {
    model,
    face,
    get frames() {
      return scene.frames;
    },
    get isFine() {
      return scene.isFine && !head.isUnfinished;
    },
    refine: (wanted) => scene.refine(wanted),
    get colouring() {
      return editor.colouring;
    },
    onScreen: (name) => scene.onScreen(head.landmark(name)),
    get photo() {
      return photo.state;
    },
  };
  // A link shows another face than the one that was being worked on: that one is not lost. What another tab works on is none of
  // this one's.
  const worked = last && (last.code !== medianCode || last.expression || last.colouring) ? last : null;
  const differs = worked && joinHash(worked) !== joinHash({ code: face.code, expression, colouring: encodeColouring(colours) });
  // One of another version of the model would be written over by whoever works here.
  const left = worked && !restored && (!library.isFace(worked.code) || (differs && !again)) ? worked : null;
  let unexpressed = false;
  const expressed = expression ? editor.awaitExpression(expression) : null;
  if (restored) address.write();
  if (expressed) {
    toast.say(text.loadingExpressions);
    try {
      await file.load();
      expressed(decodeExpression(model.expressions, expression));
    } catch {
      unexpressed = true;
      expressed({});
    }
    toast.say('');
  }
  /** Puts what was worked on among the faces. @param {Last} left */
  async function adopt({ code, expression, shown, colouring, when }) {
    let weights = shown ?? {};
    if (expression && !shown) {
      // What cannot be loaded now is not shown either; the shape is kept.
      await file.load().then(() => (weights = decodeExpression(model.expressions, expression))).catch(() => {});
    }
    return library.adopt(text.lastVisit(when), { code, expression: weights, colouring: coloursOf(colouring) ?? {} });
  }
  const adopted = left && (await adopt(left));
  // What a tab worked on that is closed is nobody's, unless it was the last one, or this one goes on from it.
  let ofClosed = '';
  for (const { worked: gone, settle } of await autosave.closed()) {
    const goneOn = [last, { code: face.code, expression, colouring: encodeColouring(colours) }].some((one) => gone && one && joinHash(one) === joinHash(gone));
    const isWorth = gone && !goneOn && (gone.code !== medianCode || gone.expression || gone.colouring);
    const kept = isWorth ? await adopt(gone) : 'known';
    if (kept !== 'refused') settle();
    if (kept === 'added') ofClosed = text.closedKept;
  }
  // Not before: what was worked on last is only there.
  autosave.follow(editor, toast.say);
  if (!chosen.known) toast.say(text.unknownModel);
  else if (adopted === 'unread') toast.say(text.lastUnread);
  else if (adopted === 'refused') toast.say(text.notKept);
  else if (refused) toast.say(text.badCode);
  else if (unexpressed) toast.say(text.badExpression);
  else if (read === null) toast.say(text.badColours);
  else if (adopted === 'added') toast.say(text.lastKept);
  else if (ofClosed) toast.say(ofClosed);
  else if (restored && worked) toast.say(text.back);
  scene.refine(true);
  document.documentElement.dataset.ready = 'true';
  keepOffline();
}

