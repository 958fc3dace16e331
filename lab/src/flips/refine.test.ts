import { describe, expect, it } from 'vitest';

import { fill, portions } from './refine.ts';

describe('a picture computed coarsely first', () => {
  it('has every point once, and 1/64 of them in the first stride', () => {
    const all = [...portions(64, 100)];
    const seen = all.flatMap(({ points }) => [...points]);
    expect(new Set(seen).size).toBe(64 * 64);
    expect(seen.length).toBe(64 * 64);
    expect(all.filter(({ stride }) => stride === 8).flatMap(({ points }) => [...points]).length).toBe(64);
    const strides = all.map(({ stride }) => stride);
    expect(strides).toEqual([...strides].sort((a, b) => b - a));
  });

  it('fills blocks, cut off at its edge, around what is known', () => {
    const pixels = new Uint32Array(16);
    fill(pixels, 4, 4 * 2 + 2, 8, 7, (pixel) => pixel === 11);
    expect([...pixels]).toEqual([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7, 0, 0, 0, 7, 7]);
  });
});
