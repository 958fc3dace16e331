// For tests in Node: loads the modules beside this folder.
import { readFileSync } from 'node:fs';

import * as robots from '../../wasm/robots.js';
import * as robotsInRegisters from '../../wasm/robots_simd128.js';
import { loadBytes } from './engine.ts';
import type { Robots } from './robots.ts';

export function loadFromDisk(): void {
  loadBytes(bytes('chapter'));
}

/** The module without vector registers. */
export function loadRobotsFromDisk(): Robots {
  robots.initSync({ module: bytes('robots') });
  return robots;
}

/** The module with vector registers. */
export function loadRobotsInRegistersFromDisk(): Robots {
  robotsInRegisters.initSync({ module: bytes('robots_simd128') });
  return robotsInRegisters;
}

function bytes(name: string): BufferSource {
  return readFileSync(new URL(`../../wasm/${name}_bg.wasm`, import.meta.url));
}
