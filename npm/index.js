// For browsers and bundlers: fetches the module from beside this file.
import { hasSimd128 } from './simd128.js';

let loading;

/** Loads the module once. After a failure the next call tries again. */
export function load() {
  loading ??= fetchModule().catch((error) => {
    loading = undefined;
    throw error;
  });
  return loading;
}

async function fetchModule() {
  if (hasSimd128()) {
    const robots = await import('./module/robots_simd128.js');
    await robots.default({ module_or_path: new URL('./module/robots_simd128_bg.wasm', import.meta.url) });
    return robots;
  }
  const robots = await import('./module/robots.js');
  await robots.default({ module_or_path: new URL('./module/robots_bg.wasm', import.meta.url) });
  return robots;
}
