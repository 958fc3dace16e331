// For tests in Node: the modules beside this folder.
import { readFileSync } from 'node:fs';

import * as robots from '../../wasm/robots.js';
import { loadBytes } from './engine.ts';

export function loadFromDisk(): void {
  loadBytes(bytes('chapter'));
}

export function loadRobotsFromDisk(): typeof robots {
  robots.initSync({ module: bytes('robots') });
  return robots;
}

function bytes(name: string): BufferSource {
  return readFileSync(new URL(`../../wasm/${name}_bg.wasm`, import.meta.url));
}
