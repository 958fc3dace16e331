// Your robot: any URDF or MJCF file, shown in three dimensions, pulled, posed, held, or falling.
import portable from '../../wasm/robots_bg.wasm?url';
import simd128 from '../../wasm/robots_simd128_bg.wasm?url';
import { LONGEST_PACKED, numberFrom, numbered, numbersFrom, pack, unpack, type Shared } from '../address.ts';
import { button, buttonRow, toggle } from '../controls/choice.ts';
import { filmButton } from '../controls/film.ts';
import { transport } from '../controls/transport.ts';
import { plot } from '../drawing/plot.ts';
import { plotGroup } from '../drawing/plot-group.ts';
import { html, scientific, show } from '../element.ts';
import { columns, loadRobots, type Robot, type Robots } from '../../lib/dynamics/index.ts';
import { GALLERY } from '../robot/gallery.ts';
import { droppedFiles, fileInput } from '../robot/dropped-files.ts';
import { layerToggles } from '../robot/layer-toggles.ts';
import type { MeshFiles } from '../robot/mesh-files.ts';
import { advanceWithinBudget } from '../robot/time-budget.ts';
import { runControls } from '../robot/run-controls.ts';
import type { PoseSliders } from '../robot/pose-sliders.ts';
import { type Hand, type Stage, VIEWS } from '../robot/stage.ts';
import type { RobotReadings } from '../robot/energy-table.ts';
import { includes, read, type Source } from '../robot/source.ts';
import type { TorqueTable } from '../robot/torque-table.ts';
import { frame, type Widget } from './frame.ts';

// The single-file build contains one module, for all browsers.
const MODULES = { portable, simd128: import.meta.env.MODE === 'single' ? undefined : simd128 };
const FIRST = 'panda';
/** In an address: a robot from a file, whose text the address contains unless it is too long. */
const OWN = 'own';

export function yourRobot(): Widget {
  let robots: Robots | undefined;
  let stage: Stage | undefined;
  let robot: Robot | undefined;
  let source: Source | undefined;
  /** The file's text packed for the address; empty for a bundled robot. */
  let packed = '';
  /** The state in which the robot was released. */
  let released: { q: Float64Array; v: Float64Array } | undefined;
  let bundled = FIRST;

  const scene = html('div', { class: 'scene' });
  const report = html('div', { class: 'report' });
  let [torques, numbers, pose]: [TorqueTable?, RobotReadings?, PoseSliders?] = [];
  const [table, energies, posed] = [html('div'), html('div'), html('div')];
  const plots = plotGroup();
  const energyPlot = plot({
    group: plots, title: 'Energy', unit: 'J', height: 150,
    lines: [{ name: 'K', tone: 'second' }, { name: 'V', tone: 'muted', dashed: true }, { name: 'E', tone: 'accent' }],
  });
  const controls = runControls(() => robot, (text) => { clock.say(text); });
  const turn = (place: number, value: number): void => {
    clock.pause();
    if (robot === undefined) return;
    put(robot.q.map((x, i) => (i === place ? value : x)));
  };

  /** The robot at rest in a pose, to which Reset returns. */
  const put = (q: Float64Array, v?: Float64Array): void => {
    if (robot === undefined) return;
    robot.placeMoving(q, v ?? new Float64Array(robot.v.length));
    released = { q: robot.q, v: robot.v };
    controls.grip(robot);
    draw();
  };
  const holder: Hand = {
    grab(link, point) {
      robot?.grab(link, Float64Array.from(point));
    },
    move(point) {
      if (robot === undefined) return;
      if (clock.playing) robot.pullTo(Float64Array.from(point));
      else {
        robot.leadTo(Float64Array.from(point));
        released = { q: robot.q, v: robot.v };
        controls.grip(robot);
        draw(1);
      }
    },
    release() {
      robot?.letGo();
      draw();
    },
  };

  /** One after the other, so that a robot that is being shown is not freed. */
  const load = (next: Source): Promise<void> => (loading = loading.then(() => loadNow(next)));
  let loading = Promise.resolve();
  const shown = (name: string): string => robots?.oneLine(name) ?? name;
  const loadNow = async (next: Source): Promise<void> => {
    if (robots === undefined) return;
    clock.pause();
    let loaded: Robot;
    const { poseSliders, reportTable, energyTable, torqueTable } = await import('../robot/panels.ts');
    try {
      await controls.ready();
      loaded = await read(robots, next, floating.on);
    } catch (error) {
      clock.say(`This file was not loaded. ${error instanceof Error ? error.message : String(error)}`);
      return;
    }
    const before = robot;
    [robot, source] = [loaded, next];
    packed = next.name === '' && !includes(next.text) ? await pack(next.text) : '';
    clock.say('');
    for (const one of gallery) one.element.setAttribute('aria-pressed', String(one.name === next.name));
    loaded.setGround(ground.on);
    for (const one of [controls, layers]) one.suit(loaded);
    [torques, numbers, pose] = [torques ?? torqueTable(), numbers ?? energyTable(), pose ?? poseSliders(turn, () => { draw(); })];
    [table, energies, posed].forEach((place, i) => { place.replaceChildren([torques!, numbers!, pose!][i]!.element); });
    torques.show(loaded);
    ground.element.hidden = !loaded.floats || loaded.ownGround;
    put(loaded.startPose());
    pose.show(loaded);
    stage ??= await setStage();
    const absent = await stage.show(loaded, next.meshes);
    before?.free();
    report.replaceChildren(reportTable(loaded, absent.map(shown)));
    draw();
    element.dataset['shown'] = loaded.name;
  };
  const setStage = async (): Promise<Stage> => {
    let made: Stage;
    try {
      made = (await import('../robot/solid-stage.ts')).solidStage(holder, () => { stand(true); });
    } catch {
      made = (await import('../robot/flat-stage.ts')).flatStage(holder);
      layers.element.hidden = film.hidden = true;
    }
    scene.replaceChildren(made.element);
    return made;
  };

  const draw = (beat = 0): void => {
    if (robot === undefined) return;
    stage?.glow(layers.glow());
    stage?.draw();
    if (beat % 4 === 0) {
      const [t, k, v] = columns(robot.samples(), 4);
      energyPlot.draw(t!, [k!, v!, k!.map((kinetic, i) => kinetic + v![i]!)]);
    }
    if (beat % 6 !== 0) return;
    pose?.draw(robot.q);
    controls.draw(robot);
    torques?.draw(robot);
    layers.write();
    numbers?.draw(robot);
  };
  const clock = transport({
    step: () => controls.h,
    advance: (steps) => { if (robot !== undefined) advanceWithinBudget(robot, steps); },
    draw,
    reset: () => { if (released !== undefined) put(released.q, released.v); },
    describe: () => {
      if (robot === undefined) return '';
      const off = scientific(robot.energyAccount.unaccounted);
      return `${robot.name}, paused at ${show(robot.time, 2)} seconds, energy residual ${off} joules.`;
    },
    single: 10,
  });

  const open = async (read: () => Promise<Source>): Promise<void> => {
    // Messages about the previous robot are cleared.
    clock.say('');
    let next: Source;
    try {
      [robots, next] = await Promise.all([loadRobots(MODULES), read()]);
    } catch (error) {
      clock.say(`The robot did not load: ${String(error)}. Choose it again to retry.`);
      return;
    }
    await load(next);
  };
  const none = async (): Promise<MeshFiles> => new (await import('../robot/mesh-files.ts')).MeshFiles();
  const openBundled = (name: string): Promise<void> => {
    const one = GALLERY.find((candidate) => candidate.name === name) ?? GALLERY[0]!;
    bundled = one.name;
    return open(async () => ({ name: one.name, text: await one.read(), meshes: await none() }));
  };
  const openOwn = (text: string, meshes?: MeshFiles, path?: string): Promise<void> => {
    bundled = OWN;
    return open(async () => ({ name: '', text, meshes: meshes ?? await none(), path }));
  };
  /** Files of the user: shows the first robot and offers the others. */
  const openFiles = async (files: ReadonlyMap<string, Blob>): Promise<void> => {
    try {
      const { sorted } = await import('../robot/files.ts');
      const { robots: found, meshes } = await sorted(files);
      const openOne = (path: string, text: string): void => { void openOwn(text, meshes, path); };
      const [first] = found;
      others.replaceChildren(...(found.size > 1
        ? [buttonRow('Robots in this folder', ...[...found].slice(0, 40).map(([path, text]) =>
          button(shown(path.replace(/^.*\//, '')), () => { openOne(path, text); })))]
        : []));
      if (first !== undefined) openOne(...first);
      else clock.say('The files contain no robot: none begins with <robot> (URDF) or <mujoco> (MJCF).');
    } catch (error) {
      clock.say(`The files could not be read: ${error instanceof Error ? error.message : String(error)}`);
    }
  };

  const gallery = GALLERY.map(({ name, title, floats }) => ({ name, element: button(title, () => {
    floating.set(floats);
    void openBundled(name);
  }) }));
  const others = html('div');
  const floating = toggle('Base floats freely', false, () => { if (source !== undefined) void load(source); });
  /** Adds or removes the ground. A robot that would be in it, or that restarts, starts above it. */
  const stand = (anew: boolean): void => {
    if (robot === undefined) return;
    robot.setGround(ground.on);
    controls.show(robot);
    if (anew) put(robot.startPose());
    draw();
  };
  const ground = toggle('Ground', true, () => { stand(ground.on); });
  const layers = layerToggles(() => { stage?.layers(layers.value); }, () => { draw(1); });
  const [file, folder] = [fileInput('A robot file', false, openFiles), fileInput('A folder with a robot', true, openFiles)];
  const film = filmButton({
    begin: () => scene.querySelector('canvas'), name: () => robot?.fileName ?? 'robot', title: 'Record a video',
  });
  const look = buttonRow('Views',
    ...VIEWS.map(([name, azimuth, elevation]) => button(name, () => { stage?.look(azimuth, elevation); })),
    button('Fit', () => { stage?.fit(); }), film);
  const element = frame({
    id: 'your-robot',
    picture: [
      html('div', { class: 'gallery' }, buttonRow('Robots', ...gallery.map((one) => one.element)), others), scene,
      html('div', { class: 'beside' }, look, layers.element),
    ],
    controls: [
      clock.element,
      html('div', { class: 'settings' },
        buttonRow('File',
          button('Open a file…', () => { file.click(); }), button('Open a folder…', () => { folder.click(); }),
          button('Start pose', () => { if (robot !== undefined) { put(robot.startPose()); stage?.fit(); } })),
        file, folder, floating.element, ground.element, ...controls.elements, posed),
      energies,
    ],
    below: [html('div', { class: 'plots' }, energyPlot.element), table, report],
    equations: [
      { name: 'hold', code: 'algorithms::gravity', says: 'by Newton–Euler recursion' },
      { name: 'forward', code: 'algorithms::forward_dynamics', says: 'by articulated bodies, O(n)' },
      { name: 'pull', code: 'algorithms::frame_jacobian', says: 'a spring and a damper at your hand' },
      { name: 'felt', code: 'algorithms::inverse_mass_matrix', says: 'the effective mass at your hand' },
      { name: 'contact', code: 'contact::ContactSet', says: 'unilateral contact with Coulomb friction' },
      { name: 'account', code: 'simulation::EnergyAccount', says: 'the energy balance' },
    ],
    plots,
    share: () => {
      const carried: Shared = packed === '' || packed.length > LONGEST_PACKED ? {} : { file: packed };
      return {
        robot: bundled, ...carried, floating: floating.on ? 1 : 0, ground: ground.on ? 1 : 0, ...controls.shared(robot),
        ...numbered('q', robot?.q ?? []), ...numbered('v', robot?.v ?? []),
        ...layers.shared(), ...stage?.shared(), ...clock.shared(),
      };
    },
    unshared: () => {
      if (source !== undefined && includes(source.text)) return 'It includes other files: send them too, to be dropped on the page.';
      if (packed.length > LONGEST_PACKED) {
        return 'The file is too large for a link, even compressed: send it with the link, to be dropped on the page.';
      }
      return (source?.meshes.count ?? 0) > 1 ? 'The link does not contain meshes, and shows the robot without them.' : '';
    },
  });
  addEventListener('dragover', (event) => { event.preventDefault(); });
  addEventListener('drop', (event) => {
    event.preventDefault();
    if (event.dataTransfer === null) return;
    element.scrollIntoView();
    void droppedFiles(event.dataTransfer).then(openFiles);
  });
  // Robots are loaded when the experiment becomes visible.
  new IntersectionObserver((entries, observer) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    if (robot === undefined && !restoring) void openBundled(bundled);
  }, { rootMargin: '200px' }).observe(element);
  let restoring = false;
  /** The robot that an address names or contains. */
  const named = async (values: URLSearchParams): Promise<void> => {
    const carried = values.get('file');
    if (carried !== null) {
      await openOwn(await unpack(carried).catch(() => ''));
      return;
    }
    const name = values.get('robot') ?? FIRST;
    await openBundled(GALLERY.some((one) => one.name === name) ? name : FIRST);
    if (name === OWN) clock.say('This link refers to a file that it does not contain. Drop that file here to see the robot.');
  };
  return {
    id: 'your-robot', element,
    restore(values) {
      restoring = true;
      clock.pause();
      floating.set(numberFrom(values, 'floating', 0) !== 0);
      ground.set(numberFrom(values, 'ground', 1) !== 0);
      controls.restore(values);
      clock.restore(values);
      layers.restore(values);
      void named(values).then(() => {
        if (robot === undefined) return;
        put(numbersFrom(values, 'q', robot.q), numbersFrom(values, 'v', robot.v));
        controls.restoreOn(values);
        stage?.layers(layers.value);
        stage?.restore(values);
        draw();
      });
    },
  };
}
