// The page without a network. `precache.js` puts the built files and their digests in here.
//
// Libraries for this fetch files that have no digest in their name anew; a first visit would load
// the model twice. This asks the browser's own cache first and looks at the digest.

/** @type {Record<string, string>} SHA-256 by path; `./` is the page. */
const FILES = /* precache */ {};
/** @type {Record<string, string>} What only some visits take, such as photos: kept once it was asked for. */
const LATER = /* later */ {};

const worker = /** @type {ServiceWorkerGlobalScope} */ (/** @type {unknown} */ (self));
// Other sites may live on the same origin.
const CACHE = `phiz ${worker.registration.scope}`;
/** What was asked for of `LATER`, and the other model. */
const MORE = `phiz more ${worker.registration.scope}`;
/** What a new version does not have, for as long as a window shows an earlier one: what that asks for late is on the site no longer. */
const EARLIER = `phiz earlier ${worker.registration.scope}`;
/** In it, the ids of those windows. */
const WINDOWS = new URL('windows', worker.registration.scope).href;

/** A file is kept by its digest, so what a new version did not change is not loaded again. */
const keyOf = (/** @type {string} */ path) => new URL(`${path}?sha256=${FILES[path] ?? LATER[path]}`, worker.registration.scope).href;

/** @param {Response} response */
async function digestOf(response) {
  const digest = await crypto.subtle.digest('SHA-256', await response.arrayBuffer());
  return Array.from(new Uint8Array(digest), (byte) => byte.toString(16).padStart(2, '0')).join('');
}

async function install() {
  const cache = await caches.open(CACHE);
  for (const path of Object.keys(FILES)) {
    if (await cache.match(keyOf(path))) continue;
    const response = await fetch(new URL(path, worker.registration.scope), { cache: 'no-cache' });
    if (!response.ok || response.redirected) throw new Error(`${path}: ${response.status}`);
    // A site that is being replaced: the next visit tries again.
    if ((await digestOf(response.clone())) !== FILES[path]) throw new Error(`${path} belongs to another version`);
    await cache.put(keyOf(path), response);
  }
}

/** The ids of the windows that show the page. */
async function windows() {
  const all = await worker.clients.matchAll({ type: 'window', includeUncontrolled: true });
  return all.filter(({ url }) => url.startsWith(worker.registration.scope)).map(({ id }) => id);
}

/** The ids of those that showed an earlier version when this one took over. @returns {Promise<string[]>} */
async function windowsOfEarlier() {
  const kept = await caches.match(WINDOWS, { cacheName: EARLIER });
  return kept ? kept.json() : [];
}

/** Once nobody is left who could ask for it. */
async function forgetEarlier() {
  const open = await windows();
  if (!(await windowsOfEarlier()).some((id) => open.includes(id))) await caches.delete(EARLIER);
}

/** What an earlier version had under that address. @param {Request} request */
const earlier = ({ url }) => caches.match(url, { cacheName: EARLIER, ignoreSearch: true });

async function activate() {
  await forgetEarlier();
  const open = await windows();
  for (const [name, wanted] of /** @type {const} */ ([[CACHE, FILES], [MORE, LATER]])) {
    const cache = await caches.open(name);
    const kept = new Set(Object.keys(wanted).map(keyOf));
    for (const { url } of await cache.keys()) {
      if (kept.has(url) || !url.includes('?sha256=')) continue;
      const old = await cache.match(url);
      if (old && open.length > 0) {
        const aside = await caches.open(EARLIER);
        // Where there is no room, who updates is not held up.
        await aside.put(WINDOWS, new Response(JSON.stringify(open))).then(() => aside.put(url, old)).catch(() => {});
      }
      await cache.delete(url);
    }
  }
  // The first visit is served from now on too.
  await worker.clients.claim();
}

/**
 * Keeps a copy of an answer beside it: nobody waits for it, and where storage is full nobody misses it.
 * @param {FetchEvent} event @param {Response} response @param {(copy: Response) => Promise<unknown>} keep
 */
function copied(event, response, keep) {
  if (response.ok) event.waitUntil(keep(response.clone()).catch(() => {}));
  return response;
}

/** @param {FetchEvent} event @param {string} path */
async function answer(event, path) {
  const { request } = event;
  // Names without a digest are in both: a window of an earlier version has that version's, until it goes to the page anew.
  if (request.mode !== 'navigate' && (await windowsOfEarlier()).includes(event.clientId)) {
    const own = await earlier(request);
    if (own) return own;
  }
  if (Object.hasOwn(FILES, path)) {
    const cached = await (await caches.open(CACHE)).match(keyOf(path));
    // A browser that is short of room may have thrown it away.
    return cached ?? fetch(request);
  }
  const more = await caches.open(MORE);
  if (Object.hasOwn(LATER, path)) {
    const cached = await more.match(keyOf(path));
    if (cached) return cached;
    return copied(event, await fetch(request), async (copy) => {
      // The browser's own copy may be of an older site, and then it is of another digest.
      if ((await digestOf(copy.clone())) === LATER[path]) await more.put(keyOf(path), copy);
    });
  }
  try {
    return copied(event, await fetch(request), (copy) => more.put(request, copy));
  } catch (error) {
    const cached = await more.match(request);
    if (cached) return cached;
    throw error;
  }
}

worker.addEventListener('install', (event) => event.waitUntil(install()));
worker.addEventListener('activate', (event) => event.waitUntil(activate()));
worker.addEventListener('message', (event) => {
  // A new version waits until the pages of the old one are closed, or a person asks for it.
  if (event.data === 'take over') worker.skipWaiting();
  // Of the new one, maybe in place of the last of an earlier one.
  if (event.data === 'shown') event.waitUntil(forgetEarlier());
});
worker.addEventListener('fetch', (event) => {
  const { request } = event;
  const { origin, pathname } = new URL(request.url);
  const scope = new URL(worker.registration.scope);
  if (request.method !== 'GET' || origin !== scope.origin || !pathname.startsWith(scope.pathname)) return;
  const path = pathname.slice(scope.pathname.length);
  const name = path === '' || path === 'index.html' ? './' : path;
  if (Object.hasOwn(FILES, name) || Object.hasOwn(LATER, name) || name.endsWith('.phiz')) event.respondWith(answer(event, name));
  else if (request.mode !== 'navigate') event.respondWith(earlier(request).then((old) => old ?? fetch(request)));
});
