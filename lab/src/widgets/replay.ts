// Replay: one path at variable speed. A path has no torques; a trajectory has.
import { numberFrom } from '../address.ts';
import { button, buttonRow } from '../controls/choice.ts';
import { slider } from '../controls/slider.ts';
import { transport } from '../controls/transport.ts';
import { gauge } from '../drawing/gauge.ts';
import { armDrawing, armPoints, planarPicture, polyline, type Point } from '../drawing/planar-arm.ts';
import { plot } from '../drawing/plot.ts';
import { plotGroup } from '../drawing/plot-group.ts';
import { readings } from '../drawing/readings.ts';
import { torus } from '../drawing/torus.ts';
import { html, set, show, svg } from '../element.ts';
import { columns, Replay, rows, tuple } from '../../lib/dynamics/index.ts';
import { frame, type Widget } from './frame.ts';

/** Time step of the picture in seconds; torques are computed at any point of the path. */
const STEP = 1 / 480;

export function replay(): Widget {
  const motion = new Replay();
  const [limit1, limit2] = tuple(motion.limits, 2);
  let times = 1;
  let turn = 0;
  let begun = 0;

  const picture = planarPicture('The arm on its path', 1.4, [-0.2, -0.8]);
  const drawing = armDrawing();
  const path = svg('path', { class: 'trail' });
  picture.plane.append(path, drawing.element);
  const square = torus('The path on the torus of joint angles');
  const gauges = [gauge('Joint 1', 'N·m', limit1), gauge('Joint 2', 'N·m', limit2)];
  const plots = plotGroup();
  const torquePlot = plot({
    group: plots,
    title: 'Torque over one loop', unit: 'N·m',
    lines: [{ name: 'τ₁', tone: 'accent' }, { name: 'τ₂', tone: 'second' }],
    marks: [[limit1, '+20'], [-limit1, '−20'], [limit2, '+12'], [-limit2, '−12']].map(([value, name]) => ({
      value: Number(value), name: String(name),
    })),
    atLeast: [-22, 22],
    height: 190,
  });
  const numbers = readings('Speed and torque', [
    ['peak1', 'peak |τ₁|', 'N·m'], ['peak2', 'peak |τ₂|', 'N·m'], ['loop', 'one loop', 's'], ['fastest', 'largest within limits', '×'],
  ]);
  const path2: Point[] = rows(motion.loopSamples(1, 240), 7).map((row) => [row[3]!, row[4]!]);
  set(path, { d: polyline(path2, true) });
  square.path(rows(motion.loopSamples(1, 240), 7).map((row) => [row[1]!, row[2]!]));

  let peaks: readonly number[] = [];
  const setSpeed = (value: number): void => {
    times = value;
    peaks = Array.from(motion.peakTorque(times));
    const [t, , , , , tau1, tau2] = columns(motion.loopSamples(times, 240), 7);
    torquePlot.draw(t!, [tau1!, tau2!]);
    numbers.draw({
      peak1: show(peaks[0]!, 1), peak2: show(peaks[1]!, 1), loop: show(motion.duration / times, 2),
      fastest: show(motion.fastestSpeed(), 2),
    });
    for (const [one, at] of presets) one.setAttribute('aria-pressed', String(Math.abs(at - times) < 1e-9));
    draw();
  };
  const draw = (beat = 0): void => {
    const pose = motion.pose(turn);
    drawing.draw(armPoints(pose.subarray(2)));
    square.point(pose[0]!, pose[1]!);
    const torque = motion.torque(turn, times);
    if (beat % 2 === 0) gauges.forEach((one, joint) => { one.draw(torque[joint]!, peaks[joint]!); });
  };
  const clock = transport({
    step: () => STEP,
    advance: (steps) => { turn = (turn + (steps * STEP * times) / motion.duration) % 1; },
    draw,
    reset: () => { turn = begun; },
    describe: () => `Paused at ${show(100 * turn, 0)} per cent of the loop, played ${show(times, 2)} times as fast.`,
    single: 20,
  }, true);
  const pace = slider({ label: 'Replay at', unit: '×', min: 0.25, max: 2.5, step: 0.05, value: 1, onInput: setSpeed });
  const presets = [1, 2].map((at) => [button(`${String(at)}×`, () => { pace.set(at); setSpeed(at); }), at] as const);

  const element = frame({
    id: 'replay',
    picture: [picture.element, html('div', { class: 'gauges' }, ...gauges.map((one) => one.element))],
    controls: [
      clock.element,
      html('div', { class: 'settings' }, buttonRow('Replay speed', ...presets.map(([one]) => one)), pace.element),
      numbers.element,
      html('h3', {}, 'The same path as a closed curve of joint angles'),
      square.element,
    ],
    below: [html('div', { class: 'plots' }, torquePlot.element)],
    plots,
    equations: [
      { name: 'path', code: 'PathDynamics::torque', says: 'the arm constrained to its path' },
      { name: 'faster', code: 'PathDynamics::motion_torque', says: 'k times faster, k² the torque' },
    ],
    share: () => ({ times, turn, ...clock.shared() }),
  });
  setSpeed(1);
  return {
    id: 'replay',
    element,
    restore(values) {
      begun = ((numberFrom(values, 'turn', 0) % 1) + 1) % 1;
      turn = begun;
      clock.restore(values);
      pace.set(Math.min(2.5, Math.max(0.25, numberFrom(values, 'times', 1))));
      clock.pause();
      setSpeed(pace.value);
    },
  };
}
