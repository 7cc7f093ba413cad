import './offline.css';
import { element } from '../frame/element.js';
import { text } from '../text.js';

/**
 * Keeps the page for visits without a network, and offers a new version when there is one. Nothing
 * is lost by taking it: the address holds the whole face.
 */
export async function keepOffline() {
  // There is none on an insecure origin, in some private windows, and during development.
  if (!('serviceWorker' in navigator) || import.meta.env.DEV) return;
  const { serviceWorker } = navigator;
  let controlled = serviceWorker.controller !== null;
  serviceWorker.addEventListener('controllerchange', () => {
    // The first worker takes over a page that is as new as itself.
    if (controlled) location.reload();
    controlled = true;
  });
  /** @type {ServiceWorkerRegistration} */
  let registration;
  try {
    registration = await serviceWorker.register(new URL('service-worker.js', document.baseURI));
  } catch (error) {
    // The page works without it, and a browser may forbid it.
    console.info(`phiz is not kept for offline use: ${error instanceof Error ? error.message : error}`);
    return;
  }
  const offered = () => {
    const { waiting } = registration;
    if (waiting && serviceWorker.controller) offer(waiting);
  };
  offered();
  registration.addEventListener('updatefound', () => {
    registration.installing?.addEventListener('statechange', offered);
  });
}

/** @param {ServiceWorker} waiting */
function offer(waiting) {
  if (document.querySelector('.update')) return;
  document.body.append(
    element(
      'div',
      { class: 'update', role: 'status' },
      text.newVersion,
      element(
        'button',
        { type: 'button', class: 'button primary', onclick: () => waiting.postMessage('take over') },
        text.takeNewVersion,
      ),
    ),
  );
}
