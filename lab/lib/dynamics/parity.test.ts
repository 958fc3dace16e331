import { readFileSync } from 'node:fs';

import { beforeAll, describe, expect, it } from 'vitest';

import { engine } from './engine.ts';
import { loadFromDisk, loadRobotsFromDisk } from './load-from-disk.ts';

let computed: string[] = [];

beforeAll(() => {
  loadFromDisk();
  computed = [...engine.parityValues(), ...loadRobotsFromDisk().robotParityValues()];
});

/** Sines differ by a last bit between the two builds; half a second of falling magnifies it. */
const TOLERANCE = 1e-12;

const golden = readFileSync(new URL('./native-values.tsv', import.meta.url), 'utf8').trimEnd().split('\n');

describe('WebAssembly computes what the native build computes', () => {
  it.each(golden.map((line, index) => [line.split('\t')[0]!, index] as const))('%s', (name, index) => {
    const [, kind, expected] = fields(golden[index]!);
    const [foundName, , found] = fields(computed[index]!);
    expect(foundName).toBe(name);
    expect(found.length).toBe(expected.length);
    found.forEach((value, i) => {
      if (kind === 'exact') expect(value).toBe(expected[i]);
      else expect(Math.abs(value - expected[i]!)).toBeLessThanOrEqual(TOLERANCE * Math.max(1, Math.abs(value)));
    });
  });
});

function fields(line: string): [string, string, number[]] {
  const [name, kind, numbers] = line.split('\t') as [string, string, string];
  return [name, kind, numbers.split(' ').map(Number)];
}
