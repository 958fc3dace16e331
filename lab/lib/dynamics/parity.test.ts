import { readFileSync } from 'node:fs';

import { beforeAll, describe, expect, it } from 'vitest';

import { engine } from './engine.ts';
import { loadFromDisk, loadRobotsFromDisk, loadRobotsInRegistersFromDisk } from './load-from-disk.ts';
import type { Robots } from './robots.ts';

/** Files, and whether the root link floats, as in `crates/wasm/tests/parity.rs`. */
const ROBOTS = [['two_r', false], ['panda', false], ['humanoid', true]] as const;

/**
 * Relative to a line's largest number. The builds' sines differ in the last bit, and some have a fused
 * multiply-add. Half a second of falling, or the condition of a mass matrix, magnifies that.
 */
const TOLERANCE = 1e-12;

const golden = readFileSync(new URL('./native-values.tsv', import.meta.url), 'utf8').trimEnd().split('\n');
let builds: Record<'portable' | 'simd128', string[]>;

beforeAll(() => {
  loadFromDisk();
  const values = (robots: Robots): string[] => [
    ...engine.parityValues(), ...ROBOTS.flatMap(([name, floats]) => robots.robotParityValues(file(name), floats)),
  ];
  builds = { portable: values(loadRobotsFromDisk()), simd128: values(loadRobotsInRegistersFromDisk()) };
});

describe.each(['portable', 'simd128'] as const)('WebAssembly, %s, computes what the native build computes', (build) => {
  it.each(golden.map((line, index) => [line.split('\t')[0]!, index] as const))('%s', (_, index) => {
    compare(builds[build][index]!, golden[index]!);
  });

  it('and nothing more', () => {
    expect(builds[build].length).toBe(golden.length);
  });
});

describe('the two modules of the robots', () => {
  it('are two: sines and sums round differently', () => {
    expect(builds.simd128).not.toEqual(builds.portable);
  });

  it.each(golden.map((line, index) => [line.split('\t')[0]!, index] as const))('agree on %s', (_, index) => {
    compare(builds.simd128[index]!, builds.portable[index]!);
  });
});

function compare(line: string, reference: string): void {
  const [name, kind, expected] = fields(reference);
  const [foundName, , found] = fields(line);
  expect(foundName).toBe(name);
  expect(found.length).toBe(expected.length);
  const size = Math.max(1, ...expected.map(Math.abs));
  found.forEach((value, i) => {
    if (kind === 'exact') expect(value).toBe(expected[i]);
    else expect(Math.abs(value - expected[i]!)).toBeLessThanOrEqual(TOLERANCE * size);
  });
}

function fields(line: string): [string, string, number[]] {
  const [name, kind, numbers] = line.split('\t') as [string, string, string];
  return [name, kind, numbers.split(' ').map(Number)];
}

function file(robot: string): string {
  return readFileSync(new URL(`../../../robots/${robot}.urdf`, import.meta.url), 'utf8');
}
