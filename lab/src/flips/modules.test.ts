import { readFileSync } from 'node:fs';

import { beforeAll, describe, expect, it } from 'vitest';

import * as portable from '../../wasm/flips.js';
import * as inRegisters from '../../wasm/flips_simd128.js';

/** The chapter's arm, and the map's step [s]. */
const ARM = [1, 2, 1, 1, 9.81, 0.01] as const;

beforeAll(() => {
  portable.initSync({ module: readFileSync(new URL('../../wasm/flips_bg.wasm', import.meta.url)) });
  inRegisters.initSync({ module: readFileSync(new URL('../../wasm/flips_simd128_bg.wasm', import.meta.url)) });
});

/** q₁, q₂ of a square grid over all angles. */
function starts(across: number): Float64Array {
  const angle = (k: number): number => Math.PI * ((2 * k + 1) / across - 1);
  return Float64Array.from({ length: 2 * across * across }, (_, i) => {
    const [column, row] = [(i >> 1) % across, Math.floor((i >> 1) / across)];
    return i % 2 === 0 ? angle(column) - Math.PI / 2 : angle(row) - angle(column);
  });
}

describe('the two modules of the flips', () => {
  it('find the same flips, arms side by side or one at a time', () => {
    const [one, four] = [new portable.FlipMap(...ARM), new inRegisters.FlipMap(...ARM)];
    expect([one.lanes, four.lanes]).toEqual([1, 4]);
    const all = starts(24);
    const [alone, together] = [one.firstFlips(all, 20), four.firstFlips(all, 20)];
    // Neither has a fused multiply-add, so that even chaotic results are equal.
    expect(together).toEqual(alone);
    expect(four.steps).toBe(one.steps);
    const flipped = alone.filter((time) => time >= 0).length;
    expect(flipped).toBeGreaterThan(100);
    expect(alone.filter((time) => time === -2).length).toBeGreaterThan(100);
  });
});
