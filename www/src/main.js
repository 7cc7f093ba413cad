import { load } from 'phiz';
import { createAbout } from './about.js';
import { download } from './download.js';
import { createEditor } from './editor.js';
import { element } from './element.js';
import { createExports } from './exports.js';
import { Failure, showFailure } from './failure.js';
import { createHead } from './head.js';
import { icon } from './icons.js';
import { chosenModel } from './models.js';
import { keepOffline } from './offline.js';
import { createPanel } from './panel.js';
import { createPicking } from './picking.js';
import { createScene } from './scene.js';
import { text } from './text.js';
import { createTheme } from './theme.js';

/** @returns {(fraction: number) => void} */
function showLoading() {
  const bar = element('progress', { max: 1, value: 0, 'aria-label': text.loading });
  document.body.replaceChildren(
    element('main', { class: 'loading' }, element('p', { class: 'brand' }, text.name), bar, element('p', {}, text.loading)),
  );
  return (fraction) => {
    bar.value = fraction;
  };
}

function checkBrowser() {
  if (typeof WebAssembly !== 'object') throw new Failure(text.noWasm);
  const probe = document.createElement('canvas').getContext('webgl2');
  if (!probe) throw new Failure(text.noWebGL);
  // Browsers allow few contexts at a time; give this one back.
  probe.getExtension('WEBGL_lose_context')?.loseContext();
}

/** @param {URL} url */
async function loadModel(url) {
  const bytes = await download(url, showLoading());
  try {
    return await load(bytes);
  } catch (error) {
    throw new Failure(text.badModel(error instanceof Error ? error.message : String(error)));
  }
}

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

/** A sentence that goes away by itself. */
function createToast() {
  const root = element('p', { class: 'toast', role: 'status' });
  let timer = 0;
  return {
    root,
    /** @param {string} sentence */
    say(sentence) {
      root.textContent = sentence;
      root.classList.add('is-shown');
      clearTimeout(timer);
      timer = window.setTimeout(() => root.classList.remove('is-shown'), 3200);
    },
  };
}

/**
 * @param {keyof typeof import('./icons.js').icon | any} name
 * @param {string} label
 * @param {() => void} onclick
 */
function tool(name, label, onclick) {
  return element('button', { type: 'button', class: 'tool', 'aria-label': label, title: label, onclick }, icon(name));
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

  const canvas = element('canvas', { class: 'view', tabindex: 0, role: 'img', 'aria-label': text.stage });
  const toast = createToast();
  const touch = window.matchMedia('(pointer: coarse)').matches;
  const hint = element('p', { class: 'hint' }, touch ? text.hintTouch : text.hint);
  const views = element('div', { class: 'views', role: 'group', 'aria-label': text.views });
  const bar = element('header', { class: 'bar' });
  const stage = element('main', { class: 'stage' }, canvas, hint, views, toast.root);
  const about = createAbout(model, chosen.name);

  // What the pointer is on shows while it is there; what was picked glows once.
  const still = window.matchMedia('(prefers-reduced-motion: reduce)').matches;
  const glow = { hover: 0, hoverGoal: 0, pick: 0, last: 0 };
  /** @type {string | null} */
  let hovered = null;
  /** @param {string | null} group */
  function hover(group) {
    canvas.style.cursor = group ? 'pointer' : '';
    if (group === hovered) return;
    hovered = group;
    if (group) head.highlight(0, group);
    glow.hoverGoal = group ? 1 : 0;
    scene.invalidate();
  }
  /** @param {string} group */
  function flash(group) {
    head.highlight(1, group);
    glow.pick = still ? 0 : 1;
    scene.invalidate();
  }

  const panel = createPanel(editor, { preview: hover, say: toast.say });
  document.body.replaceChildren(element('div', { class: 'app' }, bar, stage, panel.root), about);

  const scene = createScene(canvas, head.subject);
  scene.scene.add(head.group);
  const exports = createExports(face, scene);
  document.body.append(exports);
  scene.beforeFrame.add(() => {
    const now = performance.now();
    const elapsed = Math.min(50, now - glow.last);
    glow.last = now;
    const step = still ? 1 : elapsed / 140;
    glow.hover += Math.max(-step, Math.min(step, glow.hoverGoal - glow.hover));
    glow.pick = Math.max(0, glow.pick - elapsed / 900);
    head.markStrength[0] = glow.hover;
    head.markStrength[1] = glow.pick;
    if (glow.hover !== glow.hoverGoal || glow.pick > 0) scene.invalidate();
  });
  head.update(face);

  window.designer = {
    model,
    face,
    get frames() {
      return scene.frames;
    },
    onScreen: (name) => scene.onScreen(head.landmark(name)),
  };

  const theme = createTheme((chosen) => scene.setTheme(chosen));
  createPicking({
    canvas,
    camera: scene.camera,
    head,
    hover,
    pick(group) {
      panel.choose(group);
      flash(group);
      hint.classList.add('is-done');
    },
  });

  for (const name of /** @type {const} */ (['front', 'quarter', 'profile'])) {
    views.append(
      element('button', { type: 'button', class: 'chip', onclick: () => scene.view(name) }, text.view[name]),
    );
  }
  views.append(tool('home', text.resetView, () => scene.view('front')));
  /** @type {Record<string, [number, number, number?]>} */
  const turns = {
    ArrowLeft: [-0.12, 0],
    ArrowRight: [0.12, 0],
    ArrowUp: [0, -0.08],
    ArrowDown: [0, 0.08],
    '+': [0, 0, 0.9],
    '=': [0, 0, 0.9],
    '-': [0, 0, 1.1],
  };
  canvas.addEventListener('keydown', (event) => {
    const turn = turns[event.key];
    if (!turn || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    scene.turn(...turn);
  });
  canvas.addEventListener('dblclick', () => scene.view('front'));

  const undo = tool('undo', text.undo, () => editor.undo());
  const redo = tool('redo', text.redo, () => editor.redo());
  async function copyLink() {
    const url = new URL(location.href);
    url.hash = face.code;
    try {
      await navigator.clipboard.writeText(url.href);
      toast.say(text.linkCopied);
    } catch {
      // Without permission or a secure origin there is no clipboard: let the person copy it.
      window.prompt(text.linkManual, url.href);
    }
  }
  bar.append(
    element('h1', { class: 'brand' }, text.name, ' ', element('span', {}, text.tagline)),
    element(
      'div',
      { class: 'tools' },
      undo,
      redo,
      tool('reset', text.resetAll, () => editor.reset()),
      element('button', { type: 'button', class: 'button', onclick: () => panel.randomise() }, icon('dice'), element('span', {}, text.randomise)),
      element('button', { type: 'button', class: 'button primary', onclick: copyLink }, icon('link'), element('span', {}, text.copyLink)),
      tool('save', text.exportTitle, () => exports.showModal()),
      tool('theme', text.theme, () => theme.toggle()),
      tool('help', text.about, () => about.showModal()),
    ),
  );

  const medianCode = (() => {
    const fresh = model.face();
    const code = fresh.code;
    fresh.free();
    return code;
  })();
  function keepHash() {
    const code = face.code;
    const url = new URL(location.href);
    url.hash = code === medianCode ? '' : code;
    window.history.replaceState(null, '', url);
  }
  function refreshTools() {
    undo.disabled = !editor.canUndo;
    redo.disabled = !editor.canRedo;
  }
  editor.onShape((range) => {
    head.update(face, range);
    scene.shapeChanged();
  });
  editor.onStep(() => {
    refreshTools();
    keepHash();
  });
  refreshTools();

  window.addEventListener('hashchange', () => {
    try {
      editor.take(location.hash.slice(1) || medianCode);
    } catch {
      toast.say(text.badCode);
    }
  });
  window.addEventListener('keydown', (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    // Text fields have an undo of their own.
    if (event.target instanceof HTMLInputElement && event.target.type !== 'range') return;
    const key = event.key.toLowerCase();
    const redoes = key === 'y' || (key === 'z' && event.shiftKey);
    if (!redoes && key !== 'z') return;
    event.preventDefault();
    if (redoes) editor.redo();
    else editor.undo();
  });
  canvas.addEventListener('webglcontextlost', () => toast.say(text.lostContext));
  canvas.addEventListener('webglcontextrestored', () => scene.shapeChanged());
  if (!chosen.known) toast.say(text.unknownModel);
  else if (refused) toast.say(text.badCode);
  document.documentElement.dataset.ready = 'true';
  keepOffline();
}

start().catch((error) => {
  showFailure(error);
  // A failure that has no sentence of its own is a fault of the page: keep its trace.
  if (!(error instanceof Failure)) throw error;
});
