// <phiz-designer>: the face and its sliders as one element, for any page.

import { load } from 'phiz';
import { layGroundwork } from '../src/groundwork/lay.js';
import { backdropUniforms, paintBackdrop } from '../src/rendering/backdrop.js';
import { COLOURS, readColouring } from '../src/head/colouring.js';
import { readMarks } from '../src/head/marks.js';
import { sameWeights } from '../src/editing/history.js';
import { part } from '../src/frame/download.js';
import { element } from '../src/frame/element.js';
import { Failure } from '../src/frame/failure.js';
import { steppedTo } from '../src/frame/keys.js';
import { measureTurns } from '../src/head/eyeturns.js';
import { portrait } from '../src/stage/portrait.js';
import { measureShifts } from '../src/head/shifts.js';
import { elementStage, ordinal, spoken, text } from '../src/text.js';
import { createView } from '../src/stage/view.js';
import { listenToKeys } from '../src/stage/viewpoint.js';
import { shareGestures } from './gestures.js';
import dark from './dark.css?inline';
import css from './phiz-designer.css?inline';

/**
 * Sheets that are made here pass a content security policy that forbids inline styles. A document takes none of another one's.
 * @type {WeakMap<Document, Record<'light' | 'dark', CSSStyleSheet[]>>}
 */
const sheets = new WeakMap();
/** @param {Document} page */
function sheetsFor(page) {
  let own = sheets.get(page);
  if (!own) {
    const [always, inTheDark] = [css, dark].map((rules) => {
      const sheet = new (page.defaultView ?? window).CSSStyleSheet();
      sheet.replaceSync(rules);
      return sheet;
    });
    own = { light: [always], dark: [always, inTheDark] };
    sheets.set(page, own);
  }
  return own;
}

/** What properties of the same name tell and set. */
const REFLECTED = /** @type {const} */ (['src', 'head', 'controls', 'theme']);

/** What `toMesh` writes. */
const FORMATS = ['glb', 'obj', 'ply', 'stl'];

/** How many sliders each feature shows when the page does not say. */
const FIRST = 3;
/** What a key adds, of the percentile that is shown in whole ones. */
const STEP = 0.01;

/** One download a model, however many elements show it: each reads a clone while it comes in. @type {Map<string, Promise<Response>>} */
const downloads = new Map();

/** @param {string} url */
function download(url) {
  let response = downloads.get(url);
  if (!response) {
    const came = fetch(url).catch((why) => {
      // Browsers do not say of what.
      throw new Error(`${url} did not come: ${sentence(why)}`);
    });
    response = came.then((response) => {
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
 * What a `controls` attribute asks for: names of controls and features, between commas, each slider once; `none`; or
 * nothing, which is the first few of each feature.
 * @param {import('phiz').FaceModel} model @param {string | null} asked
 */
function chosenControls(model, asked) {
  if (asked === null) {
    return model.regions.flatMap((region) => model.controls.filter((c) => c.group === region).slice(0, FIRST));
  }
  const names = asked.split(',').map((name) => name.trim()).filter(Boolean);
  if (names.length === 1 && names[0] === 'none') return [];
  const found = names.flatMap((name) => {
    const named = model.controls.filter((c) => c.name === name || c.group === name);
    if (named.length === 0) throw new Error(`the model has no control and no feature "${name}"`);
    return named;
  });
  return [...new Set(found)];
}

/**
 * Nobody hears of an option that is misspelled.
 * @template {object} T
 * @param {string} method @param {T | undefined} options @param {readonly (keyof T)[]} known
 * @returns {Partial<T>} them
 */
function optionsOf(method, options, known) {
  // Some pass null for none.
  const asked = options ?? {};
  if (typeof asked !== 'object') throw new TypeError(`what ${method} is given must be an object, not ${JSON.stringify(asked)}`);
  const unknown = Object.keys(asked).find((name) => !known.includes(/** @type {keyof T} */ (name)));
  if (unknown !== undefined) throw new Error(`${method} knows no option "${unknown}"`);
  return asked;
}

/** Until the head is on the screen; a page that is hidden paints nothing, and waits no longer. */
const painted = () =>
  new Promise((done) => {
    requestAnimationFrame(() => setTimeout(done));
    setTimeout(done, 1000);
  });

/** @param {unknown} error */
const sentence = (error) => (error instanceof Error ? error.message : String(error));

/** @typedef {ReturnType<typeof createView>} View */
/** @typedef {import('./types.js').PhizDesignerMembers} PhizDesignerMembers */

/**
 * Everything that exists once a model is there.
 * @typedef {object} Live
 * @property {import('phiz').FaceModel} model
 * @property {import('phiz').Face} face
 * @property {string} median the code of the model's own face
 * @property {ReturnType<View['complete']>} head
 * @property {View['scene']} scene
 * @property {Map<string, { input: HTMLInputElement, output: HTMLOutputElement }>} sliders
 */

/** @param {string} words such as "skin: 0.8, iris: 0.1" */
function spelled(words) {
  const pairs = words.split(',').filter((pair) => pair.trim());
  return Object.fromEntries(
    pairs.map((pair) => {
      const [name, value] = pair.split(':');
      if (name.trim() === 'marks') return ['marks', value?.trim() ?? ''];
      return [name.trim(), value?.trim() ? Number(value) : NaN];
    }),
  );
}

/**
 * @param {unknown} asked an object, or words as the attribute has them; nothing is the model's own
 * @returns {import('../src/head/colouring.js').Colouring}
 * @throws with a sentence that names what is none
 */
function coloursOf(asked) {
  const colours = typeof asked === 'string' ? spelled(asked) : (asked ?? {});
  if (typeof colours !== 'object') throw new Error('colours are an object, such as { skin: 0.8 }, or words, such as "skin: 0.8"');
  const numbers = /** @type {Record<string, unknown>} */ (colours);
  for (const [name, value] of Object.entries(numbers)) {
    if (name === 'marks') {
      if (value !== undefined && value !== '' && !readMarks(value)) throw new Error('the marks are what a link of the page has after its third tilde');
      continue;
    }
    if (!COLOURS.includes(name)) throw new Error(`there is no colour "${name}": take ${COLOURS.join(', ')} or marks`);
    if (typeof value !== 'number' || !(value >= 0 && value <= 1)) throw new Error(`the colour "${name}" is a number from 0 to 1`);
  }
  return readColouring(numbers);
}

/**
 * `<phiz-designer src head code colours controls theme>`; see designer/README.md.
 * @implements {PhizDesignerMembers}
 */
export class PhizDesigner extends HTMLElement {
  static observedAttributes = ['src', 'head', 'code', 'colours', 'controls', 'theme'];

  /** @type {Live | null} */
  #live = null;
  /** What the stage shows, which may be there before the model is. @type {View['scene'] | null} */
  #scene = null;
  /** @type {Live['head'] | null} */
  #head = null;
  /** What the page asked for last, if the model is there or not. */
  #asked = { code: '', colours: /** @type {unknown} */ (null) };
  /** What came of it, as the face and its colours had it then. @type {{ code?: string, colours?: import('../src/head/colouring.js').Colouring }} */
  #came = {};
  /** The face of an element that was taken away, until it is back. @type {{ code?: string, colours?: unknown, expression?: Readonly<Record<string, number>> }} */
  #kept = {};
  /** Whether the head knows what the model's expressions do, which the page may load at any time. */
  #expressive = false;
  #panel = element('div', { class: 'panel', part: 'panel' });
  #frame = element('div', { class: 'frame' });
  /** Tells when the face is complete. */
  #box = element('div', { class: 'box' }, this.#frame);
  #lost = element('p', { class: 'status', role: 'alert' });
  #dark = window.matchMedia('(prefers-color-scheme: dark)');
  #started = false;
  /** Whether the model did not come. */
  #failed = false;
  /** Counts starts: a start that is no longer the last one gives up. */
  #start = 0;
  /** Ends what listens to the canvas. */
  #listening = new AbortController();
  #onDark = () => this.#paint();

  constructor() {
    super();
    const root = this.attachShadow({ mode: 'open' });
    root.adoptedStyleSheets = sheetsFor(document).light;
    root.append(this.#box);
  }

  /** In a window of its own, such as a picture in picture, it looks as it did. */
  adoptedCallback() {
    this.#dress();
  }

  connectedCallback() {
    // What the page assigned before this class was there hides the accessors.
    for (const name of /** @type {const} */ (['code', 'colours', ...REFLECTED])) {
      if (!Object.hasOwn(this, name)) continue;
      const value = this[name];
      delete (/** @type {Partial<PhizDesigner>} */ (this)[name]);
      Object.assign(this, { [name]: value });
    }
    this.#dark.addEventListener('change', this.#onDark);
    // Moving an element disconnects and connects it: what it shows stays.
    if (!this.#started) this.#restart();
  }

  disconnectedCallback() {
    this.#dark.removeEventListener('change', this.#onDark);
    queueMicrotask(() => {
      if (this.isConnected) return;
      this.#start += 1;
      this.#started = false;
      this.#keep();
      this.#stop();
    });
  }

  /** What shows is there again when the element is. */
  #keep() {
    if (!this.#live) return;
    const { model, face, head } = this.#live;
    try {
      const expression = model.expressions.length ? face.expression : this.#kept.expression;
      this.#kept = { code: face.code, colours: head.colouring, expression };
    } catch {
      // A page that freed the face has none.
    }
  }
  /** Another model has other codes, and what the page asked for of the one before was something else by the end if anybody changed it. */
  #forget() {
    this.#keep();
    const { code, colours } = this.#kept;
    if (code !== undefined && this.#came.code !== undefined && code !== this.#came.code) this.#asked.code = '';
    if (colours !== undefined && this.#came.colours && !sameWeights(coloursOf(colours), this.#came.colours)) this.#asked.colours = null;
    this.#kept = {};
    this.#came = {};
  }

  /** @param {string} name @param {string | null} before @param {string | null} value */
  attributeChangedCallback(name, before, value) {
    if (name === 'code' || name === 'colours') this.#ask(name, value);
    else if (before !== value) this.#attempt(() => this.#follow(name, value));
    // As of an image that did not come, the same address is another attempt.
    else if (name === 'src' && this.#started && this.#failed) this.#restart();
  }

  /** @param {'code' | 'colours'} name @param {unknown} value that may be none: a page that renders what somebody typed goes on */
  #ask(name, value) {
    this.#attempt(() => (name === 'code' ? this.#askCode(/** @type {string | null | undefined} */ (value)) : this.#askColours(value)));
  }

  /** @param {() => void} change */
  #attempt(change) {
    try {
      change();
    } catch (error) {
      this.#complain(error);
    }
  }

  /** @param {string} name of an attribute that is another now @param {string | null} value */
  #follow(name, value) {
    if (name === 'src') this.#forget();
    if (!this.#started) return;
    if (name === 'theme') this.#paint();
    else if (name === 'src') this.#restart();
    else if (name === 'controls') {
      if (this.#live) this.#buildPanel(value);
    } else if (!this.#live) this.#restart();
  }

  /** @param {typeof REFLECTED[number]} name @param {string | null | undefined} value */
  #reflect(name, value) {
    if (value === null || value === undefined) this.removeAttribute(name);
    else this.setAttribute(name, value);
  }
  /** The attribute; empty where there is none, as of an image. Null and undefined take it away. @returns {string} */
  get src() {
    return this.getAttribute('src') ?? '';
  }
  /** @param {string | null | undefined} value */
  set src(value) {
    this.#reflect('src', value);
  }
  /** @returns {string} */
  get head() {
    return this.getAttribute('head') ?? '';
  }
  /** @param {string | null | undefined} value */
  set head(value) {
    this.#reflect('head', value);
  }
  /** Null is those that it has without, the empty string none. @returns {string | null} */
  get controls() {
    return this.getAttribute('controls');
  }
  /** @param {string | null | undefined} value */
  set controls(value) {
    this.#reflect('controls', value);
  }
  /** @returns {string} */
  get theme() {
    return this.getAttribute('theme') ?? '';
  }
  /** @param {string | null | undefined} value */
  set theme(value) {
    this.#reflect('theme', value);
  }

  /** The model, once `ready` was fired. */
  get model() {
    return this.#live?.model ?? null;
  }
  /** The face. Change it through this element, or call `refresh` afterwards. */
  get face() {
    return this.#live?.face ?? null;
  }
  /** The whole face as a short string; may be assigned at any time. The empty string is the median face. @returns {string} */
  get code() {
    return this.#live?.face.code ?? this.#kept.code ?? this.#asked.code;
  }
  /** @param {string | null | undefined} code */
  set code(code) {
    this.#ask('code', code);
  }

  /** The colours that are not the model's own, a copy; may be assigned at any time, also as the attribute has them. @returns {import('./types.js').PhizColours} */
  get colours() {
    // Who changes what was given and assigns it means another one.
    const given = (/** @type {import('../src/head/colouring.js').Colouring} */ colouring) => /** @type {import('./types.js').PhizColours} */ ({ ...colouring });
    if (this.#live) return given(this.#live.head.colouring);
    try {
      return given(coloursOf(this.#kept.colours ?? this.#asked.colours));
    } catch {
      // It is said when the model is there.
      return {};
    }
  }
  /** @param {import('./types.js').PhizColours | Readonly<Record<string, number | string | undefined>> | string | null | undefined} colours */
  set colours(colours) {
    this.#ask('colours', colours);
  }

  /** @param {string | null | undefined} code */
  #askCode(code) {
    this.#asked.code = code ?? '';
    delete this.#kept.code;
    delete this.#came.code;
    if (!this.#live) return;
    const { face, median } = this.#live;
    const before = face.code;
    // No code is the median face, whatever is locked, as with any other.
    face.code = code || median;
    this.#came.code = face.code;
    // Elements that are kept alike, and frameworks, assign what is there: nobody is to answer that.
    if (face.code !== before) this.refresh();
  }

  /** @param {unknown} colours */
  #askColours(colours) {
    this.#asked.colours = colours;
    delete this.#kept.colours;
    delete this.#came.colours;
    if (!this.#live) return;
    const { head, scene } = this.#live;
    const asked = coloursOf(colours);
    this.#came.colours = asked;
    if (sameWeights(asked, head.colouring)) return;
    head.paint(asked);
    scene.shapeChanged();
    this.#reframe();
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
  /** The view as a PNG. @param {{ width?: number, height?: number, transparent?: boolean }} [options] */
  async toPng(options) {
    const { width = 1024, height = width, transparent = false } = optionsOf('toPng', options, ['width', 'height', 'transparent']);
    const { face, head, scene } = this.#need();
    const ready = () => {
      head.finish();
      // Hair that grew just now is in view as well.
      scene.reframe();
      scene.arrive();
    };
    const draw = () => {
      this.#ownBackdrop(scene);
      return portrait(scene, { width, height, transparent });
    };
    ready();
    const fetched = head.equipping();
    if (!fetched) return draw();
    const [asked, { colouring }, there] = [face.clone(), head, scene.keep()];
    try {
      await fetched;
      if (scene !== this.#scene) throw new Error(text.elementGone);
      const [colours, back] = [head.colouring, scene.keep()];
      try {
        head.paint(colouring);
        head.update(asked);
        ready();
        there();
        return draw();
      } finally {
        head.paint(colours);
        head.update(face);
        ready();
        back();
        scene.shapeChanged();
      }
    } finally {
      asked.free();
    }
  }
  /** The face as the bytes of a file. @param {'glb' | 'obj' | 'ply' | 'stl'} format @param {{ targets?: boolean }} [options] of a GLB */
  async toMesh(format, options) {
    const { targets = true } = optionsOf('toMesh', options, ['targets']);
    const { face, head, scene } = this.#need();
    if (!FORMATS.includes(format)) throw new Error(`there is no format "${format}": take glb, obj, ply or stl`);
    // As they are now: what writes them may have to come first.
    const { colouring } = head;
    const asked = face.clone();
    try {
      const writing = part(() => import('phiz/export'));
      // It has no colours.
      if (format === 'stl') return (await writing).toStl(asked);
      const looking = part(() => import('../src/appearance/appearance.js'));
      const [{ toObj, toPly }, { coloursAsShown, glbAsShown }] = await Promise.all([writing, looking]);
      if (format === 'glb') return await glbAsShown(scene.renderer, head, asked, { targets, colouring });
      const colours = coloursAsShown(scene.renderer, head, asked, { colouring });
      return (format === 'obj' ? toObj : toPly)(asked, { colours });
    } catch (error) {
      if (scene !== this.#scene) throw new Error(text.elementGone, { cause: error });
      throw error;
    } finally {
      asked.free();
    }
  }

  /** Shows the face as it is now and tells the page. */
  refresh() {
    const { model, head, face, scene } = this.#need();
    if (!this.#expressive && model.expressions.length) {
      this.#expressive = true;
      head.expressBy(measureTurns(model), (vertices) => measureShifts(model, vertices));
      const known = Object.entries(this.#kept.expression ?? {}).filter(([name]) => model.expressions.includes(name));
      if (!Object.keys(face.expression).length) face.expression = Object.fromEntries(known);
    }
    head.update(face);
    scene.shapeChanged();
    this.#reframe();
    this.#readSliders();
    this.#tell('change');
  }

  /** Once hair and beard have grown, the view that was chosen is on all of them. */
  #reframe() {
    requestAnimationFrame(() => this.#live && !this.#live.head.isUnfinished && this.#live.scene.reframe());
  }

  #need() {
    if (!this.#live) throw new Error('the face is not there yet: wait for the "ready" event');
    return this.#live;
  }

  /** @param {'face' | 'ready' | 'input' | 'change'} type */
  #tell(type) {
    this.dispatchEvent(new CustomEvent(type, { bubbles: true, composed: true, detail: { code: this.code } }));
  }

  /** To the page, and unless that heeds it, to whoever writes the page. @param {unknown} error */
  #complain(error) {
    const message = sentence(error);
    const isOpen = this.dispatchEvent(new CustomEvent('error', { detail: { message }, cancelable: true }));
    if (isOpen) console.warn(`<phiz-designer>: ${message}`);
  }

  /** There will be no model: what there is of a face stays. @param {unknown} error */
  #fail(error) {
    this.#failed = true;
    if (!this.#scene) this.#frame.replaceChildren();
    this.#frame.append(element('p', { class: 'status', role: 'alert' }, sentence(error)));
    this.#complain(error);
  }

  async #restart() {
    const start = ++this.#start;
    const isStale = () => start !== this.#start;
    this.#started = true;
    this.#failed = false;
    this.#stop();
    this.#paint();
    // As of an image, an empty address is none: it would be the page's own.
    const { src } = this;
    if (src === '') return;
    const loading = element('p', { class: 'status', role: 'status' }, text.loading);
    this.#frame.replaceChildren(loading);
    const preview = this.getAttribute('head');
    /** @type {import('phiz').FaceModel | undefined} */
    let model;
    /** Vertices of the head that shows before the model is there. */
    let early = 0;
    // What is no address stays as it is: who asks for it says so.
    const url = (/** @type {string} */ name) => (URL.canParse(name, document.baseURI) ? new URL(name, document.baseURI).href : name);
    const read = async (/** @type {string} */ name) => load((await download(url(name))).clone());
    /** Shows a model's median face, quickly and then wholly; the model is needed no longer. */
    const draw = async (/** @type {import('phiz').FaceModel} */ shown) => {
      const view = createView(shown, this.#stage(), layGroundwork());
      this.#scene = view.scene;
      this.#furnish(view.scene);
      if (early) this.#tell('face');
      // The head is on the screen before the model takes the line.
      await painted();
      // What loads it says why it cannot.
      if (early) download(url(src)).catch(() => {});
      const laid = await view.groundwork;
      if (isStale()) return;
      this.#head = view.complete(laid);
      this.#box.dataset.face = 'complete';
    };
    const leaveOut = (/** @type {unknown} */ why) => {
      early = 0;
      this.#stop();
      this.#frame.replaceChildren(loading);
      this.#complain(new Error(`the head is left out: ${sentence(why)}`));
    };
    try {
      // A code asks for a face that the head is not.
      if (preview !== null && !this.code) {
        try {
          model = await read(preview);
          early = model.vertexCount;
          if (!isStale()) await draw(model);
        } catch (error) {
          // What draws no head draws no face either.
          if (error instanceof Failure) throw error;
          downloads.delete(url(preview));
          if (!isStale()) leaveOut(error);
        }
        model?.free();
        model = undefined;
        if (isStale()) return;
      }
      model = await read(src);
      if (!isStale() && early && early !== model.vertexCount) leaveOut('it is of another model');
      if (!isStale() && !this.#head) await draw(model);
      // The head shows without, and the model takes the line.
      const [{ growHair }, { layFinework }, { createMarking }] = await Promise.all([
        part(() => import('../src/hair/onhead.js')),
        part(() => import('../src/head/finework.js')),
        part(() => import('../src/head/marking.js')),
      ]);
      if (isStale() || !this.#head || !this.#scene) return model.free();
      const [head, scene] = [this.#head, this.#scene];
      const come = () => {
        scene.shapeChanged();
        this.#reframe();
      };
      head.adorn(growHair, layFinework, createMarking, come, {
        come: () => part(() => import('../src/glasses/glasses.js')),
        onCome: come,
        onMiss: (why) => isStale() || this.#complain(new Error(text.noGlasses(sentence(why)))),
      });
      const wrong = this.#show(model, head, scene);
      for (const error of wrong) this.#complain(error);
      // Who hears of it may begin anew.
      if (isStale()) return;
      if (!early) this.#tell('face');
      if (isStale()) return;
      this.#tell('ready');
    } catch (error) {
      model?.free();
      // What came may have been something else, and may be right when it is asked for again.
      downloads.delete(url(src));
      if (isStale()) return;
      this.#live = null;
      this.#fail(error);
    }
  }

  /** The canvas, in its place. */
  #stage() {
    const canvas = element('canvas', { tabindex: 0, role: 'img', part: 'canvas', 'aria-label': elementStage });
    this.#frame.replaceChildren(canvas, this.#panel);
    return canvas;
  }

  /** The canvas is blank until the graphics card is back, which may be never where a page has too many of these. */
  #lose() {
    this.#lost.textContent = text.noCard;
    this.#frame.append(this.#lost);
    this.#complain(new Error(text.noCard));
  }

  /** @param {View['scene']} scene */
  #furnish(scene) {
    const canvas = scene.renderer.domElement;
    this.#listening = new AbortController();
    const { signal } = this.#listening;
    scene.beforeFrame.add(() => this.#ownBackdrop(scene));
    canvas.addEventListener('dblclick', () => scene.view('front'), { signal });
    listenToKeys(canvas, scene, { signal });
    canvas.addEventListener('webglcontextlost', () => this.#lose(), { signal });
    canvas.addEventListener(
      'webglcontextrestored',
      () => {
        this.#lost.remove();
        scene.shapeChanged();
      },
      { signal },
    );
    shareGestures(canvas, { isTaken: () => this.shadowRoot?.activeElement === canvas, signal });
  }

  /**
   * @param {import('phiz').FaceModel} model @param {Live['head']} head @param {Live['scene']} scene
   * @returns what of all that was asked for is none: the face shows without
   */
  #show(model, head, scene) {
    const face = model.face();
    this.#live = { model, face, median: face.code, head, scene, sliders: new Map() };
    this.#expressive = false;
    /** @type {unknown[]} */
    const wrong = [];
    const attempt = (/** @type {() => void} */ apply) => {
      try {
        apply();
      } catch (error) {
        wrong.push(error);
      }
    };
    const { code, colours } = { ...this.#asked, ...this.#kept };
    const isAsked = code === this.#asked.code;
    attempt(() => {
      if (code) face.code = code;
      if (isAsked) this.#came.code = face.code;
    });
    attempt(() => {
      const painted = coloursOf(colours);
      head.paint(painted);
      if (colours === this.#asked.colours) this.#came.colours = painted;
    });
    head.update(face);
    scene.shapeChanged();
    scene.refine(true);
    attempt(() => this.#buildPanel(this.getAttribute('controls')));
    this.#paint();
    return wrong;
  }

  #stop() {
    this.#listening.abort();
    this.#head?.dispose();
    this.#scene?.dispose();
    this.#live?.model.free();
    this.#head = this.#scene = this.#live = null;
    this.#panel.replaceChildren();
    this.#frame.replaceChildren();
    delete this.#box.dataset.face;
  }

  #theme() {
    const asked = this.getAttribute('theme');
    if (asked === 'light' || asked === 'dark') return asked;
    return this.#dark.matches ? 'dark' : 'light';
  }

  #paint() {
    this.#dress();
    this.#scene?.invalidate();
  }
  /** Its look is no attribute of its own: pages have those, and styles that go by them. */
  #dress() {
    // A document that nobody shows has no sheets to give.
    if (this.shadowRoot && this.ownerDocument.defaultView) this.shadowRoot.adoptedStyleSheets = sheetsFor(this.ownerDocument)[this.#theme()];
  }

  /** Elements on one page share the wall's colours and size; each sets its own before it draws. */
  #ownBackdrop(/** @type {View['scene']} */ scene) {
    paintBackdrop(this.#theme());
    scene.renderer.getDrawingBufferSize(backdropUniforms.backdropSize.value);
  }

  /** @param {string | null} asked as the attribute has them @throws when it has what is none: then they are those without it */
  #buildPanel(asked) {
    const { model } = this.#need();
    try {
      this.#layPanel(chosenControls(model, asked));
    } catch (error) {
      this.#layPanel(chosenControls(model, null));
      throw error;
    }
  }

  /** @param {readonly import('phiz').Control[]} controls */
  #layPanel(controls) {
    const { sliders } = this.#need();
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
        try {
          this.#slide(control.name, input.valueAsNumber);
        } catch (error) {
          // What is locked may make it impossible: the slider is where the face is.
          this.#readSliders();
          this.#complain(error);
          return;
        }
        this.#tell('input');
      });
      input.addEventListener('change', (event) => {
        event.stopPropagation();
        this.#tell('change');
      });
      input.addEventListener('keydown', (event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const to = steppedTo(event, input.valueAsNumber, STEP, control.limits);
        if (to === null) return;
        event.preventDefault();
        input.valueAsNumber = to;
        for (const type of ['input', 'change']) input.dispatchEvent(new Event(type));
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

// Of two copies of this file the first that came is the element, whatever their addresses.
if (!customElements.get('phiz-designer')) customElements.define('phiz-designer', PhizDesigner);
else console.warn(`<phiz-designer> is there already: ${import.meta.url} is not used`);
