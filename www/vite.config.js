import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vite';
import { FOLDERS, mediapipe } from './mediapipe.js';

// Only built pages carry the policy: the development server injects inline modules and styles.
const POLICY = [
  "default-src 'none'",
  "script-src 'self' 'wasm-unsafe-eval'",
  "style-src 'self'",
  "img-src 'self' data: blob:",
  "connect-src 'self'",
  "manifest-src 'self'",
  "base-uri 'none'",
  "form-action 'none'",
].join('; ');

/** The package by its name, as it was built. */
export const packageAlias = [
  { find: /^phiz$/, replacement: fileURLToPath(new URL('../pkg/index.js', import.meta.url)) },
  { find: /^phiz\/export$/, replacement: fileURLToPath(new URL('../pkg/export/index.js', import.meta.url)) },
];

/** What comes when somebody first wants it. */
const LATE = /(^|\/)(room|appearance|export|gif|video|legend|sheet|glasses)-[^/]*\.js$/;

/** @param {string} name */
const page = (name) => fileURLToPath(new URL(`${name}/index.html`, import.meta.url));

/**
 * What the first face takes beside what the page names: asked for with the page, not once its first
 * module has run.
 * @param {import('vite').Rolldown.OutputBundle} bundle
 */
function firstModules(bundle) {
  const chunks = Object.values(bundle).flatMap((file) => (file.type === 'chunk' ? [file] : []));
  /** @type {Set<string>} */
  const names = new Set();
  const add = (/** @type {string} */ name) => {
    if (names.has(name)) return;
    names.add(name);
    for (const other of chunks.find(({ fileName }) => fileName === name)?.imports ?? []) add(other);
  };
  for (const path of [/\/src\/stage\/stage\.js$/, /\/pkg\/simd\/phiz\.js$/]) {
    const found = chunks.find(({ moduleIds }) => moduleIds.some((id) => path.test(id)));
    if (!found) throw new Error(`no chunk has ${path}`);
    add(found.fileName);
  }
  return [...names];
}

export default defineConfig({
  // Relative, so that the site works under any path.
  base: './',
  resolve: {
    alias: packageAlias,
  },
  define: { __MEDIAPIPE__: JSON.stringify(FOLDERS) },
  server: { fs: { allow: ['..'] } },
  // The package in a worker loads its modules as a page's does.
  worker: { format: 'es' },
  build: {
    target: 'es2022',
    // A data: URL would need a wider policy.
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 900,
    modulePreload: {
      polyfill: false,
      // What a part that comes late is made of is not asked for beside it: where there is no connection, each would be a module that the
      // browser never asks for again.
      resolveDependencies: (name, parts) => (LATE.test(name) ? [] : parts),
    },
    rolldownOptions: {
      input: { index: page('.'), three: page('examples/three'), crowd: page('examples/crowd') },
    },
  },
  plugins: [
    mediapipe(),
    {
      name: 'content-security-policy',
      apply: 'build',
      transformIndexHtml: () => [
        {
          tag: 'meta',
          attrs: { 'http-equiv': 'Content-Security-Policy', content: POLICY },
          injectTo: 'head-prepend',
        },
      ],
    },
    {
      name: 'first-modules',
      apply: 'build',
      transformIndexHtml: {
        order: 'post',
        handler(html, { path, bundle }) {
          if (path !== '/index.html' || !bundle) return [];
          return firstModules(bundle)
            .filter((name) => !html.includes(name))
            .map((name) => ({
              tag: 'link',
              attrs: { rel: 'modulepreload', crossorigin: true, href: `./${name}` },
              injectTo: /** @type {const} */ ('head'),
            }));
        },
      },
    },
  ],
});
