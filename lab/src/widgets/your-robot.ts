// Your robot: any URDF, drawn from its inertias, posed, held, or let fall.
import portable from '../../wasm/robots_bg.wasm?url';
import simd128 from '../../wasm/robots_simd128_bg.wasm?url';
import { numberFrom } from '../address.ts';
import { button, buttonRow, choice, toggle } from '../controls/choice.ts';
import { slider, type Slider } from '../controls/slider.ts';
import { transport } from '../controls/transport.ts';
import { plot } from '../drawing/plot.ts';
import { readings } from '../drawing/readings.ts';
import { robotDrawing, type RobotDrawing } from '../drawing/robot.ts';
import { floorLines, spatialPicture, View } from '../drawing/view.ts';
import { html, scientific, set, show, svg } from '../element.ts';
import { loadRobots, rows, type IntegratorName, type Robot, type Robots } from '../../lib/dynamics/index.ts';
import { frame, type Widget } from './frame.ts';
import { INTEGRATORS } from './integrators.ts';
import { reportTable } from './load-report.ts';

// The one file that opens without a server carries one module, which every browser takes.
const MODULES = { portable, simd128: import.meta.env.MODE === 'single' ? undefined : simd128 };
const FILES = import.meta.glob<string>('../../../robots/*.urdf', { query: '?raw', import: 'default' });
const BUNDLED = Object.keys(FILES).map((path) => [path, path.replace(/^.*\/|\.urdf$/g, '')] as const);
const FIRST = 'panda';

/** Neutral, but the middle of its range for a joint that cannot be, or only just, at zero. */
function startPose(robot: Robot): Float64Array {
  const q = robot.neutral();
  for (const [at, , lower, upper] of rows(robot.coordinates(), 5)) {
    if (at! >= 0 && (lower! > -0.05 || upper! < 0.05)) q[at!] = (lower! + upper!) / 2;
  }
  return q;
}

/** The longest of a few steps at which a twentieth of a second of falling leaves the books balanced. */
function steadyStep(robot: Robot, method: IntegratorName, friction: boolean): number {
  const start = startPose(robot);
  for (const h of [1e-3, 5e-4, 2e-4]) {
    robot.place(start);
    robot.setMethod(method, h, friction);
    try {
      robot.advance(Math.round(0.05 / h));
      const [, , e, , , , off] = robot.books as unknown as number[];
      if (Math.abs(off!) < 1e-3 * Math.max(1, Math.abs(e!))) return h;
    } catch {
      // Too long a step for this robot: try a shorter one.
    }
  }
  return 1e-4;
}

/** A stiff joint and a long step make energy out of nothing before they make infinities. */
function checkBooks(robot: Robot): void {
  const [, , , e0, work, , off] = robot.books as unknown as number[];
  if (Math.abs(off!) > 0.1 * Math.max(1, Math.abs(e0!), Math.abs(work!))) {
    throw new Error(`${show(off!, 1)} J have come from nowhere by ${show(robot.time, 2)} s: the step is too long for this robot. Take a smaller step and reset.`);
  }
}

export function yourRobot(): Widget {
  let robots: Robots | undefined;
  let robot: Robot | undefined;
  let drawing: RobotDrawing | undefined;
  let text = '';
  let bundled = FIRST;
  let sliders: (Slider | undefined)[] = [];
  let scale = 1;

  const view = new View(-0.7, 0.3);
  const picture = spatialPicture('The robot', view, 1, () => { draw(); });
  const floor = svg('path', { class: 'floor' });
  picture.append(floor);
  const report = html('div', { class: 'report' });
  const posed = html('div', { class: 'coordinates' });
  const torques = html('tbody');
  const numbers = readings('Energy books', [
    ['t', 't', 's'], ['mass', 'mass', 'kg'], ['dof', 'freedoms', ''], ['K', 'K', 'J'], ['V', 'V', 'J'], ['E', 'E', 'J'], ['work', 'work of motors', 'J'], ['lost', 'dissipated', 'J'], ['off', 'unaccounted', 'J'],
  ]);
  const energyPlot = plot({ title: 'Energy', unit: 'J', lines: [{ name: 'K', tone: 'second' }, { name: 'V', tone: 'muted', dashed: true }, { name: 'E', tone: 'accent' }], height: 150 });

  const load = (urdf: string): void => {
    if (robots === undefined) return;
    clock.pause();
    try {
      const next = robots.Robot.load(urdf, floating.on, true);
      robot?.free();
      [robot, text] = [next, urdf];
    } catch (error) {
      clock.say(`This file was not loaded. ${error instanceof Error ? error.message : String(error)}`);
      return;
    }
    clock.say('');
    report.replaceChildren(reportTable(robot));
    drawing?.element.remove();
    drawing = robotDrawing(robot, (coordinate, by) => { move(coordinate, by); }, () => { clock.pause(); });
    picture.append(drawing.element);
    buildSliders(robot);
    stepLength.set(1000 * steadyStep(robot, method.value, friction.on));
    setMethod();
    place(startPose(robot));
    frameIn();
  };
  const place = (q: Float64Array): void => {
    robot?.place(q);
    if (holding.on) grip();
    draw();
  };
  /** Fits the picture to the pose. */
  const frameIn = (): void => {
    if (drawing === undefined) return;
    scale = 1.45 * drawing.extent().reach;
    picture.style.setProperty('--reach', String(scale));
    draw();
  };
  const move = (coordinate: number, by: number): void => {
    if (robot === undefined) return;
    const row = rows(robot.coordinates(), 5)[coordinate]!;
    const q = robot.q;
    q[row[0]!] = Math.min(row[3]!, Math.max(row[2]!, q[row[0]!]! + by));
    place(q);
  };
  const buildSliders = (of: Robot): void => {
    const names = of.coordinateNames();
    sliders = rows(of.coordinates(), 5).map(([at, slides, lower, upper], i) => {
      if (at! < 0) return undefined;
      const most = slides === 1 ? 1 : Math.PI;
      return slider({
        label: names[i]!, unit: slides === 1 ? 'm' : 'rad', step: 0.01, value: 0,
        min: Number.isFinite(lower) ? lower! : -most, max: Number.isFinite(upper) ? upper! : most,
        onInput: (value) => {
          clock.pause();
          const q = of.q;
          q[at!] = value;
          place(q);
        },
      });
    });
    posed.replaceChildren(...sliders.flatMap((one) => (one === undefined ? [] : [one.element])));
  };
  const draw = (): void => {
    if (robot === undefined || drawing === undefined) return;
    const { middle } = drawing.extent();
    set(floor, { d: floorLines(view, scale) });
    // A fixed robot stays where it is; a falling one is followed.
    const [x, y] = view.look(floating.on ? middle : start);
    set(picture, { viewBox: `${(x - scale).toFixed(4)} ${(-y - scale).toFixed(4)} ${(2 * scale).toFixed(4)} ${(2 * scale).toFixed(4)}` });
    drawing.draw(view);
    const q = robot.q;
    rows(robot.coordinates(), 5).forEach(([at], i) => sliders[i]?.set(q[at!]!));
    const [k, v, e, , work, lost, off] = robot.books as unknown as number[];
    numbers.draw({
      t: show(robot.time, 2), mass: show(robot.totalMass, 2), dof: String(robot.counts[2]), K: show(k!), V: show(v!), E: show(e!), work: show(work!), lost: show(lost!), off: scientific(off!),
    });
    const samples = rows(robot.samples(), 4);
    energyPlot.draw(samples.map((row) => row[0]!), [samples.map((row) => row[1]!), samples.map((row) => row[2]!), samples.map((row) => row[1]! + row[2]!)]);
    drawTorques(robot);
  };
  let start: readonly [number, number, number] = [0, 0, 0];
  const drawTorques = (of: Robot): void => {
    const hold = of.holdTorques();
    const names = of.coordinateNames();
    const limits = rows(of.coordinates(), 5);
    if (torques.children.length !== names.length) {
      torques.replaceChildren(...names.map((name) => html('tr', {}, html('th', { scope: 'row' }, name), html('td'), html('td'))));
    }
    Array.from(torques.children).forEach((row, i) => {
      const [, slides, , , effort] = limits[i]!;
      const over = Math.abs(hold[i]!) > effort!;
      row.children[1]!.textContent = `${show(hold[i]!, 2)} ${slides === 1 ? 'N' : 'N·m'}`;
      row.children[2]!.textContent = over ? `over its limit of ${show(effort!, 0)}` : '';
    });
  };
  const setMethod = (): void => { robot?.setMethod(method.value, stepLength.value / 1000, friction.on); };
  const grip = (): void => { robot?.hold(frequency.value, ratio.value); };

  const clock = transport({
    step: () => stepLength.value / 1000,
    advance: (steps) => {
      robot?.advance(steps);
      if (robot !== undefined) checkBooks(robot);
    },
    draw,
    reset: () => { if (robot !== undefined) { place(startPose(robot)); frameIn(); } },
    describe: () => (robot === undefined ? '' : `${robot.name}, paused at ${show(robot.time, 2)} seconds, ${scientific(robot.books[6]!)} joules unaccounted for.`),
    single: 10,
  });
  const open = async (name: string, read: () => Promise<string>): Promise<void> => {
    bundled = name;
    let urdf: string;
    try {
      [robots, urdf] = await Promise.all([loadRobots(MODULES), read()]);
    } catch (error) {
      clock.say(`The robot was not fetched: ${String(error)}. Choose it again to try once more.`);
      return;
    }
    load(urdf);
    if (drawing !== undefined) start = drawing.extent().middle;
    draw();
  };
  const openBundled = async (name: string): Promise<void> => {
    const path = BUNDLED.find(([, stem]) => stem === name)?.[0];
    if (path !== undefined) await open(name, FILES[path]!);
  };
  const openFile = (file: File): Promise<void> => open('', () => file.text());
  const floating = toggle('Base floats freely', false, () => { load(text); });
  const friction = toggle('Damping and friction', true, setMethod);
  const holding = toggle('Motors hold the pose', false, (on) => { if (on) grip(); else robot?.release(); });
  const method = choice<IntegratorName>('Integrator', INTEGRATORS, 'rk4', setMethod);
  const stepLength = slider({ label: 'Step h', unit: 'ms', min: 0.1, max: 10, step: 0.1, value: 1, onInput: setMethod });
  const frequency = slider({ label: 'Hold at', unit: 'rad/s', min: 0, max: 40, step: 1, value: 20, onInput: () => { if (holding.on) grip(); } });
  const ratio = slider({ label: 'Damping ζ', unit: '', min: 0, max: 2, step: 0.05, value: 1, onInput: () => { if (holding.on) grip(); } });
  const pick = choice('Robot', BUNDLED.map(([, name]) => [name, name.replace(/_/g, ' ')] as const), FIRST, (name) => { void openBundled(name); });
  const file = html('input', { type: 'file', accept: '.urdf,.xml', class: 'visually-hidden', tabindex: -1, 'aria-label': 'A URDF file', change: () => { const one = file.files?.[0]; if (one) void openFile(one); } });
  const look = buttonRow('Views', ...([['Front', 0, 0.05], ['Side', -Math.PI / 2, 0.05], ['Above', 0, 1.5]] as const).map(([name, azimuth, elevation]) =>
    button(name, () => { [view.azimuth, view.elevation] = [azimuth, elevation]; draw(); })), button('Fit', frameIn));

  const element = frame({
    id: 'your-robot',
    title: 'Your robot',
    lede: 'Any URDF: choose one, open a file, or drop it anywhere on the page. It never leaves your machine. Every link is drawn by its inertia: an ellipsoid that shows how far its mass is spread. Drag a link to turn its joint, then let the robot fall.',
    picture: [html('figure', { class: 'captioned' }, picture, html('figcaption', {}, 'Drag a link, or the ground to look from another side. A falling joint may pass its limits: stops are not part of the model.')), look],
    controls: [
      clock.element,
      html('div', { class: 'settings' }, pick.element, buttonRow('File', button('Open a file…', () => { file.click(); }), file), floating.element, friction.element, holding.element, frequency.element, ratio.element, method.element, stepLength.element),
      numbers.element,
      html('h3', {}, 'Pose'), posed,
    ],
    below: [
      html('div', { class: 'plots' },
        html('div', {}, html('h3', {}, 'Torque to hold this pose'), html('div', { class: 'table scroll', tabindex: 0, role: 'region', 'aria-label': 'Torque to hold this pose' }, html('table', { class: 'torques' }, html('thead', {}, html('tr', {}, ...['Joint', 'g(q)', 'Limit'].map((name) => html('th', { scope: 'col' }, name)))), torques))), energyPlot.element),
      report,
    ],
    equations: [
      { name: 'hold', code: 'multibody::gravity', says: 'by Newton–Euler recursion' },
      { name: 'forward', code: 'multibody::forward_dynamics', says: 'by articulated bodies, O(n)' },
      { name: 'ledger', code: 'multibody::EnergyLedger', says: 'every joule has a name' },
    ],
    share: () => ({
      robot: bundled, h: stepLength.value / 1000, floating: floating.on ? 1 : 0, friction: friction.on ? 1 : 0, method: method.value,
      ...Object.fromEntries(Array.from(robot?.q ?? [], (x, i) => [`q${String(i)}`, x])),
    }),
  });
  addEventListener('dragover', (event) => { event.preventDefault(); });
  addEventListener('drop', (event) => {
    event.preventDefault();
    const one = event.dataTransfer?.files[0];
    if (one === undefined) return;
    element.scrollIntoView();
    void openFile(one);
  });
  // The robots are fetched from this same page when someone comes here.
  new IntersectionObserver(([entry], observer) => {
    if (!entry?.isIntersecting) return;
    observer.disconnect();
    if (robot === undefined) void openBundled(bundled);
  }, { rootMargin: '200px' }).observe(element);
  return {
    id: 'your-robot', title: 'Your robot', element,
    restore(values) {
      floating.set(numberFrom(values, 'floating', 0) !== 0);
      friction.set(numberFrom(values, 'friction', 1) !== 0);
      stepLength.set(1000 * Math.min(0.01, Math.max(1e-4, numberFrom(values, 'h', 1e-3))));
      const name = values.get('robot') ?? FIRST;
      pick.set(name);
      void openBundled(name).then(() => {
        if (robot === undefined) return;
        place(Float64Array.from(robot.q, (x, i) => numberFrom(values, `q${String(i)}`, x)));
      });
    },
  };
}
