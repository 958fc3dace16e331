import { describe, expect, it } from 'vitest';

import { formatAddress, numberFrom, parseAddress, wordFrom } from './address.ts';

describe('the address', () => {
  it('returns what it was given', () => {
    const hash = formatAddress('lagrangian-lab', { q1: -0.7853982, method: 'rk4', h: 1e-3 });
    const { widget, values } = parseAddress(hash);
    expect(widget).toBe('lagrangian-lab');
    expect(numberFrom(values, 'q1', 0)).toBe(-0.7853982);
    expect(numberFrom(values, 'h', 0)).toBe(1e-3);
    expect(wordFrom(values, 'method', ['rk4', 'explicit-euler'], 'explicit-euler')).toBe('rk4');
  });

  it('falls back on what is missing, empty, or no number', () => {
    const { values } = parseAddress('#w?a=&b=x&c=Infinity&d=nonsense');
    for (const name of ['a', 'b', 'c', 'e']) expect(numberFrom(values, name, 7)).toBe(7);
    expect(wordFrom(values, 'd', ['one', 'two'], 'two')).toBe('two');
  });

  it('reads a bare anchor', () => {
    expect(parseAddress('#race').widget).toBe('race');
    expect(parseAddress('').widget).toBe('');
  });
});
