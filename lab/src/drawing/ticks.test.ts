import { describe, expect, it } from 'vitest';

import { digitsOf, linearTicks, logTicks } from './ticks.ts';

describe('ticks', () => {
  it('are round numbers within the range', () => {
    expect(linearTicks(-0.3, 1.1, 4).map((tick) => tick.text)).toEqual(['0.0', '0.5', '1.0']);
    expect(linearTicks(0, 600, 4).map((tick) => tick.value)).toEqual([0, 200, 400, 600]);
    expect(linearTicks(-20, 20, 4).map((tick) => tick.text)).toEqual(['−20', '−10', '0', '10', '20']);
  });

  it('are written with the digits that they have', () => {
    expect([5, 0.5, 0.25, 0.025, 2e-7, 0.1 + 0.2].map(digitsOf)).toEqual([0, 1, 2, 3, 7, 1]);
  });

  it('of a log axis are powers of ten', () => {
    expect(logTicks(-3, 0).map((tick) => tick.text)).toEqual(['10⁻³', '10⁻²', '10⁻¹', '1']);
    expect(logTicks(-16, 0).length).toBeLessThanOrEqual(6);
  });

  it('are missing for an empty or invalid range', () => {
    expect(linearTicks(1, 1, 4)).toEqual([]);
    expect(linearTicks(NaN, 1, 4)).toEqual([]);
  });
});
