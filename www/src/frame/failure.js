import { element } from './element.js';
import { text } from '../text.js';

/** A failure whose message is written for the person in front of the page. */
export class Failure extends Error {}

/** @param {unknown} error */
export function showFailure(error) {
  const sentence = error instanceof Error ? error.message : String(error);
  document.body.replaceChildren(
    element(
      'main',
      { class: 'failure', role: 'alert' },
      element('h1', {}, text.failed),
      element('p', {}, sentence),
      element('button', { type: 'button', class: 'button', onclick: () => location.reload() }, text.reload),
    ),
  );
}
