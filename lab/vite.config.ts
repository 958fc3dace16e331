import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

import { equations } from './build/equations.ts';
import { mathFont } from './build/math-font.ts';

// Two builds: a site (relative addresses, so it can live in any folder) and one file that opens without a server.
export default defineConfig(({ mode }) => {
  const single = mode === 'single';
  return {
    base: './',
    plugins: [equations(), mathFont(), ...(single ? [viteSingleFile()] : [])],
    build: {
      target: 'es2022',
      outDir: single ? 'dist/single' : 'dist/site',
      assetsInlineLimit: single ? Number.MAX_SAFE_INTEGER : 0,
      modulePreload: false,
    },
    // A module in a worker is refused where the page is a file.
    worker: { format: 'iife' },
    test: { include: ['lib/**/*.test.ts', 'src/**/*.test.ts'] },
  };
});
