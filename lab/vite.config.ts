import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

import { equations } from './build/equations.ts';
import { mathFont } from './build/math-font.ts';

// Two builds: a site with relative addresses, for any folder, and one file that opens without a server.
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
    // Browsers refuse module workers on pages opened as a file.
    worker: { format: 'iife' },
    test: { include: ['lib/**/*.test.ts', 'src/**/*.test.ts'] },
  };
});
