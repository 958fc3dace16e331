// The workbench: hold a waypoint. Gains that are well damped for the folded arm oscillate for the stretched
// one, since M changes.
import { numberFrom } from '../address.ts';
import { button, buttonRow, toggle } from '../controls/choice.ts';
import { handle } from '../controls/handle.ts';
import { slider } from '../controls/slider.ts';
import { transport } from '../controls/transport.ts';
import { armDrawing, armPoints, planarPicture } from '../drawing/planar-arm.ts';
import { plot } from '../drawing/plot.ts';
import { plotGroup } from '../drawing/plot-group.ts';
import { readings } from '../drawing/readings.ts';
import { html, show } from '../element.ts';
import { columns, Workbench, type Tuple } from '../../lib/dynamics/index.ts';
import { wrap } from './angle.ts';
import { frame, type Widget } from './frame.ts';

const GAINS = [
  ['kp1', 'Kp, joint 1', 'N·m/rad', 0, 200, 1, 60], ['kd1', 'Kd, joint 1', 'N·m·s', 0, 60, 0.5, 11],
  ['kp2', 'Kp, joint 2', 'N·m/rad', 0, 200, 1, 60], ['kd2', 'Kd, joint 2', 'N·m·s', 0, 60, 0.5, 9],
  ['limit1', 'Limit 1', 'N·m', 0, 100, 1, 20], ['limit2', 'Limit 2', 'N·m', 0, 100, 1, 12],
] as const;
type Gain = (typeof GAINS)[number][0];

export function workbench(): Widget {
  let bench = new Workbench(true);
  let target: Tuple<2> = [Math.PI / 2, 0];
  /** Its initial state. */
  let from: Tuple<2> = [Math.PI / 2 - 0.3, 0];
  let speeds: Tuple<2> = [0, 0];

  const picture = planarPicture('The arm and its waypoint; drag the waypoint', 2.25);
  const drawing = armDrawing();
  const ghost = armDrawing('ghost');
  const grip = { min: -3.142, max: 3.142, nudge: Math.PI / 36, radius: 0.075, doubled: true, unit: 'rad' };
  const elbow = handle({
    ...grip, label: 'Waypoint of joint 1',
    onDrag: (x, y) => { aim(Math.atan2(-y, x), target[1]); },
    onNudge: (by) => { aim(target[0] + by, target[1]); },
  });
  const tip = handle({
    ...grip, label: 'Waypoint of joint 2',
    onDrag: (x, y) => {
      const points = bench.points;
      aim(target[0], Math.atan2(-y - points[5]!, x - points[4]!) - target[0]);
    },
    onNudge: (by) => { aim(target[0], target[1] + by); },
  });
  picture.plane.append(ghost.element, drawing.element, elbow.element, tip.element);

  const plots = plotGroup();
  const angles = plot({
    group: plots,
    title: 'Distance from the waypoint', unit: 'rad',
    lines: [{ name: 'q₁ − q₁*', tone: 'accent' }, { name: 'q₂ − q₂*', tone: 'second' }],
    atLeast: [-0.05, 0.05], height: 170,
  });
  const torques = plot({
    group: plots,
    title: 'Torque', unit: 'N·m', lines: [{ name: 'τ₁', tone: 'accent' }, { name: 'τ₂', tone: 'second' }],
    atLeast: [-12, 20], height: 170,
    marks: [{ value: 20, name: '20' }, { value: -12, name: '−12' }],
  });
  const numbers = readings('Hold', [
    ['m11', 'M₁₁ at the waypoint', 'kg·m²'], ['zeta', 'ζ of joint 1', ''],
    ['overshoot', 'overshoot', 'rad'], ['settles', 'settles in', 's'],
    ['tau1', 'τ₁', 'N·m'], ['peak1', 'peak', 'N·m'], ['tau2', 'τ₂', 'N·m'], ['peak2', 'peak', 'N·m'],
  ]);
  const warning = html('p', { class: 'message', role: 'status' });

  const control = (): void => {
    const value = (name: Gain): number => gains[name].value;
    bench.setTarget(Float64Array.from(target));
    const both = (name: 'kp' | 'kd' | 'limit'): Float64Array => Float64Array.of(value(`${name}1`), value(`${name}2`));
    bench.setControl(both('kp'), both('kd'), both('limit'));
    const { inertia, ratio, overshoot, settles } = bench.predict(Float64Array.from(from));
    numbers.draw({
      m11: show(inertia), zeta: show(ratio, 2), overshoot: show(overshoot, 3),
      settles: settles === undefined ? 'never' : show(settles, 2),
    });
    const weak = Array.from(bench.overloaded, (joint) => String(joint + 1));
    warning.textContent = weak.length === 0
      ? ''
      : `Joint ${weak.join(' and ')} cannot carry the arm’s weight there: the limit is below |g(q*)|.`;
    draw();
  };
  const gains = Object.fromEntries(
    GAINS.map(([key, label, unit, min, max, step, value]) => [key, slider({ label, unit, min, max, step, value, onInput: control })]),
  ) as Record<Gain, ReturnType<typeof slider>>;
  const start = (): void => {
    bench.placeMoving(Float64Array.from(from), Float64Array.from(speeds));
    control();
  };
  /** Sets a new waypoint; the arm moves there from its state. */
  const aim = (q1: number, q2: number): void => {
    target = [wrap(q1), wrap(q2)];
    control();
  };
  const scene = (name: string, q1: number, q2: number): HTMLElement =>
    button(name, () => {
      target = [q1, q2];
      [from, speeds] = [[q1 - 0.3, q2], [0, 0]];
      clock.say('');
      start();
      clock.play();
    });
  const gravity = toggle('Gravity', true, (on) => {
    const { q, qd } = bench;
    bench.free();
    bench = new Workbench(on);
    bench.placeMoving(q, qd);
    control();
  });

  const goals = ([0, 1] as const).map((joint) =>
    slider({
      label: `Waypoint q${'₁₂'[joint]!}`, unit: 'rad', min: -3.142, max: 3.142, step: 0.01, value: target[joint],
      onInput: (value) => { aim(joint === 0 ? value : target[0], joint === 1 ? value : target[1]); },
    }),
  );

  const draw = (beat = 0): void => {
    const p = bench.points;
    goals.forEach((goal, i) => { if (goal.value !== target[i]) goal.set(target[i]!); });
    drawing.draw(armPoints(p));
    ghost.draw(armPoints(p.subarray(4)));
    elbow.place(p[4]!, -p[5]!, target[0]);
    tip.place(p[6]!, -p[7]!, target[1]);
    if (beat % 3 === 0) {
      const [t, q1, q2, tau1, tau2] = columns(bench.samples(), 5);
      angles.draw(t!, [q1!.map((q) => q - target[0]), q2!.map((q) => q - target[1])]);
      torques.draw(t!, [tau1!, tau2!]);
    }
    if (beat % 6 !== 0) return;
    const { joint1, joint2, peak1, peak2 } = bench.torque;
    numbers.draw({ tau1: show(joint1, 2), tau2: show(joint2, 2), peak1: show(peak1, 2), peak2: show(peak2, 2) });
  };
  const clock = transport({
    step: () => bench.stepLength,
    advance: (steps) => { bench.advance(steps); },
    draw,
    reset: start,
    describe: () => `Paused at ${show(bench.time, 2)} seconds, ${show(bench.q[0]! - target[0], 3)} radians from the waypoint in joint 1.`,
    single: 10,
  }, true);

  const element = frame({
    id: 'workbench',
    picture: [picture.element],
    controls: [
      clock.element,
      html('div', { class: 'settings' },
        buttonRow('Waypoints',
          scene('Folded', Math.PI / 2, Math.PI), scene('Stretched', Math.PI / 2, 0), scene('Sideways', 0, 0)),
        ...goals.map((goal) => goal.element), gravity.element, ...GAINS.map(([key]) => gains[key].element)),
      warning,
      numbers.element,
    ],
    below: [html('div', { class: 'plots' }, angles.element, torques.element)],
    plots,
    equations: [
      { name: 'pd', code: 'PdHold::torque', says: 'limited to ± the limit' },
      { name: 'zeta', code: 'PdHold::damping_ratio', says: 'below 1 the arm oscillates; depends on M₁₁' },
    ],
    share: () => ({
      q1: bench.q[0]!, q2: bench.q[1]!, v1: bench.qd[0]!, v2: bench.qd[1]!, to1: target[0], to2: target[1], gravity: gravity.on ? 1 : 0,
      ...Object.fromEntries(GAINS.map(([key]) => [key, gains[key].value])), ...clock.shared(),
    }),
  });
  start();
  return {
    id: 'workbench', element,
    restore(values) {
      for (const [key, , , , , , usual] of GAINS) gains[key].set(Math.max(0, numberFrom(values, key, usual)));
      target = [numberFrom(values, 'to1', target[0]), numberFrom(values, 'to2', target[1])];
      from = [numberFrom(values, 'q1', from[0]), numberFrom(values, 'q2', from[1])];
      speeds = [numberFrom(values, 'v1', 0), numberFrom(values, 'v2', 0)];
      clock.restore(values);
      gravity.set(numberFrom(values, 'gravity', 1) !== 0);
      bench.free();
      bench = new Workbench(gravity.on);
      clock.pause();
      start();
    },
  };
}
