import { describe, expect, it } from 'vitest';

import { Accumulator } from './clock.ts';

describe('the accumulator', () => {
  it('takes as many steps as real time allows, whatever the frame rate', () => {
    for (const rate of [24, 60, 144]) {
      const clock = new Accumulator();
      let steps = 0;
      for (let frame = 0; frame < 10 * rate; frame += 1) steps += clock.steps(1 / rate, 1, 1e-3);
      expect(Math.abs(steps - 10_000)).toBeLessThanOrEqual(1);
    }
  });

  it('keeps the remainder of a frame shorter than a step', () => {
    const clock = new Accumulator();
    expect([1, 2, 3, 4].map(() => clock.steps(0.004, 1, 0.01))).toEqual([0, 0, 1, 0]);
  });

  it('forgets a long pause', () => {
    const clock = new Accumulator();
    expect(clock.steps(3600, 1, 1e-3)).toBe(100);
    expect(clock.steps(0, 1, 1e-3)).toBe(0);
  });

  it('gives up time rather than freeze on a tiny step', () => {
    const clock = new Accumulator();
    expect(clock.steps(0.1, 4, 1e-6)).toBe(4000);
    expect(clock.steps(0, 4, 1e-6)).toBe(0);
  });

  it('plays at any speed', () => {
    const clock = new Accumulator();
    let steps = 0;
    for (let frame = 0; frame < 100; frame += 1) steps += clock.steps(0.01, 0.25, 1e-3);
    expect(Math.abs(steps - 250)).toBeLessThanOrEqual(1);
  });
});
