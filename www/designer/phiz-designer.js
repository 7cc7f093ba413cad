// <phiz-designer>: the face and its sliders as one element, for any page.

import { load } from 'phiz';
import { layGroundwork } from '../src/groundwork/lay.js';
import { backdropUniforms, paintBackdrop } from '../src/rendering/backdrop.js';
import { COLOURS, readColouring } from '../src/head/colouring.js';
import { element } from '../src/frame/element.js';
import { measureTurns } from '../src/head/eyeturns.js';
import { portrait } from '../src/stage/portrait.js';
import { measureShifts } from '../src/head/shifts.js';
import { ordinal, spoken, text } from '../src/text.js';
import { createView } from '../src/stage/view.js';
import css from './phiz-designer.css?inline';

// Sheets that are made here pass a content security policy that forbids inline styles.
const sheet = new CSSStyleSheet();
sheet.replaceSync(css);

/** How many sliders each feature shows when the page does not say. */
const FIRST = 3;

/** One download a model, however many elements show it: each reads a clone while it comes in. @type {Map<string, Promise<Response>>} */
const downloads = new Map();

/** @param {string} url */
function download(url) {
  let response = downloads.get(url);
  if (!response) {
    response = fetch(url).then((response) => {
      if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`.trim());
      // All of it comes at once, whenever it is read; what is cut off is asked for again by the next one.
      response.clone().arrayBuffer().catch(() => downloads.delete(url));
      return response;
    });
    downloads.set(url, response);
    response.catch(() => downloads.delete(url));
  }
  return response;
}

/**
 * What a `controls` attribute asks for: names of controls and features, between commas; `none`; or
 * nothing, which is the first few of each feature.
 * @param {import('phiz').FaceModel} model @param {string | null} asked
 */
function chosenControls(model, asked) {
  if (asked === null) {
    return model.regions.flatMap((region) => model.controls.filter((c) => c.group === region).slice(0, FIRST));
  }
  const names = asked.split(',').map((name) => name.trim());
  if (names.length === 1 && (names[0] === 'none' || names[0] === '')) return [];
  return names.flatMap((name) => {
    const found = model.controls.filter((c) => c.name === name || c.group === name);
    if (found.length === 0) throw new Error(`the model has no control and no feature "${name}"`);
    return found;
  });
}

/**
 * What shows a face, whosever it is.
 * @typedef {{ head: ReturnType<View['complete']>, scene: View['scene'] }} Drawn
 * @typedef {ReturnType<typeof createView>} View
 */

/**
 * Everything that exists once a model is there.
 * @typedef {object} Live
 * @property {import('phiz').FaceModel} model
 * @property {import('phiz').Face} face
 * @property {Drawn['head']} head
 * @property {Drawn['scene']} scene
 * @property {Map<string, { input: HTMLInputElement, output: HTMLOutputElement }>} sliders
 */

/**
 * @param {Readonly<Record<string, number>>} colours
 * @returns {import('../src/head/colouring.js').Colouring}
 * @throws with a sentence that names what is none
 */
function checkedColours(colours) {
  for (const [name, value] of Object.entries(colours)) {
    if (!COLOURS.includes(name)) throw new Error(`there is no colour "${name}": take ${COLOURS.join(', ')}`);
    if (typeof value !== 'number' || !(value >= 0 && value <= 1)) throw new Error(`the colour "${name}" is a number from 0 to 1`);
  }
  return readColouring(colours);
}

/** @param {string | null} words such as "skin: 0.8, iris: 0.1" */
function coloursIn(words) {
  const pairs = (words ?? '').split(',').filter((pair) => pair.trim());
  return checkedColours(
    Object.fromEntries(
      pairs.map((pair) => {
        const [name, value] = pair.split(':');
        return [name.trim(), value?.trim() ? Number(value) : NaN];
      }),
    ),
  );
}

/**
 * `<phiz-designer src head code colours controls theme>`; see designer/README.md.
 */
export class PhizDesigner extends HTMLElement {
  static observedAttributes = ['src', 'head', 'code', 'colours', 'controls', 'theme'];

  /** @type {Live | null} */
  #live = null;
  /** Whether the head knows what the model's expressions do, which the page may load at any time. */
  #expressive = false;
  #panel = element('div', { class: 'panel', part: 'panel' });
  #frame = element('div', { class: 'frame' });
  #dark = window.matchMedia('(prefers-color-scheme: dark)');
  /** Counts starts: a start that is no longer the last one gives up. */
  #start = 0;
  #onDark = () => this.#paint();

  constructor() {
    super();
    const root = this.attachShadow({ mode: 'open' });
    root.adoptedStyleSheets = [sheet];
    root.append(this.#frame);
  }

  connectedCallback() {
    this.#dark.addEventListener('change', this.#onDark);
    // Moving an element disconnects and connects it: what it shows stays.
    if (!this.#live) this.#restart();
  }

  disconnectedCallback() {
    this.#dark.removeEventListener('change', this.#onDark);
    queueMicrotask(() => {
      if (!this.isConnected) {
        this.#start += 1;
        this.#stop();
      }
    });
  }

  /** @param {string} name @param {string | null} before @param {string | null} value */
  attributeChangedCallback(name, before, value) {
    if (before === value || !this.isConnected) return;
    if (name === 'src' || name === 'head') this.#restart();
    else if (name === 'theme') this.#paint();
    else if (this.#live) {
      try {
        if (name === 'controls') this.#buildPanel();
        else if (name === 'colours') this.colours = coloursIn(value);
        else this.code = value ?? '';
      } catch (error) {
        this.#fail(error);
      }
    }
  }

  /** The model, once `ready` was fired. */
  get model() {
    return this.#live?.model ?? null;
  }
  /** The face. Change it through this element, or call `refresh` afterwards. */
  get face() {
    return this.#live?.face ?? null;
  }
  /** The whole face as a short string; may be assigned. The empty string is the median face. */
  get code() {
    return this.#live?.face.code ?? this.getAttribute('code') ?? '';
  }
  set code(code) {
    const { face } = this.#need();
    if (code) face.code = code;
    else face.reset();
    this.refresh();
  }

  /** The colours that are not the model's own; may be assigned. */
  get colours() {
    return this.#live?.head.colouring ?? coloursIn(this.getAttribute('colours'));
  }
  set colours(colours) {
    const { head, scene } = this.#need();
    head.paint(checkedColours(colours));
    scene.shapeChanged();
    this.#tell('change');
  }

  /** @param {string} control @param {number} value */
  set(control, value) {
    this.#need().face.set(control, value);
    this.refresh();
  }
  /** @param {string} control */
  get(control) {
    return this.#need().face.get(control);
  }
  /** @param {string} [region] */
  reset(region) {
    this.#need().face.reset(region);
    this.refresh();
  }
  /** @param {Parameters<import('phiz').Face['randomize']>[0]} [options] */
  randomize(options) {
    const seed = this.#need().face.randomize(options);
    this.refresh();
    return seed;
  }
  /** @param {'front' | 'quarter' | 'profile'} name */
  view(name) {
    this.#need().scene.view(name);
  }
  /** The view as a PNG. @param {{ width: number, height: number, transparent?: boolean }} options */
  toPng(options) {
    const { head, scene } = this.#need();
    head.finish();
    this.#ownBackdrop(scene);
    return portrait(scene, options);
  }
  /** The face as the bytes of a file. @param {'glb' | 'obj' | 'ply' | 'stl'} format */
  async toMesh(format) {
    const { face, head, scene } = this.#need();
    if (format === 'glb') {
      const { glbAsShown } = await import('../src/appearance/appearance.js');
      return glbAsShown(scene.renderer, head, face);
    }
    const { toObj, toPly, toStl } = await import('phiz/export');
    const write = { obj: toObj, ply: toPly, stl: toStl }[format];
    if (!write) throw new Error(`there is no format "${format}": take glb, obj, ply or stl`);
    return write(face);
  }

  /** Shows the face as it is now and tells the page. */
  refresh() {
    const { model, head, face, scene } = this.#need();
    if (!this.#expressive && model.expressions.length) {
      this.#expressive = true;
      head.expressBy(measureTurns(model), measureShifts(model, head.anchors));
    }
    head.update(face);
    scene.shapeChanged();
    this.#readSliders();
    this.#tell('change');
  }

  #need() {
    if (!this.#live) throw new Error('the face is not there yet: wait for the "ready" event');
    return this.#live;
  }

  /** @param {'face' | 'ready' | 'input' | 'change'} type */
  #tell(type) {
    this.dispatchEvent(new CustomEvent(type, { bubbles: true, composed: true, detail: { code: this.code } }));
  }

  /** @param {unknown} error */
  #fail(error) {
    const message = error instanceof Error ? error.message : String(error);
    if (!this.#live) this.#frame.replaceChildren(element('p', { class: 'status', role: 'alert' }, message));
    this.dispatchEvent(new CustomEvent('error', { detail: { message } }));
  }

  async #restart() {
    const start = ++this.#start;
    this.#stop();
    delete this.dataset.face;
    this.#paint();
    const src = this.getAttribute('src');
    if (src === null) return;
    this.#frame.replaceChildren(element('p', { class: 'status', role: 'status' }, text.loading));
    const asked = this.getAttribute('head');
    // A code asks for a face that the head is not.
    const early = asked !== null && !this.getAttribute('code');
    /** @type {import('phiz').FaceModel | undefined} */
    let model;
    /** @type {Drawn['scene'] | undefined} */
    let scene;
    const url = (/** @type {string} */ name) => new URL(name, document.baseURI).href;
    const read = async (/** @type {string} */ name) => load((await download(url(name))).clone());
    /** Shows a model's median face, quickly and then wholly; the model is needed no longer. */
    const draw = async (/** @type {import('phiz').FaceModel} */ shown) => {
      const view = createView(shown, this.#stage(), layGroundwork());
      scene = view.scene;
      this.#furnish(scene);
      if (early) this.#tell('face');
      // The head is on the screen before the model takes the line.
      await new Promise((painted) => requestAnimationFrame(() => setTimeout(painted)));
      // What loads it says why it cannot.
      if (early) download(url(src)).catch(() => {});
      const laid = await view.groundwork;
      if (start !== this.#start) return null;
      const head = view.complete(laid);
      this.dataset.face = 'complete';
      return { head, scene };
    };
    try {
      /** @type {Drawn | null} */
      let drawn = null;
      if (early) {
        model = await read(asked);
        if (start === this.#start) drawn = await draw(model);
        model.free();
        model = undefined;
        if (start !== this.#start) return scene?.renderer.forceContextLoss();
      }
      model = await read(src);
      if (start === this.#start) drawn ??= await draw(model);
      // The head shows without, and the model takes the line.
      const [{ growHair }, { layFinework }] = await Promise.all([import('../src/hair/onhead.js'), import('../src/head/finework.js')]);
      if (start !== this.#start || !drawn) {
        scene?.renderer.forceContextLoss();
        return model.free();
      }
      drawn.head.adorn(growHair, layFinework, drawn.scene.shapeChanged);
      this.#show(model, drawn);
      if (!early) this.#tell('face');
      this.#tell('ready');
    } catch (error) {
      model?.free();
      scene?.renderer.forceContextLoss();
      if (start === this.#start) this.#fail(error);
    }
  }

  /** The canvas, in its place. */
  #stage() {
    const canvas = element('canvas', { tabindex: 0, role: 'img', part: 'canvas', 'aria-label': text.stage });
    this.#panel.replaceChildren();
    this.#frame.replaceChildren(canvas, this.#panel);
    return canvas;
  }

  /** @param {Drawn['scene']} scene */
  #furnish(scene) {
    const canvas = scene.renderer.domElement;
    scene.beforeFrame.add(() => this.#ownBackdrop(scene));
    canvas.addEventListener('dblclick', () => scene.view('front'));
    canvas.addEventListener('keydown', (event) => {
      const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.08], ArrowDown: [0, 0.08] }[event.key];
      if (!turn) return;
      event.preventDefault();
      scene.turn(turn[0], turn[1]);
    });
    canvas.addEventListener('webglcontextrestored', () => scene.shapeChanged());
  }

  /** @param {import('phiz').FaceModel} model @param {Drawn} drawn */
  #show(model, { head, scene }) {
    const face = model.face();
    const code = this.getAttribute('code');
    if (code) face.code = code;
    head.paint(coloursIn(this.getAttribute('colours')));
    chosenControls(model, this.getAttribute('controls'));
    this.#live = { model, face, head, scene, sliders: new Map() };
    this.#expressive = false;
    head.update(face);
    scene.shapeChanged();
    scene.refine(true);
    this.#buildPanel();
    this.#paint();
  }

  #stop() {
    if (!this.#live) return;
    const { model, head, scene } = this.#live;
    this.#live = null;
    head.dispose();
    model.free();
    scene.controls.dispose();
    scene.renderer.dispose();
    // Browsers allow few contexts at a time; give this one back.
    scene.renderer.forceContextLoss();
    this.#frame.replaceChildren();
  }

  #theme() {
    const asked = this.getAttribute('theme');
    if (asked === 'light' || asked === 'dark') return asked;
    return this.#dark.matches ? 'dark' : 'light';
  }

  #paint() {
    this.dataset.theme = this.#theme();
    this.#live?.scene.invalidate();
  }

  /** Elements on one page share the wall's colours and size; each sets its own before it draws. */
  #ownBackdrop(/** @type {Drawn['scene']} */ scene) {
    paintBackdrop(this.#theme());
    scene.renderer.getDrawingBufferSize(backdropUniforms.backdropSize.value);
  }

  #buildPanel() {
    const { model, sliders } = this.#need();
    const controls = chosenControls(model, this.getAttribute('controls'));
    sliders.clear();
    /** @type {HTMLElement[]} */
    const rows = [];
    let group = '';
    for (const control of controls) {
      if (control.group !== group) {
        group = control.group;
        rows.push(element('h2', {}, text.groups[group] ?? group));
      }
      const [min, max] = control.limits;
      const output = element('output', {});
      const input = element('input', { type: 'range', min, max, step: 0.001, 'aria-label': spoken(control.name), title: control.description });
      const name = spoken(control.name)[0].toUpperCase() + spoken(control.name).slice(1);
      input.addEventListener('input', (event) => {
        // The element tells of itself, when the face is there.
        event.stopPropagation();
        this.#slide(control.name, input.valueAsNumber);
        this.#tell('input');
      });
      input.addEventListener('change', (event) => {
        event.stopPropagation();
        this.#tell('change');
      });
      sliders.set(control.name, { input, output });
      rows.push(element('label', {}, element('span', {}, name), output, input));
    }
    this.#panel.replaceChildren(...rows);
    this.#readSliders();
  }

  /** @param {string} control @param {number} value */
  #slide(control, value) {
    const { face, head, scene } = this.#need();
    face.set(control, value);
    head.update(face, face.changed);
    scene.shapeChanged();
    this.#readSliders(control);
  }

  /** @param {string} [held] the slider that a person has in hand: it shows what was asked for */
  #readSliders(held) {
    const { face, sliders } = this.#need();
    for (const [name, { input, output }] of sliders) {
      const value = face.get(name);
      if (name !== held) input.value = String(value);
      output.value = ordinal(value);
      input.setAttribute('aria-valuetext', output.value);
    }
  }
}

customElements.define('phiz-designer', PhizDesigner);
