import { describe, expect, it } from 'vitest';

import { formatAddress, numbered, numberFrom, numbersFrom, pack, parseAddress, unpack, wordFrom } from './address.ts';

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

  it('carries lists', () => {
    const { values } = parseAddress(formatAddress('w', numbered('q', [0.25, -3, 1e-5])));
    expect([...numbersFrom(values, 'q', [7, 7, 7, 7])]).toEqual([0.25, -3, 1e-5, 7]);
  });

  it('carries a file, an eighth of its size', async () => {
    const link = (i: number): string => `<link name="link${String(i)}"><inertial><mass value="${String(i)}"/></inertial></link>\n`;
    const text = `<robot name="Größe">${Array.from({ length: 100 }, (_, i) => link(i)).join('')}</robot>`;
    const packed = await pack(text);
    expect(packed).toMatch(/^[\w-]+$/);
    expect(packed.length).toBeLessThan(text.length / 8);
    expect(await unpack(packed)).toBe(text);
    await expect(unpack('%%%')).rejects.toThrow();
  });
});
