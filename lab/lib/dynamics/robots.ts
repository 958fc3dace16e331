// Robots from files: a second, larger module of the library, loaded with the first robot.
import type * as module from '../../wasm/robots.js';
import { hasSimd128 } from './simd128.ts';

export type Robots = typeof module;
export type Robot = module.Robot;
export type RobotCoordinate = module.RobotCoordinate;
export type DrawnShape = module.DrawnShape;

/** Addresses of the module: without and with vector registers. */
export interface Addresses {
  portable: string | URL;
  simd128: string | URL | undefined;
}

let loading: Promise<Robots> | undefined;

/** Loads the module once. After a failure the next call tries again. */
export function loadRobots(addresses: Addresses): Promise<Robots> {
  loading ??= fetchFrom(addresses).catch((error: unknown) => {
    loading = undefined;
    throw error;
  });
  return loading;
}

async function fetchFrom({ portable, simd128 }: Addresses): Promise<Robots> {
  if (simd128 !== undefined && hasSimd128()) {
    const robots = await import('../../wasm/robots_simd128.js');
    await robots.default({ module_or_path: simd128 });
    return robots;
  }
  const robots = await import('../../wasm/robots.js');
  await robots.default({ module_or_path: portable });
  return robots;
}
