import { createAbout } from './about.js';
import { createAddress } from './address.js';
import { createDistributions } from './distribution.js';
import { createEditor } from './editor.js';
import { element } from './element.js';
import { Failure, showFailure } from './failure.js';
import { createFeatures } from './features.js';
import { createGlow } from './glow.js';
import { createHead } from './head.js';
import { checkBrowser, loadModel } from './loading.js';
import { chosenModel } from './models.js';
import { createPanel } from './panel.js';
import { createPicking } from './picking.js';
import { createRandom } from './random.js';
import { createScene } from './scene.js';
import { text } from './text.js';
import { createTheme } from './theme.js';
import { createToast } from './toast.js';
import { createToolbar } from './toolbar.js';
import { createViewpoint } from './viewpoint.js';

/** @param {import('phiz').FaceModel} model */
function firstFace(model) {
  const code = location.hash.slice(1);
  if (code) {
    try {
      return { face: model.fromCode(code), refused: false };
    } catch {
      return { face: model.face(), refused: true };
    }
  }
  return { face: model.face(), refused: false };
}

async function start() {
  checkBrowser();
  const chosen = chosenModel();
  const model = await loadModel(chosen.url);
  // The head at rest is painted on the median face, whatever the link asks for.
  const median = model.face();
  const head = createHead(model, median);
  median.free();
  const { face, refused } = firstFace(model);
  const editor = createEditor(model, face);
  const toast = createToast();

  const canvas = element('canvas', { class: 'view', tabindex: 0, role: 'img', 'aria-label': text.stage });
  const touch = window.matchMedia('(pointer: coarse)').matches;
  const hint = element('p', { class: 'hint' }, touch ? text.hintTouch : text.hint);
  const stage = element('main', { class: 'stage' }, canvas, hint, toast.root);
  const app = element('div', { class: 'app' }, stage);
  // The canvas has to be laid out before the scene measures it.
  document.body.replaceChildren(app);
  const scene = createScene(canvas, head.subject);
  scene.scene.add(head.group);
  const glow = createGlow(head, scene);
  stage.append(createViewpoint(canvas, scene));

  const random = createRandom(editor, toast.say);
  const features = createFeatures(editor, {
    distributions: createDistributions(model),
    random,
    preview: glow.hover,
  });
  const panel = createPanel(text.panel, [{ name: 'features', title: text.modes.features, root: features.root }]);
  const about = createAbout(model, chosen.name);
  const theme = createTheme((name) => scene.setTheme(name));
  const address = createAddress(editor, toast.say);
  const toolbar = createToolbar(editor, {
    randomise: () => random.randomise(),
    copyLink: address.copy,
    theme: theme.toggle,
    help: () => about.showModal(),
  });
  app.prepend(toolbar);
  app.append(panel.root);
  document.body.append(about);

  createPicking({
    canvas,
    camera: scene.camera,
    head,
    hover(group) {
      canvas.style.cursor = group ? 'pointer' : '';
      glow.hover(group);
    },
    pick(group) {
      panel.choose('features');
      features.choose(group);
      glow.flash(group);
      hint.classList.add('is-done');
    },
  });
  editor.onShape((range) => {
    head.update(face, range);
    scene.shapeChanged();
  });
  canvas.addEventListener('webglcontextlost', () => toast.say(text.lostContext));
  canvas.addEventListener('webglcontextrestored', () => scene.shapeChanged());
  head.update(face);

  window.designer = {
    model,
    face,
    get frames() {
      return scene.frames;
    },
    onScreen: (name) => scene.onScreen(head.landmark(name)),
  };
  if (!chosen.known) toast.say(text.unknownModel);
  else if (refused) toast.say(text.badCode);
  document.documentElement.dataset.ready = 'true';
}

start().catch((error) => {
  showFailure(error);
  // A failure that has no sentence of its own is a fault of the page: keep its trace.
  if (!(error instanceof Failure)) throw error;
});
