import './offline.css';
import { element } from '../frame/element.js';
import { text } from '../text.js';

/**
 * Keeps the page for visits without a network, and offers a new version when there is one. Only who takes it is
 * given it: the address holds the whole face, but not what can be undone, nor a photo, and a tab beside this one
 * may have them.
 */
export async function keepOffline() {
  // There is none on an insecure origin, in some private windows, and during development.
  if (!('serviceWorker' in navigator) || import.meta.env.DEV) return;
  const { serviceWorker } = navigator;
  let controlled = serviceWorker.controller !== null;
  let taken = false;
  /** @type {ServiceWorkerRegistration} */
  let registration;
  const offer = () => {
    const take = () => {
      taken = true;
      // Another tab may have let it take over meanwhile.
      if (registration.waiting) registration.waiting.postMessage('take over');
      else location.reload();
    };
    if (!document.querySelector('.update')) document.body.append(offering(take));
  };
  serviceWorker.addEventListener('controllerchange', () => {
    if (taken) location.reload();
    // The first worker takes over a page that is as new as itself.
    else if (controlled) offer();
    controlled = true;
  });
  try {
    registration = await serviceWorker.register(new URL('service-worker.js', document.baseURI));
  } catch (error) {
    // The page works without it, and a browser may forbid it.
    console.info(`phiz is not kept for offline use: ${error instanceof Error ? error.message : error}`);
    return;
  }
  serviceWorker.controller?.postMessage('shown');
  const offered = () => {
    if (registration.waiting && serviceWorker.controller) offer();
  };
  offered();
  registration.addEventListener('updatefound', () => {
    registration.installing?.addEventListener('statechange', offered);
  });
}

/** @param {() => void} take */
function offering(take) {
  return element(
    'div',
    { class: 'update', role: 'status' },
    text.newVersion,
    element('button', { type: 'button', class: 'button primary', onclick: take }, text.takeNewVersion),
  );
}
