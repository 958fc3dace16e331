// The Lagrangian lab: hang the arm, drag it to a pose, let go, and watch the energy keep its line.
import { numberFrom, wordFrom } from '../address.ts';
import { choice, toggle } from '../controls/choice.ts';
import { handle } from '../controls/handle.ts';
import { slider } from '../controls/slider.ts';
import { transport } from '../controls/transport.ts';
import { bars } from '../drawing/bars.ts';
import { armDrawing, armPoints, planarPicture, polyline, type Point } from '../drawing/planar-arm.ts';
import { plot } from '../drawing/plot.ts';
import { readings } from '../drawing/readings.ts';
import { html, scientific, set, show, svg } from '../element.ts';
import { FallingArm, rows, type IntegratorName } from '../../lib/dynamics/index.ts';
import { frame, type Widget } from './frame.ts';
import { INTEGRATORS } from './integrators.ts';
import { wrap } from './angle.ts';

const START = [Math.PI / 4, Math.PI / 2];
const METHODS = INTEGRATORS.map(([name]) => name);

export function lagrangianLab(): Widget {
  const arm = new FallingArm(1, 2, 1, 1, 9.81);
  let pose = [...START];
  let method: IntegratorName = 'rk4';
  let h = 1e-3;

  const picture = planarPicture('A two-link arm; drag the elbow or the tip', 2.25);
  const drawing = armDrawing();
  const trail = svg('path', { class: 'trail' });
  const put = (q1: number, q2: number): void => {
    pose = [wrap(q1), wrap(q2)];
    arm.place(Float64Array.from(pose), Float64Array.of(0, 0));
    clock.say('');
    draw();
  };
  const hold = (): void => {
    clock.pause();
    const [q1, q2] = arm.q as unknown as [number, number];
    put(q1, q2);
  };
  const grip = { min: -3.142, max: 3.142, nudge: Math.PI / 36, radius: 0.075, unit: 'rad', onGrab: hold, onRelease: () => { clock.play(); } };
  const elbow = handle({
    ...grip,
    label: 'q1, the first joint',
    onDrag: (x, y) => { put(Math.atan2(-y, x), pose[1]!); },
    onNudge: (by) => { hold(); put(pose[0]! + by, pose[1]!); },
  });
  const tip = handle({
    ...grip,
    label: 'q2, the second joint',
    onDrag: (x, y) => {
      const [ex, ey] = arm.points as unknown as Point;
      put(pose[0]!, Math.atan2(-y - ey, x - ex) - pose[0]!);
    },
    onNudge: (by) => { hold(); put(pose[0]!, pose[1]! + by); },
  });
  picture.plane.append(trail, drawing.element, elbow.element, tip.element);

  const energies = bars('Energies', [
    { name: 'K', unit: 'J', tone: 'second' },
    { name: 'V', unit: 'J', tone: 'muted' },
    { name: 'E', unit: 'J', tone: 'accent' },
  ]);
  const forces = [1, 2].map((joint) =>
    bars(`Torques of joint ${String(joint)}`, [
      { name: `M q̈`, unit: 'N·m', tone: 'second' },
      { name: `C q̇`, unit: 'N·m', tone: 'accent' },
      { name: `g`, unit: 'N·m', tone: 'muted' },
      { name: 'sum', unit: 'N·m', tone: 'ink' },
    ], 2),
  );
  const joints = [0, 1].map((joint) =>
    slider({
      label: `q${'₁₂'[joint]!}`, unit: 'rad', min: -3.142, max: 3.142, step: 0.01, value: START[joint]!,
      onInput: (value) => {
        hold();
        put(joint === 0 ? value : pose[0]!, joint === 1 ? value : pose[1]!);
      },
    }),
  );
  const numbers = readings('State', [
    ['t', 't', 's'], ['q1', 'q₁', 'rad'], ['q2', 'q₂', 'rad'], ['E', 'E', 'J'], ['error', '(E − E₀)/|E₀|', ''], ['drift', 'largest so far', ''],
  ]);
  const errorPlot = plot({ title: '|E − E₀|/|E₀|', unit: 'log scale', lines: [{ name: 'energy error', tone: 'accent' }], logFrom: 1e-16, height: 140 });
  const energyPlot = plot({
    title: 'Energy', unit: 'J',
    lines: [{ name: 'K', tone: 'second' }, { name: 'V', tone: 'muted', dashed: true }, { name: 'E', tone: 'accent' }],
    height: 140,
  });

  const draw = (): void => {
    const points = armPoints(arm.points);
    const q = arm.q;
    drawing.draw(points);
    joints.forEach((one, i) => { one.set(wrap(q[i]!)); });
    elbow.place(points[1]![0], -points[1]![1], wrap(q[0]!));
    tip.place(points[2]![0], -points[2]![1], wrap(q[1]!));
    const samples = rows(arm.samples(), 6);
    set(trail, { d: polyline(samples.slice(-100).map(([, x, y]) => [x!, y!])) });
    const [k, v, e, e0] = arm.energies as unknown as [number, number, number, number];
    energies.draw([k, v, e], Math.max(35, 1.2 * Math.abs(e)), e0);
    const stack = arm.torqueStack();
    forces.forEach((bar, joint) => {
      const terms = [stack[joint]!, stack[2 + joint]!, stack[4 + joint]!];
      bar.draw([...terms, terms.reduce((sum, term) => sum + term, 0)], 60);
    });
    const time = samples.map((row) => row[0]!);
    energyPlot.draw(time, [samples.map((r) => r[3]!), samples.map((r) => r[4]!), samples.map((r) => r[3]! + r[4]!)]);
    errorPlot.draw(time, [samples.map((r) => Math.abs(r[5]!))]);
    numbers.draw({
      t: show(arm.time, 2), q1: show(wrap(q[0]!)), q2: show(wrap(q[1]!)), E: show(e, 4),
      error: scientific(arm.relativeError), drift: scientific(arm.drift),
    });
  };

  const clock = transport({
    step: () => h,
    advance: (steps) => { arm.advance(steps); },
    draw,
    reset: () => { put(START[0]!, START[1]!); },
    describe: () => `Paused at ${show(arm.time, 2)} seconds, energy ${show(arm.energies[2]!, 3)} joules.`,
    single: 10,
  }, true);
  const chooseMethod = (name: IntegratorName, step: number): void => {
    [method, h] = [name, step];
    arm.setMethod(method, h);
  };
  const integrator = choice('Integrator', INTEGRATORS, method, (name) => { chooseMethod(name, h); });
  const stepLength = slider({ label: 'Step h', unit: 'ms', min: 0.1, max: 50, step: 0.1, value: 1, onInput: (ms) => { chooseMethod(method, ms / 1000); } });
  const coriolis = toggle('Coriolis forces C q̇', true, (on) => { arm.setCoriolis(on); });

  const element = frame({
    id: 'lagrangian-lab',
    title: 'Lagrangian lab',
    lede: 'Drag the elbow or the tip, let go, and the arm falls. K and V trade places; their sum E must stay on its line. Now switch C q̇ off: a small lie, and E leaves its line at once.',
    picture: [picture.element],
    controls: [
      clock.element,
      html('div', { class: 'settings' }, ...joints.map((one) => one.element), integrator.element, stepLength.element, coriolis.element),
      numbers.element,
      html('h3', {}, 'Energy'), energies.element,
      html('h3', {}, 'Joint 1: M q̈ + C q̇ + g = 0'), forces[0]!.element,
      html('h3', {}, 'Joint 2'), forces[1]!.element,
    ],
    below: [html('div', { class: 'plots' }, energyPlot.element, errorPlot.element)],
    equations: [
      { name: 'motion', code: 'Dynamics::try_forward', says: 'let go: no torque' },
      { name: 'energy', code: 'Dynamics::energy', says: 'the line to keep' },
      { name: 'christoffel', code: 'dynamics::christoffel', says: 'C q̇ is made of derivatives of M' },
    ],
    share: () => ({ q1: arm.q[0]!, q2: arm.q[1]!, v1: arm.qd[0]!, v2: arm.qd[1]!, method, h, coriolis: coriolis.on ? 1 : 0 }),
  });
  put(START[0]!, START[1]!);
  return {
    id: 'lagrangian-lab',
    title: 'Lagrangian lab',
    element,
    restore(values) {
      chooseMethod(wordFrom(values, 'method', METHODS, 'rk4'), Math.max(1e-4, numberFrom(values, 'h', 1e-3)));
      integrator.set(method);
      stepLength.set(h * 1000);
      coriolis.set(numberFrom(values, 'coriolis', 1) !== 0);
      arm.setCoriolis(coriolis.on);
      clock.pause();
      put(numberFrom(values, 'q1', START[0]!), numberFrom(values, 'q2', START[1]!));
      arm.place(Float64Array.from(pose), Float64Array.of(numberFrom(values, 'v1', 0), numberFrom(values, 'v2', 0)));
      draw();
    },
  };
}
