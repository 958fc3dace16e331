import { readFileSync } from 'node:fs';

import { beforeAll, describe, expect, it } from 'vitest';

import { loadRobotsFromDisk, loadRobotsInRegistersFromDisk } from './load-from-disk.ts';
import type { Robot, Robots } from './robots.ts';

/** A run of `testdata/same_motion`, whose README describes the fields. */
interface Run {
  name: string;
  file: string;
  floating_base?: boolean;
  pose?: string | Record<string, number | number[]>;
  velocity?: Record<string, number>;
  controls?: Record<string, number>;
  method?: string;
  conservative?: boolean;
  without?: string[];
  ground?: boolean;
  step: number;
  steps: number;
  rounding?: number;
}

/** The effects that `conservative` switches off. */
const LOSSY = ['dissipation', 'limits', 'effort-limits', 'actuators', 'contacts'];

/** Tolerance: WebAssembly has its own sine and no fused multiply-add, and a run may magnify the differences.
 */
const ROUNDING = 1e-9;

const text = (path: string): string => readFileSync(new URL(`../../../${path}`, import.meta.url), 'utf8');
const runs = JSON.parse(text('testdata/same_motion/runs.json')) as Run[];
const table = new Map(text('testdata/same_motion/states.tsv').trimEnd().split('\n').map((line) => {
  const [name, numbers] = line.split('\t') as [string, string];
  return [name, numbers.split(' ').map(Number)] as const;
}));

let builds: Record<'portable' | 'simd128', Robots>;
beforeAll(() => {
  builds = { portable: loadRobotsFromDisk(), simd128: loadRobotsInRegistersFromDisk() };
});

describe.each(['portable', 'simd128'] as const)('the lab’s module, %s, takes the library’s steps', (build) => {
  it.each(runs.map((run) => [run.name, run] as const))('%s', (name, run) => {
    const robot = started(builds[build], run);
    robot.advance(run.steps);
    const found = [...robot.q, ...robot.v];
    robot.free();
    const expected = table.get(name)!;
    expect(found.length).toBe(expected.length);
    const size = Math.max(1, ...expected.map(Math.abs));
    const off = Math.max(...found.map((x, i) => Math.abs(x - expected[i]!)));
    expect(off / size).toBeLessThanOrEqual(run.rounding ?? ROUNDING);
  });
});

function started(robots: Robots, run: Run): Robot {
  const robot = robots.Robot.load(text(`robots/${run.file}`), run.floating_base ?? false, false);
  robot.choose(run.method ?? '', run.step, [...(run.conservative === true ? LOSSY : []), ...(run.without ?? [])]);
  robot.setGround(run.ground ?? false);
  let { q, v } = robot;
  let controls = new Float64Array(robot.actuators().length);
  if (typeof run.pose === 'string') {
    const pose = robot.namedPoses().find(({ name }) => name === run.pose)!;
    [q, v] = [pose.q, pose.v];
    if (pose.controls.length > 0) controls = Float64Array.from(pose.controls);
  }
  const coordinates = robot.coordinates();
  for (const [joint, value] of Object.entries(typeof run.pose === 'object' ? run.pose : {})) {
    // A joint with several numbers is the base, which is first.
    if (typeof value === 'object') q.set(value);
    else q[coordinates.find(({ name }) => name === joint)!.place!] = value;
  }
  for (const [joint, value] of Object.entries(run.velocity ?? {})) v[coordinates.findIndex(({ name }) => name === joint)] = value;
  const names = robot.actuators().map(({ name }) => name);
  for (const [actuator, value] of Object.entries(run.controls ?? {})) controls[names.indexOf(actuator)] = value;
  robot.placeMoving(q, v);
  robot.setControls(controls);
  return robot;
}
