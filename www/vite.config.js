import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vite';
import { FACE_MESH, faceMesh } from './facemesh.js';

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

/** @param {string} name */
const page = (name) => fileURLToPath(new URL(`${name}/index.html`, import.meta.url));

export default defineConfig({
  // Relative, so that the site works under any path.
  base: './',
  resolve: {
    alias: packageAlias,
  },
  define: { __FACE_MESH__: JSON.stringify(FACE_MESH) },
  server: { fs: { allow: ['..'] } },
  // The package in a worker loads its modules as a page's does.
  worker: { format: 'es' },
  build: {
    target: 'es2022',
    // A data: URL would need a wider policy.
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 900,
    modulePreload: { polyfill: false },
    rolldownOptions: {
      input: { index: page('.'), three: page('examples/three'), crowd: page('examples/crowd') },
    },
  },
  plugins: [
    faceMesh(),
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
  ],
});
