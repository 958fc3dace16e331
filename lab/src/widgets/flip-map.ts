// The map of flips: every point is a double pendulum released from rest, coloured by its first flip. A click
// simulates that pendulum beside the map.
import { numberFrom } from '../address.ts';
import { button, buttonRow } from '../controls/choice.ts';
import { transport } from '../controls/transport.ts';
import { fadingTrail } from '../drawing/fading-trail.ts';
import { armDrawing, armPoints, planarPicture } from '../drawing/planar-arm.ts';
import { plot } from '../drawing/plot.ts';
import { plotGroup } from '../drawing/plot-group.ts';
import { readings } from '../drawing/readings.ts';
import { html, set, show, svg } from '../element.ts';
import { flipPicture, flipWords, type Progress, type View } from '../flips/map.ts';
import { LATEST } from '../flips/palette.ts';
import type { Pool } from '../flips/workers.ts';
import { columns, FallingArm, type Tuple } from '../../lib/dynamics/index.ts';
import { TWIN_APART } from '../story/words.ts';
import { frame, type Widget } from './frame.ts';

const ID = 'flip-map';
/** The chapter's rods, gravity, and the map's step [s]. */
const ARM = [1, 2, 1, 1, 9.81, 0.01] as const;
const WHOLE: View = { x: 0, y: 0, half: Math.PI };
/** Width of a view below which its points are less than sixteen roundings of single precision apart. */
const SINGLE = 1e-3;
/** Number of points of the plot. */
const KEPT = 3000;

export function flipMap(): Widget {
  let view = { ...WHOLE };
  let dropped: Tuple<2> = [2.2, 1.6];
  let pools: { workers: Pool; card: Pool | undefined } | undefined;
  let asked = false;

  const says = html('p', { class: 'says', 'aria-live': 'off' }, 'It is computed when you come here.');
  const progress = html('progress', { max: 1, value: 0, 'aria-label': 'Points computed' });
  const told = ({ share, steps, seconds, coarse }: Progress): void => {
    progress.value = share;
    const rate = steps / seconds;
    map.element.dataset['rate'] = rate.toFixed(0);
    map.element.dataset['coarse'] = coarse.toFixed(3);
    map.element.dataset['share'] = share.toFixed(4);
    says.textContent = `${show(100 * share, 0)} % of the points; ${show(steps / 1e6, 1)} million steps of an arm in ${show(seconds, 1)} s, `
      + `${show(rate / 1e6, 0)} million per second.`;
    if (share === 1) draw();
  };
  const map = flipPicture(({ half }) => {
    if (pools === undefined) return undefined;
    const pool = half > SINGLE ? pools.card ?? pools.workers : pools.workers;
    method.textContent = `Runge–Kutta 4 in steps of ${show(1000 * ARM[5], 0)} ms, ${String(LATEST)} s at most, in ${pool.says}.`;
    return pool;
  }, told);
  const cross = svg('path', { class: 'cross', d: 'M-0.035 0H-0.012M0.012 0H0.035M0 -0.035V-0.012M0 0.012V0.035' });
  const over = svg('svg', {
    class: 'flip-over', viewBox: '0 0 1 1', role: 'application', tabindex: 0,
    'aria-label': 'Map of first flips. Arrow keys move the cross, Enter releases the pendulum there, plus and minus zoom, 0 shows all',
  }, cross);
  const heard = html('p', { class: 'visually-hidden', 'aria-live': 'polite' });

  const arm = new FallingArm(...(ARM.slice(0, 5) as Tuple<5>));
  const twin = new FallingArm(...(ARM.slice(0, 5) as Tuple<5>));
  const stage = planarPicture('The released pendulum and its twin', 2.25);
  const [body, ghost, trail] = [armDrawing(), armDrawing('thin second'), fadingTrail()];
  stage.plane.append(trail.element, ghost.element, body.element);
  const plots = plotGroup();
  const apart = plot({
    group: plots,
    title: 'Distance of the tips', unit: 'm, log scale', lines: [{ name: 'distance', tone: 'second' }],
    logFrom: 1e-9, atLeast: [1e-5, 4], height: 150,
  });
  let times: number[] = [];
  let distances: number[] = [];
  const numbers = readings('Start and flip', [
    ['t1', 'inner rod', '°'], ['t2', 'outer rod', '°'], ['flip', 'first flip', ''], ['t', 't', 's'], ['apart', 'distance', 'm'],
  ]);

  /** The position of the cross, from 0 to 1. */
  const place = (): [number, number] =>
    [(dropped[0] - view.x) / (2 * view.half) + 0.5, 0.5 - (dropped[1] - view.y) / (2 * view.half)];
  const inside = ([x, y]: [number, number]): boolean => x >= 0 && x <= 1 && y >= 0 && y <= 1;
  const draw = (beat = 0): void => {
    const at = place();
    set(cross, { transform: `translate(${at[0].toFixed(5)} ${at[1].toFixed(5)})`, visibility: inside(at) ? 'visible' : 'hidden' });
    body.draw(armPoints(arm.points));
    ghost.draw(armPoints(twin.points));
    if (beat % 3 === 0) {
      const [, x, y] = columns(arm.samples(), 8);
      trail.draw(x!.subarray(-150), y!.subarray(-150));
      apart.draw(times, [distances]);
    }
    if (beat % 6 !== 0) return;
    const degrees = (angle: number): string => show((angle * 180) / Math.PI, 2);
    numbers.draw({
      t1: degrees(dropped[0]), t2: degrees(dropped[1]), flip: inside(at) ? flipWords(map.at(...at)) : 'outside the map',
      t: show(arm.time, 2), apart: show(arm.tipDistance(twin), 4),
    });
  };
  const reset = (): void => {
    const still = Float64Array.of(0, 0);
    const start = (more: number): Float64Array => Float64Array.of(dropped[0] - Math.PI / 2 + more, dropped[1] - dropped[0]);
    arm.place(start(0), still);
    twin.place(start(TWIN_APART), still);
    [times, distances] = [[], []];
    draw();
  };
  const clock = transport({
    step: () => 1e-3,
    advance: (steps) => {
      arm.advance(steps);
      twin.advance(steps);
      times.push(arm.time);
      distances.push(arm.tipDistance(twin));
      if (times.length > KEPT) [times, distances] = [times.slice(-KEPT), distances.slice(-KEPT)];
    },
    draw,
    reset,
    describe: () => `Paused at ${show(arm.time, 2)} seconds; the twins’ tips are ${show(arm.tipDistance(twin), 4)} metres apart.`,
    single: 10,
  });
  const drop = (x: number, y: number): void => {
    dropped = [view.x + (2 * x - 1) * view.half, view.y + (1 - 2 * y) * view.half];
    clock.say('');
    reset();
    clock.play();
    over.dispatchEvent(new Event('settled', { bubbles: true }));
  };
  const look = (next: View): void => {
    const half = Math.min(Math.PI, Math.max(1e-6, next.half));
    const within = (middle: number): number => Math.min(Math.PI - half, Math.max(half - Math.PI, middle));
    view = { x: within(next.x), y: within(next.y), half };
    map.look(view);
    draw();
    over.dispatchEvent(new Event('settled', { bubbles: true }));
  };
  /** About the cross if it is in view, otherwise about the centre. */
  const zoom = (by: number): void => {
    const [x, y] = inside(place()) ? dropped : [view.x, view.y];
    look({ x: x + (view.x - x) * by, y: y + (view.y - y) * by, half: view.half * by });
  };

  over.addEventListener('pointerdown', (event) => {
    const box = over.getBoundingClientRect();
    drop((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
  });
  over.addEventListener('keydown', (event) => {
    const way = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (way !== undefined) {
      const [x, y] = inside(place()) ? dropped : [view.x, view.y];
      const to = (from: number, sign: number): number => Math.min(Math.PI, Math.max(-Math.PI, from + (sign * view.half) / 32));
      dropped = [to(x, way[0]!), to(y, way[1]!)];
      clock.pause();
      reset();
      heard.textContent = `First flip: ${flipWords(map.at(...place()))}`;
    } else if (event.key === 'Enter') drop(...place());
    else if (event.key === '+' || event.key === '=') zoom(0.5);
    else if (event.key === '-') zoom(2);
    else if (event.key === '0') look(WHOLE);
    else return;
    event.preventDefault();
  });
  const zooms = buttonRow('Zoom', button('Zoom in', () => { zoom(0.5); }), button('Zoom out', () => { zoom(2); }),
    button('Whole map', () => { look(WHOLE); }));
  const lab = button('Open in the Lagrangian lab', () => {
    const [q1, q2] = [dropped[0] - Math.PI / 2, dropped[1] - dropped[0]];
    location.hash = `#lagrangian-lab?q1=${q1.toPrecision(9)}&q2=${q2.toPrecision(9)}`;
  }, 'quiet');

  const begin = async (): Promise<void> => {
    try {
      const { flipWorkers } = await import('../flips/workers.ts');
      const { flipCard, graphicsCard } = await import('../flips/card.ts');
      const [workers, card] = await Promise.all([flipWorkers(ARM), graphicsCard()]);
      pools = { workers, card: card && flipCard(card, ARM) };
      void card?.lost.then(() => {
        pools = { workers, card: undefined };
        map.look(view);
      });
      map.look(view);
    } catch (error) {
      says.textContent = `The map cannot be computed here: ${error instanceof Error ? error.message : String(error)}`;
    }
  };
  const method = html('p', { class: 'says' });
  const scale = html('div', { class: 'flip-scale' },
    html('span', { class: 'flip-bar', 'aria-hidden': 'true' }),
    html('span', { class: 'flip-ends' }, ...['0.4 s', 'first flip', `${String(LATEST)} s`].map((text) => html('span', {}, text))),
    html('span', { class: 'flip-never' }, 'never'));
  const axes = html('figcaption', {}, 'Across: the inner rod’s angle from hanging; up: the outer rod’s. In the middle both hang, '
    + 'at the edge one points up. Click to release that pendulum.');
  const alone = document.documentElement.dataset['alone'] !== undefined;

  const element = frame({
    id: ID,
    picture: [html('div', { class: 'pair flips-and-fall' },
      html('figure', { class: 'captioned' }, html('div', { class: 'flip-frame' }, map.element, over), scale, axes),
      html('figure', { class: 'captioned' }, stage.element, html('figcaption', {}, 'The pendulum dropped, and its twin.'), apart.element))],
    controls: [
      clock.element,
      html('div', { class: 'settings' }, zooms, progress, says, method),
      numbers.element,
      ...(alone ? [] : [lab]),
      heard,
    ],
    equations: [
      { name: 'flip', code: 'FlipMap::first_flips', says: 'angles from hanging, δ = θ₂ − θ₁' },
      { name: 'flip2', code: 'FlipMap::first_flips', says: 'the same arm as M q̈ + C q̇ + g = 0' },
    ],
    plots,
    share: () => ({ t1: dropped[0], t2: dropped[1], x: view.x, y: view.y, half: view.half, ...clock.shared() }),
  });
  new IntersectionObserver((entries) => {
    if (asked || !entries.some((entry) => entry.isIntersecting)) return;
    asked = true;
    void begin();
  }).observe(over);
  reset();
  return {
    id: ID, element,
    restore(values) {
      const angle = (name: string, usual: number): number => Math.min(Math.PI, Math.max(-Math.PI, numberFrom(values, name, usual)));
      dropped = [angle('t1', 2.2), angle('t2', 1.6)];
      clock.restore(values);
      clock.pause();
      look({ x: angle('x', 0), y: angle('y', 0), half: numberFrom(values, 'half', Math.PI) });
      reset();
    },
  };
}
