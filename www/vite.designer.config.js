import { cpSync, readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vite';
import { packageAlias } from './vite.config.js';

const here = (/** @type {string} */ path) => fileURLToPath(new URL(path, import.meta.url));

/**
 * The package's types for who has the element alone: of what would be imported from it as a value there is nothing in that folder.
 * @param {string} types
 */
function typesAlone(types) {
  const classes = Array.from(types.matchAll(/^export class (\w+)/gm), ([, name]) => name);
  return `${types.replaceAll(/^export (?=function|class)/gm, 'declare ')}\nexport type { ${classes.join(', ')} };\n`;
}

/**
 * `<phiz-designer>` as a folder of its own, `dist/designer`, whose one script has a name that pages
 * can rely on; and the examples that need no build, which are copied.
 */
export default defineConfig({
  base: './',
  publicDir: false,
  resolve: { alias: packageAlias },
  worker: { format: 'es' },
  build: {
    target: 'es2022',
    outDir: 'dist/designer',
    emptyOutDir: true,
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 900,
    modulePreload: false,
    rolldownOptions: {
      input: here('designer/phiz-designer.js'),
      preserveEntrySignatures: 'strict',
      output: {
        entryFileNames: 'phiz-designer.js',
        chunkFileNames: '[name]-[hash].js',
        assetFileNames: '[name]-[hash][extname]',
      },
    },
  },
  plugins: [
    {
      name: 'types-and-plain-examples',
      closeBundle() {
        // Who copies the folder has no package of that name.
        const types = readFileSync(here('designer/types.d.ts'), 'utf8').replace("'phiz'", "'./phiz.js'");
        writeFileSync(here('dist/designer/phiz-designer.d.ts'), types);
        writeFileSync(here('dist/designer/phiz.d.ts'), typesAlone(readFileSync(here('phiz/index.d.ts'), 'utf8')));
        for (const name of ['examples/plain', 'examples/contact-sheet', 'examples/index.html', 'examples/examples.css']) {
          cpSync(here(name), here(`dist/${name}`), { recursive: true });
        }
      },
    },
  ],
});
