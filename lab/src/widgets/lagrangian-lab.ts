// The Lagrangian lab: drag an arm to a pose, release it, and compare its energy with a constant.
import { numberFrom, wordFrom } from '../address.ts';
import { button, buttonRow, choice, toggle } from '../controls/choice.ts';
import { handle } from '../controls/handle.ts';
import { slider } from '../controls/slider.ts';
import { transport } from '../controls/transport.ts';
import { bars } from '../drawing/bars.ts';
import { legend } from '../drawing/legend.ts';
import { mechanism } from '../drawing/mechanism.ts';
import { armDrawing, armPoints, planarPicture } from '../drawing/planar-arm.ts';
import { plot } from '../drawing/plot.ts';
import { plotGroup } from '../drawing/plot-group.ts';
import { readings } from '../drawing/readings.ts';
import { lightTerms } from '../drawing/terms.ts';
import { html, scientific, show } from '../element.ts';
import { columns, FallingArm, tuple, type IntegratorName, type Tuple } from '../../lib/dynamics/index.ts';
import { fork } from './fork.ts';
import { frame, type Widget } from './frame.ts';
import { INTEGRATORS } from './integrators.ts';
import { rodSliders } from './rods.ts';
import { wrap } from './angle.ts';

const START: Tuple<2> = [Math.PI / 4, Math.PI / 2];
const METHODS = INTEGRATORS.map(([name]) => name);
/** Torque at the full width of a bar [N·m], unless a larger one occurs. */
const TORQUE = 60;

export function lagrangianLab(): Widget {
  const arm = new FallingArm(1, 2, 1, 1, 9.81);
  /** The state in which the arm was released. */
  let pose: Tuple<2> = [...START];
  let speeds: Tuple<2> = [0, 0];
  let method: IntegratorName = 'rk4';
  let h = 1e-3;
  let widest = TORQUE;

  const picture = planarPicture('A two-link arm; drag the elbow or the tip', 2.25);
  const drawing = armDrawing();
  const felt = mechanism(2);
  const layers = legend(felt, () => { draw(); }, ['weights', 'mass'], 'u − b');
  const then = armDrawing('thin muted');
  then.element.setAttribute('visibility', 'hidden');
  picture.plane.prepend(then.element);
  /** The arm at a time of the plots. */
  const plots = plotGroup((t) => {
    then.element.setAttribute('visibility', t === undefined ? 'hidden' : 'visible');
    if (t === undefined) return;
    const [times, , , , , , q1, q2] = columns(arm.samples(), 8);
    const k = Math.max(0, times!.findIndex((time) => time >= t));
    then.draw(armPoints(arm.pointsAt(q1![k]!, q2![k]!)));
  });
  const errorPlot = plot({
    group: plots,
    title: '|E − E₀|/|E₀|', unit: 'log scale', lines: [{ name: 'energy error', tone: 'accent' }], logFrom: 1e-16, height: 140,
  });
  const energyPlot = plot({
    group: plots,
    title: 'Energy', unit: 'J',
    lines: [{ name: 'K', tone: 'second' }, { name: 'V', tone: 'muted', dashed: true }, { name: 'E', tone: 'accent' }],
    height: 140,
  });
  const forked = fork(() => arm, () => ({ name: method, h }), () => { draw(); }, plots);
  const place = (): void => {
    arm.place(Float64Array.from(pose), Float64Array.from(speeds));
    widest = TORQUE;
    forked.end();
    clock.say('');
    draw();
  };
  const put = (q1: number, q2: number): void => {
    [pose, speeds] = [[wrap(q1), wrap(q2)], [0, 0]];
    place();
  };
  const hold = (): void => {
    clock.pause();
    put(...tuple(arm.q, 2));
  };
  const grip = {
    min: -3.142, max: 3.142, nudge: Math.PI / 36, radius: 0.075, doubled: true, unit: 'rad',
    onGrab: hold, onRelease: () => { clock.play(); },
  };
  const elbow = handle({
    ...grip,
    label: 'q1, the first joint',
    onDrag: (x, y) => { put(Math.atan2(-y, x), pose[1]); },
    onNudge: (by) => { hold(); put(pose[0] + by, pose[1]); },
  });
  const tip = handle({
    ...grip,
    label: 'q2, the second joint',
    onDrag: (x, y) => {
      const [ex, ey] = tuple(arm.points, 4);
      put(pose[0], Math.atan2(-y - ey, x - ex) - pose[0]);
    },
    onNudge: (by) => { hold(); put(pose[0], pose[1] + by); },
  });
  picture.plane.append(felt.under, forked.ghost, drawing.element, felt.over, elbow.element, tip.element);

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
      { name: `b`, unit: 'N·m', tone: 'muted' },
      { name: 'sum', unit: 'N·m', tone: 'ink' },
    ], 2),
  );
  const joints = ([0, 1] as const).map((joint) =>
    slider({
      label: `q${'₁₂'[joint]!}`, unit: 'rad', min: -3.142, max: 3.142, step: 0.01, value: START[joint],
      onInput: (value) => {
        hold();
        put(joint === 0 ? value : pose[0], joint === 1 ? value : pose[1]);
      },
    }),
  );
  const numbers = readings('State', [
    ['t', 't', 's'], ['q1', 'q₁', 'rad'], ['q2', 'q₂', 'rad'], ['E', 'E', 'J'],
    ['error', '(E − E₀)/|E₀|', ''], ['drift', 'largest so far', ''],
  ]);
  const draw = (beat = 0): void => {
    const points = armPoints(arm.points);
    const q = arm.q;
    const [q1, q2] = [wrap(q[0]!), wrap(q[1]!)];
    drawing.draw(points);
    elbow.place(points[1]![0], -points[1]![1], q1);
    tip.place(points[2]![0], -points[2]![1], q2);
    const stack = arm.torqueStack();
    felt.draw({
      points, q: [q1, q2], weights: () => arm.weights, stack: () => [...stack.subarray(0, 6), ...driving(stack)],
      mobility: () => arm.tipMobility(),
    }, beat);
    if (beat % 6 === 1 || beat === 0) drawEnergies(stack);
    if (beat % 6 === 3 || beat === 0) drawPast();
    forked.draw(beat);
    if (beat % 6 !== 0) return;
    [q1, q2].forEach((value, i) => { joints[i]!.set(value); });
    numbers.draw({
      t: show(arm.time, 2), q1: show(q1), q2: show(q2), E: show(arm.energies.total, 4),
      error: scientific(arm.relativeError), drift: scientific(arm.drift),
    });
  };
  /** The sum of the first three terms: the motors' torques minus friction. */
  const driving = (stack: Float64Array): number[] => rods.torque.map((u, joint) => u - stack[6 + joint]!);
  const drawEnergies = (stack: Float64Array): void => {
    const { kinetic, potential, total, start, most } = arm.energies;
    energies.draw([kinetic, potential, total], 1.05 * Math.max(most, Math.abs(total)), start + arm.work - arm.dissipated);
    const terms = [0, 1].map((joint) => [0, 2, 4, 6].map((term) => stack[term + joint]!));
    widest = Math.max(widest, ...terms.flat().map((term) => 1.1 * Math.abs(term)));
    forces.forEach((bar, joint) => { bar.draw([...terms[joint]!, terms[joint]!.reduce((sum, term) => sum + term, 0)], widest); });
  };
  const drawPast = (): void => {
    const [t, x, y, k, v, error] = columns(arm.samples(), 8);
    felt.past(x!.subarray(-150), y!.subarray(-150));
    energyPlot.draw(t!, [k!, v!, k!.map((kinetic, i) => kinetic + v![i]!)]);
    errorPlot.draw(t!, [error!.map(Math.abs)]);
  };

  const clock = transport({
    step: () => h,
    advance: (steps) => {
      arm.advance(steps);
      forked.advance(steps);
    },
    draw,
    reset: place,
    describe: () => `Paused at ${show(arm.time, 2)} seconds, energy ${show(arm.energies.total, 3)} joules.`,
    single: 10,
  }, true);
  const chooseMethod = (name: IntegratorName, step: number): void => {
    [method, h] = [name, step];
    arm.setMethod(method, h);
  };
  const integrator = choice('Integrator', INTEGRATORS, method, (name) => { chooseMethod(name, h); });
  const stepLength = slider({
    label: 'Step h', unit: 'ms', min: 0.1, max: 50, step: 0.1, value: 1, onInput: (ms) => { chooseMethod(method, ms / 1000); },
  });
  const coriolis = toggle('Coriolis forces C q̇', true, (on) => { arm.setCoriolis(on); });
  const rods = rodSliders(() => {
    arm.setRods(...rods.rods);
    forked.end();
    draw();
  }, () => {
    arm.setTorque(...rods.torque);
    arm.setDamping(rods.damping);
    draw();
  });
  const poses = buttonRow('Poses', ...([
    ['Worked example', ...START], ['Stretched', 0, 0], ['Upright, almost', Math.PI / 2 - 0.01, 0],
  ] as const).map(([name, q1, q2]) => button(name, () => { clock.pause(); put(q1, q2); })));

  const element = frame({
    id: 'lagrangian-lab',
    picture: [picture.element, layers.element],
    controls: [
      clock.element,
      html('div', { class: 'settings' },
        poses, ...joints.map((one) => one.element), integrator.element, stepLength.element, coriolis.element,
        rods.element),
      forked.controls,
      numbers.element,
      html('h3', {}, 'Energy'), energies.element,
      html('h3', {}, 'Joint 1: M q̈ + C q̇ + g + b = u'), forces[0]!.element,
      html('h3', {}, 'Joint 2'), forces[1]!.element,
    ],
    below: [html('div', { class: 'plots' }, energyPlot.element, errorPlot.element, ...forked.plots)],
    equations: [
      { name: 'motion-damped', code: 'Dynamics::try_forward', says: 'released, u = 0; without damping, b = 0' },
      { name: 'energy', code: 'Dynamics::energy', says: 'constant without torque and damping' },
      { name: 'christoffel', code: 'dynamics::christoffel', says: 'C q̇ consists of derivatives of M' },
    ],
    plots,
    share: () => {
      const [[q1, q2], [v1, v2]] = [tuple(arm.q, 2), tuple(arm.qd, 2)];
      return { q1, q2, v1, v2, method, h, coriolis: coriolis.on ? 1 : 0,
        ...rods.shared(), ...layers.shared(), ...clock.shared(), ...forked.shared() };
    },
  });
  lightTerms(element);
  place();
  return {
    id: 'lagrangian-lab',
    element,
    restore(values) {
      const step = Math.min(0.05, Math.max(1e-4, numberFrom(values, 'h', 1e-3)));
      chooseMethod(wordFrom(values, 'method', METHODS, 'rk4'), step);
      integrator.set(method);
      stepLength.set(h * 1000);
      coriolis.set(numberFrom(values, 'coriolis', 1) !== 0);
      arm.setCoriolis(coriolis.on);
      rods.restore(values);
      layers.restore(values);
      clock.restore(values);
      clock.pause();
      pose = [wrap(numberFrom(values, 'q1', START[0])), wrap(numberFrom(values, 'q2', START[1]))];
      speeds = [numberFrom(values, 'v1', 0), numberFrom(values, 'v2', 0)];
      place();
      forked.restore(values);
      draw();
    },
  };
}
