import { element } from '../frame/element.js';
import { among } from '../head/expression.js';
import { fitting } from './legend.js';
import { text } from '../text.js';

// A contact sheet: faces side by side with their names.

/** A picture, pixels; more than a portrait on the page has. */
const [WIDTH, HEIGHT] = [288, 352];
const GAP = 24;
const LETTER = 22;
/** How many are taken between two frames, as the page shows. */
const BATCH = 4;

/**
 * @param {readonly import('./library.js').Entry[]} faces
 * @param {import('phiz').FaceModel} model
 * @param {import('../stage/display.js').Display} display
 * @param {HTMLCanvasElement} stage in a corner of which they are drawn
 * @returns {Promise<Blob>} a PNG
 */
export async function sheetOf(faces, model, display, stage) {
  const columns = Math.min(faces.length, Math.max(3, Math.ceil(Math.sqrt(faces.length))));
  const rows = Math.ceil(faces.length / columns);
  const line = HEIGHT + 2 * LETTER + GAP;
  const sheet = element('canvas', { width: GAP + columns * (WIDTH + GAP), height: GAP + rows * line });
  const context = sheet.getContext('2d');
  if (!context) throw new Error(text.noPicture);
  context.fillStyle = '#ffffff';
  context.fillRect(0, 0, sheet.width, sheet.height);
  context.fillStyle = '#1e2124';
  context.font = `${LETTER}px ui-sans-serif, system-ui, sans-serif`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  const part = Math.min(1, stage.width / WIDTH, stage.height / HEIGHT);
  const size = { width: Math.floor(part * WIDTH), height: Math.floor(part * HEIGHT) };
  const sitter = model.face();
  try {
    for (let first = 0; first < faces.length; first += BATCH) {
      const some = faces.slice(first, first + BATCH).map(({ name, code, expression = {}, colouring = {} }) => ({
        name,
        into: element('canvas', size),
        pose() {
          sitter.code = code;
          sitter.expression = among(expression, model.expressions);
          return { face: sitter, colouring };
        },
      }));
      if (!display.portraits(some)) throw new Error(text.noCard);
      some.forEach(({ name, into }, i) => {
        const [x, y] = [GAP + ((first + i) % columns) * (WIDTH + GAP), GAP + Math.floor((first + i) / columns) * line];
        context.drawImage(into, x, y, WIDTH, HEIGHT);
        context.fillText(fitting(context, name, WIDTH), x + WIDTH / 2, y + HEIGHT + LETTER);
      });
      await new Promise(requestAnimationFrame);
    }
  } finally {
    sitter.free();
  }
  return new Promise((done, fail) => {
    sheet.toBlob((blob) => (blob ? done(blob) : fail(new Error(text.noPicture))), 'image/png');
  });
}
