// For tests in Node: the module beside this folder.
import { readFileSync } from 'node:fs';

import { loadBytes } from './engine.ts';

export function loadFromDisk(): void {
  loadBytes(readFileSync(new URL('../../wasm/dynamics_bg.wasm', import.meta.url)));
}
