// The tumbling brick: spun about its middle axis it flips repeatedly, with L fixed in space.
import { numberFrom, wordFrom } from '../address.ts';
import { button, buttonRow, choice } from '../controls/choice.ts';
import { slider } from '../controls/slider.ts';
import { transport } from '../controls/transport.ts';
import { arrow } from '../drawing/arrow.ts';
import { boxDrawing } from '../drawing/box.ts';
import { plot } from '../drawing/plot.ts';
import { plotGroup } from '../drawing/plot-group.ts';
import { readings } from '../drawing/readings.ts';
import { sphereCurve } from '../drawing/sphere.ts';
import { rotate, spatialPicture, vector, View, type Vector3 } from '../drawing/view.ts';
import { html, scientific, set, show, svg } from '../element.ts';
import { Brick, columns, rows, tuple } from '../../lib/dynamics/index.ts';
import { frame, type Widget } from './frame.ts';

const METHODS = [['cayley', 'Cayley (conserves L and K)'], ['rk4', 'Runge–Kutta 4']] as const;
const AXES = ['the long axis', 'the middle axis', 'the short axis'] as const;

export function tumblingBrick(): Widget {
  const brick = new Brick(0.3, 0.2, 0.1, 1000);
  const halves = vector(brick.edges.map((edge) => (edge / 2) * 5.2));
  let h = 1e-3;
  let axis = 1;

  const view = new View();
  const body = new View(0.7, 0.35);
  const space = spatialPicture('The brick in space', view, 1.5, () => { draw(); });
  const box = boxDrawing();
  const momentum = arrow('accent', 'L');
  const omega = arrow('second', 'ω');
  space.append(box.element, omega.element, momentum.element);

  const sphere = spatialPicture('The direction of L seen from the body, on the unit sphere', body, 1.35, () => {
    drawMap();
    draw();
  });
  const polhode = sphereCurve('now');
  const tip = svg('circle', { class: 'dot', r: 0.05 });
  const map = polhodeMap(brick).map((points) => ({ points, curve: sphereCurve('map') }));
  const names = (['x', 'y', 'z'] as const).map((name) => svg('text', { 'text-anchor': 'middle' }, name));
  sphere.append(svg('circle', { class: 'globe', r: 1 }), ...map.map(({ curve }) => curve.element), polhode.element, tip, ...names);

  const numbers = readings('Spin', [
    ['t', 't', 's'], ['flips', 'flips', ''],
    ['wx', 'ω x', 'rad/s'], ['wy', 'ω y', 'rad/s'], ['wz', 'ω z', 'rad/s'], ['K', 'K', 'J'],
    ['L', '|L|', 'kg·m²/s'], ['period', 'exact period', 's'], ['driftL', 'drift of L', ''], ['driftK', 'drift of K', ''],
  ]);
  const plots = plotGroup();
  const spinPlot = plot({
    group: plots,
    title: 'Spin in body axes', unit: 'rad/s',
    lines: [{ name: 'ω x', tone: 'second' }, { name: 'ω y', tone: 'accent' }, { name: 'ω z', tone: 'muted', dashed: true }],
    atLeast: [-1, 1], height: 170,
  });

  const spin = (about: number): void => {
    axis = about;
    const start = Float64Array.from([0, 1, 2], (i) => (i === about ? rate.value : wobble.value));
    brick.spin(start);
    buttons.forEach((one, i) => { one.setAttribute('aria-pressed', String(i === about)); });
    drawPath();
    draw();
  };
  /** The elements that depend on the spin or the view only. */
  const drawPath = (): void => {
    path = rows(brick.polhode(240), 3).map((row) => vector(row));
    drawMap();
  };
  const drawMap = (): void => {
    for (const { points, curve } of map) curve.draw(body, points);
    polhode.draw(body, path);
    names.forEach((name, i) => {
      const [px, py] = toScreen(body, vector([0, 1, 2].map((k) => (k === i ? 1 : 0))), 1.17);
      set(name, { x: px, y: py + 0.04 });
    });
  };
  let path: Vector3[] = [];

  const draw = (beat = 0): void => {
    const rotation = brick.rotation;
    box.draw(view, rotation, halves);
    const l = vector(brick.momentumInWorld);
    const size = Math.hypot(...l);
    const [wx, wy, wz] = tuple(brick.omega, 3);
    const w = rotate(rotation, [wx, wy, wz]);
    momentum.draw([0, 0], toScreen(view, l, 1.25 / (size || 1)));
    omega.draw([0, 0], toScreen(view, w, 1.1 / (Math.hypot(...w) || 1)));
    const [right, up, towards] = body.look(vector(brick.direction));
    set(tip, { cx: right, cy: -up, opacity: towards >= 0 ? 1 : 0.35 });
    if (beat % 3 === 0) {
      const [t, ...omegas] = columns(brick.samples(), 7);
      spinPlot.draw(t!, omegas.slice(0, 3));
    }
    if (beat % 6 !== 0) return;
    const { momentum: driftL, energy: driftK } = brick.drift;
    numbers.draw({
      t: show(brick.time, 2), flips: String(brick.flips), wx: show(wx), wy: show(wy), wz: show(wz),
      K: show(brick.kineticEnergy, 4), L: show(size, 5), period: show(brick.exactPeriod, 2),
      driftL: scientific(driftL), driftK: scientific(driftK),
    });
  };

  const clock = transport({
    step: () => h,
    advance: (steps) => { brick.advance(steps); },
    draw,
    reset: () => { spin(axis); },
    describe: () => `Paused at ${show(brick.time, 2)} seconds, ${String(brick.flips)} flips.`,
    single: 20,
  }, true);
  const spins = { unit: 'rad/s', onInput: () => { spin(axis); } };
  const rate = slider({ ...spins, label: 'Spin', min: 1, max: 12, step: 0.1, value: 6 });
  const wobble = slider({ ...spins, label: 'Nudge', min: 0, max: 1, step: 0.01, value: 0.05 });
  const setMethod = (): void => { brick.setMethod(method.value, h); };
  const method = choice('Step', METHODS, 'cayley', setMethod);
  const stepLength = slider({
    label: 'Step h', unit: 'ms', min: 1, max: 100, step: 1, value: 1, onInput: (ms) => { h = ms / 1000; setMethod(); },
  });
  const buttons = AXES.map((name, i) => button(`About ${name}`, () => { clock.say(''); spin(i); clock.play(); }));

  const element = frame({
    id: 'tumbling-brick',
    picture: [html('div', { class: 'pair' },
      html('figure', { class: 'captioned' }, space, html('figcaption', {}, 'In space. L is fixed; ω and the brick are not.')),
      html('figure', { class: 'captioned' }, sphere, html('figcaption', {},
        'In the body: L moves along its polhode. Around x and z the curves are small loops; near y they lead to the other side.')),
    ), spinPlot.element],
    controls: [
      clock.element,
      html('div', { class: 'settings' },
        buttonRow('Spin', ...buttons), rate.element, wobble.element, method.element, stepLength.element),
      numbers.element,
    ],
    plots,
    equations: [
      { name: 'euler', code: 'dynamics::euler_in_body', says: 'Euler’s equation without torque' },
      { name: 'momentum', code: 'RotationalInertia::momentum_in_world', says: 'constant' },
      { name: 'cayley', code: 'dynamics::cayley_body_step', says: 'conserves both to rounding' },
    ],
    share: () => {
      const [x, y, z, w] = tuple(brick.quaternionXyzw, 4);
      const [wx, wy, wz] = tuple(brick.omega, 3);
      return {
        axis, spin: rate.value, nudge: wobble.value, method: method.value, h, x, y, z, w, wx, wy, wz,
        ...view.shared('space'), ...body.shared('body'), ...clock.shared(),
      };
    },
  });
  spin(1);
  return {
    id: 'tumbling-brick', element,
    restore(values) {
      rate.set(numberFrom(values, 'spin', 6));
      wobble.set(numberFrom(values, 'nudge', 0.05));
      method.set(wordFrom(values, 'method', ['cayley', 'rk4'], 'cayley'));
      h = Math.max(1e-4, numberFrom(values, 'h', 1e-3));
      stepLength.set(1000 * h);
      setMethod();
      view.restore(values, 'space');
      body.restore(values, 'body');
      clock.restore(values);
      clock.pause();
      spin(Math.min(2, Math.max(0, Math.round(numberFrom(values, 'axis', 1)))));
      const list = (names: string): Float64Array => Float64Array.from(names.split(' '), (name) => numberFrom(values, name, 0));
      const orientation = list('x y z w');
      if (!values.has('w')) return;
      if (Math.hypot(...orientation) < 1e-6) {
        clock.say('The orientation in the address is zero, which is not a rotation: the brick starts along the axes.');
        orientation[3] = 1;
      }
      brick.place(orientation, list('wx wy wz'));
      drawPath();
      draw();
    },
  };
}

function toScreen(view: View, vector: Vector3, scale: number): [number, number] {
  const [x, y] = view.look(vector);
  return [x * scale, -y * scale];
}

/** Polhodes over the whole sphere: through points on the great circles from y to x and from y to z. */
function polhodeMap(brick: Brick): Vector3[][] {
  const curves: Vector3[][] = [];
  for (const towards of [0, 2]) {
    for (const degrees of [8, 25, 45, 65]) {
      for (const sign of [1, -1]) {
        const angle = (degrees * Math.PI) / 180;
        const direction = Float64Array.of(0, Math.cos(angle), 0);
        direction[towards] = sign * Math.sin(angle);
        curves.push(rows(brick.polhodeThrough(direction, 120), 3).map((row) => vector(row)));
      }
    }
  }
  return curves;
}
