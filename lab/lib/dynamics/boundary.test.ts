import { beforeAll, describe, expect, it } from 'vitest';

import { Brick, FallingArm, KnifeEdge, Race, integratorNames } from './index.ts';
import { loadFromDisk, loadRobotsFromDisk } from './load-from-disk.ts';
import { PolarMass, Reach2R } from './models.ts';

beforeAll(loadFromDisk);

/** A call with a missing argument, as JavaScript allows. */
const missing = ([] as number[])[0]!;

describe('the boundary', () => {
  it('refuses what is missing or not finite, by name', () => {
    expect(() => Reach2R.uniform(1, missing, 1, 1, 9.81)).toThrow(/mass 1/);
    expect(() => Reach2R.uniform(1, 2, -1, 1, 9.81)).toThrow(/length 2/);
    expect(() => Reach2R.workedExample().mass([0, NaN])).toThrow(/q\[1\]/);
    expect(() => Reach2R.workedExample().mass([0])).toThrow(/q .*2/);
    expect(() => { new FallingArm(1, 2, 1, 1, 9.81).setMethod('rk5', 1e-3); }).toThrow(/rk5.*rk4/);
    expect(() => new Brick(0.3, 0, 0.1, 1000)).toThrow();
    expect(() => { new KnifeEdge(2, 0.5, 0.25).setForces(1, Infinity, 0); }).toThrow(/right force/);
    expect(() => new Race(['rk4'], Float64Array.of(0, 0), Float64Array.of(0, 0), 0, 1)).toThrow(/step/);
  });

  it('says where a mass matrix is singular', () => {
    expect(() => PolarMass.of(2).forward([0, 0], [1, 1], [0, 0])).toThrow(/coordinate 1/);
  });

  it('rejects an invalid robot file with a reason', () => {
    const { Robot } = loadRobotsFromDisk();
    expect(() => Robot.load('', false, false)).toThrow();
    expect(() => Robot.load('<sdf/>', false, false)).toThrow(/model/);
    expect(() => Robot.load('<robot name="r"><link name="a"></robot>', false, false)).toThrow(/line 1/);
  });

  it('writes names of files as text on one line', () => {
    const robots = loadRobotsFromDisk();
    const name = '=x\t\n<script>\u202e"';
    const attribute = name.replace(/\t/g, '&#9;').replace(/\n/g, '&#10;').replace(/</g, '&lt;').replace(/"/g, '&quot;');
    const robot = robots.Robot.load(
      `<mujoco model="${attribute}"><worldbody><body name="${attribute}"><joint name="${attribute}"/><geom size="0.1" unknown="1"/>`
      + `</body></worldbody><actuator><motor name="${attribute}" joint="${attribute}"/></actuator>`
      + `<keyframe><key name="${attribute}"/></keyframe></mujoco>`, false, false);
    const text = '=x\\t\\n<script>\\u{202e}"';
    expect(robot.name).toBe(text);
    expect(robot.fileName).toBe('_x___script___');
    expect([robot.coordinates()[0]!.name, robot.actuators()[0]!.name, robot.namedPoses()[0]!.name]).toEqual([text, text, text]);
    expect(robot.bodies().map((body) => body.name)).toContain(text);
    // Four fields per line, whatever a name contains.
    expect(robot.report().map((line) => line.split('\t').length)).toEqual(robot.report().map(() => 4));
    expect(robots.oneLine(name)).toBe(text);
    robot.free();
    const broken = '<mujoco><worldbody><body name="a&#10;\u202e"><joint type="none"/></body></worldbody></mujoco>';
    expect(() => robots.Robot.load(broken, false, false)).toThrow(/^[^\u202e]*$/);
  });

  it('is still there after every refusal', () => {
    expect(Reach2R.workedExample().mass([0, 0])[0]![0]).toBeCloseTo(3, 12);
    expect(integratorNames()).toContain('rk4');
  });

  it('stops a blown-up run with its last good state', () => {
    const arm = new FallingArm(1, 2, 1, 1, 9.81);
    arm.place(Float64Array.of(0.5, 0.5), Float64Array.of(1e150, 1e150));
    expect(() => { arm.advance(1000); }).toThrow();
    expect(arm.q.every(Number.isFinite)).toBe(true);
    arm.free();
  });
});
