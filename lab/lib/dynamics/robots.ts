// Robots from files: a second module of the library, larger than the chapter's, fetched when the first robot is asked for.
import type * as module from '../../wasm/robots.js';

export type Robots = typeof module;
export type Robot = module.Robot;

let loading: Promise<Robots> | undefined;

/** The module, loaded once from an address; where that failed, the next call tries again. */
export function loadRobots(address: string | URL): Promise<Robots> {
  loading ??= fetchFrom(address).catch((error: unknown) => {
    loading = undefined;
    throw error;
  });
  return loading;
}

async function fetchFrom(address: string | URL): Promise<Robots> {
  const robots = await import('../../wasm/robots.js');
  await robots.default({ module_or_path: address });
  return robots;
}
