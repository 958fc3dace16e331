import { readFileSync } from 'node:fs';

import { describe, expect, it, vi } from 'vitest';

import { hasSimd128 } from './simd128.ts';

const module = (name: string): BufferSource => readFileSync(new URL(`../../wasm/${name}_bg.wasm`, import.meta.url));

describe('the choice of a module', () => {
  it('is made by whether the engine takes what it would have to', () => {
    expect(hasSimd128()).toBe(WebAssembly.validate(module('robots_simd128')));
    const refuse = vi.spyOn(WebAssembly, 'validate').mockReturnValue(false);
    expect(hasSimd128()).toBe(false);
    refuse.mockRestore();
  });
});
