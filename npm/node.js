// For Node.js: reads the module from the file beside this one.
import { readFile } from 'node:fs/promises';

import { hasSimd128 } from './simd128.js';

let loading;

/** Loads the module once. After a failure the next call tries again. */
export function load() {
  loading ??= readModule(hasSimd128() ? 'robots_simd128' : 'robots').catch((error) => {
    loading = undefined;
    throw error;
  });
  return loading;
}

async function readModule(name) {
  const robots = await import(`./module/${name}.js`);
  await robots.default({ module_or_path: await readFile(new URL(`./module/${name}_bg.wasm`, import.meta.url)) });
  return robots;
}
