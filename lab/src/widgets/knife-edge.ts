// The knife-edge: a chassis on two wheels that cannot slip sideways, and the constraint force.
import { numberFrom } from '../address.ts';
import { button, buttonRow } from '../controls/choice.ts';
import { handle } from '../controls/handle.ts';
import { slider } from '../controls/slider.ts';
import { transport } from '../controls/transport.ts';
import { arrow } from '../drawing/arrow.ts';
import { track } from '../drawing/planar-arm.ts';
import { plot } from '../drawing/plot.ts';
import { plotGroup } from '../drawing/plot-group.ts';
import { readings } from '../drawing/readings.ts';
import { html, scientific, set, show, svg } from '../element.ts';
import { columns, KnifeEdge, tuple } from '../../lib/dynamics/index.ts';
import { frame, type Widget } from './frame.ts';

const HALF_TRACK = 0.25;
/** Metres of arrow per newton. */
const PER_NEWTON = 0.25;
const MOST = 6;
/** Number of points of the trail: ten seconds. */
const TRAIL = 500;

export function knifeEdge(): Widget {
  const blade = new KnifeEdge(2, 0.5, HALF_TRACK);
  let start = { x: 0, y: 0, heading: 0.4, speed: 1.5, turning: 0.8 };

  const grid = svg('path', { class: 'grid', d: gridLines() });
  const trail = svg('path', { class: 'trail' });
  const chassis = svg('g', { class: 'chassis' },
    svg('rect', { x: -0.32, y: -0.19, width: 0.64, height: 0.38, rx: 0.06 }),
    svg('path', { class: 'nose', d: 'M0.18 -0.09L0.28 0L0.18 0.09' }),
    svg('rect', { class: 'wheel', x: -0.11, y: -HALF_TRACK - 0.035, width: 0.22, height: 0.07, rx: 0.02 }),
    svg('rect', { class: 'wheel', x: -0.11, y: HALF_TRACK - 0.035, width: 0.22, height: 0.07, rx: 0.02 }),
  );
  const side = arrow('accent', 'Aᵀλ', 0.14);
  const left = arrow('second', '', 0.1);
  const right = arrow('second', '', 0.1);
  const seen = 'The chassis from above, its trail, the forces of its wheels and of the floor';
  const picture = svg('svg', { class: 'plane', viewBox: '-2 -2 4 4', role: 'img', 'aria-label': seen },
    grid, trail, chassis, left.element, right.element, side.element);

  // The drive pad: up drives both wheels forward, right drives one forward and one back.
  const grip = handle({
    label: 'Drive pad', unit: 'N forwards', min: -MOST, max: MOST, nudge: 0.5, radius: 0.22, doubled: true,
    onDrag: (x, y) => { drive(-y * MOST, -x * MOST); },
    onNudge: (by, axis) => { drive(ahead + (axis === 'y' ? by : 0), around - (axis === 'x' ? by : 0)); },
  });
  const drives = 'Drive: up is forwards, sideways turns';
  const pad = svg('svg', { class: 'pad', viewBox: '-1.3 -1.3 2.6 2.6', role: 'group', 'aria-label': drives },
    svg('rect', { x: -1, y: -1, width: 2, height: 2, rx: 0.1 }), svg('path', { d: 'M-1 0H1M0 -1V1' }), grip.element);
  let ahead = 0;
  let around = 0;
  const drive = (forwards: number, turning: number): void => {
    ahead = Math.max(-MOST, Math.min(MOST, forwards));
    around = Math.max(-MOST, Math.min(MOST, turning));
    sliders.left.set((ahead - around) / 2);
    sliders.right.set((ahead + around) / 2);
    push();
  };
  const push = (): void => {
    [ahead, around] = [sliders.left.value + sliders.right.value, sliders.right.value - sliders.left.value];
    blade.setForces(sliders.left.value, sliders.right.value, sliders.side.value);
    blade.setDamping(sliders.drag.value);
    draw();
  };
  const force = (label: string): ReturnType<typeof slider> =>
    slider({ label, unit: 'N', min: -MOST, max: MOST, step: 0.1, value: 0, onInput: () => { push(); } });
  const sliders = {
    left: force('Left wheel'), right: force('Right wheel'), side: force('Side push'),
    drag: slider({
      label: 'Drag', unit: 'N·s/m', min: 0, max: 2, step: 0.05, value: 0, onInput: () => { push(); },
    }),
  };
  const numbers = readings('State', [
    ['t', 't', 's'], ['v', 'forward speed', 'm/s'], ['turn', 'turning', 'rad/s'],
    ['lambda', 'λ', 'N'], ['slip', 'A q̇', 'm/s'], ['mv', '−m v θ̇', 'N'],
    ['K', 'K', 'J'], ['work', 'work done', 'J'], ['off', 'residual', 'J'],
  ]);
  const plots = plotGroup();
  const lambdaPlot = plot({
    group: plots, title: 'Side force λ', unit: 'N', lines: [{ name: 'λ', tone: 'accent' }], atLeast: [-3, 3], height: 150,
  });
  const speedPlot = plot({
    group: plots, title: 'Forward speed', unit: 'm/s', lines: [{ name: 'v', tone: 'second' }], atLeast: [0, 2], height: 150,
  });

  const place = (): void => {
    blade.place(Float64Array.of(start.x, start.y, start.heading), start.speed, start.turning);
    draw();
  };
  const draw = (beat = 0): void => {
    const [x, y, heading] = tuple(blade.q, 3);
    const degrees = (-heading * 180) / Math.PI;
    set(picture, { viewBox: `${(x - 2).toFixed(4)} ${(-y - 2).toFixed(4)} 4 4` });
    set(grid, { transform: `translate(${String(Math.round(2 * x) / 2)} ${String(Math.round(-2 * y) / 2)})` });
    set(chassis, { transform: `translate(${x.toFixed(4)} ${(-y).toFixed(4)}) rotate(${degrees.toFixed(3)})` });
    const [fx, fy] = tuple(blade.constraintForce, 3);
    side.draw([x, -y], [x + fx * PER_NEWTON, -y - fy * PER_NEWTON]);
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    const [lx, ly, rx, ry] = tuple(blade.hubs, 4);
    ([[left, sliders.left.value, lx, ly], [right, sliders.right.value, rx, ry]] as const).forEach(([one, newtons, hx, hy]) => {
      one.draw([hx, -hy], [hx + newtons * PER_NEWTON * c, -hy - newtons * PER_NEWTON * s]);
    });
    grip.place(-around / MOST, -ahead / MOST, ahead);
    if (beat % 3 === 0) {
      const [t, px, py, , v, lambda] = columns(blade.samples(), 6);
      set(trail, { d: track(px!, py!, TRAIL) });
      lambdaPlot.draw(t!, [lambda!]);
      speedPlot.draw(t!, [v!]);
    }
    if (beat % 6 !== 0) return;
    const { kinetic, work, unaccounted } = blade.energyAccount;
    numbers.draw({
      t: show(blade.time, 2), v: show(blade.speed), turn: show(blade.qd[2]!), lambda: show(blade.lambda),
      slip: scientific(blade.sideSlip), mv: show(blade.turningForce), K: show(kinetic), work: show(work),
      off: scientific(unaccounted),
    });
  };
  const clock = transport({
    step: () => blade.stepLength,
    advance: (steps) => { blade.advance(steps); },
    draw,
    reset: place,
    describe: () => `Paused at ${show(blade.time, 2)} seconds, side force ${show(blade.lambda, 2)} newtons.`,
    single: 20,
  }, true);
  const scene = (name: string, speed: number, turning: number, forces: [number, number]): HTMLElement =>
    button(name, () => {
      start = { x: 0, y: 0, heading: 0.4, speed, turning };
      sliders.side.set(0);
      sliders.left.set(forces[0]);
      sliders.right.set(forces[1]);
      push();
      place();
      clock.play();
    });

  const element = frame({
    id: 'knife-edge',
    picture: [picture],
    controls: [
      clock.element,
      html('div', { class: 'drive' },
        pad, html('div', {}, sliders.left.element, sliders.right.element, sliders.side.element, sliders.drag.element)),
      html('div', { class: 'settings' }, buttonRow('Scenes',
        scene('Coast in a circle', 1.5, 0.8, [0, 0]),
        scene('Turn on the spot', 0, 0, [-1, 1]),
        scene('Spiral out', 0.5, 1, [1, 1]))),
      numbers.element,
    ],
    below: [html('div', { class: 'plots' }, lambdaPlot.element, speedPlot.element)],
    plots,
    equations: [
      { name: 'constraint', code: 'KnifeEdge::rows', says: 'no side-slip' },
      { name: 'kkt', code: 'dynamics::constrained_forward_dynamics', says: 'solved together with A q̈ + Ȧ q̇ = 0' },
      { name: 'lambda', code: 'KnifeEdge::side_force', says: 'in closed form' },
    ],
    share: () => {
      const [x, y, heading] = tuple(blade.q, 3);
      return {
        x, y, heading, v: blade.speed, turning: blade.qd[2]!, left: sliders.left.value, right: sliders.right.value,
        side: sliders.side.value, drag: sliders.drag.value, ...clock.shared(),
      };
    },
  });
  push();
  place();
  return {
    id: 'knife-edge', element,
    restore(values) {
      const read = (name: string, otherwise: number): number => numberFrom(values, name, otherwise);
      start = {
        x: read('x', 0), y: read('y', 0), heading: read('heading', 0.4), speed: read('v', 1.5), turning: read('turning', 0.8),
      };
      for (const name of ['left', 'right', 'side', 'drag'] as const) sliders[name].set(read(name, 0));
      clock.restore(values);
      clock.pause();
      push();
      place();
    },
  };
}

/** Grid lines of half a metre around the origin, drawn once and shifted by whole cells, to make motion
 * visible. */
function gridLines(): string {
  const places = Array.from({ length: 12 }, (_, k) => (k - 6) * 0.5 + 0.25);
  return places.map((at) => `M${String(at)} -2.75V2.75M-2.75 ${String(at)}H2.75`).join('');
}
