// The integrator race: one fall, four methods, ten minutes of simulated time in seconds.
import { numberFrom } from '../address.ts';
import { choice } from '../controls/choice.ts';
import { slider } from '../controls/slider.ts';
import { transport } from '../controls/transport.ts';
import type { Tone } from '../drawing/colours.ts';
import { armDrawing, armPoints, planarPicture } from '../drawing/planar-arm.ts';
import { plot } from '../drawing/plot.ts';
import { plotGroup } from '../drawing/plot-group.ts';
import { html, scientific, show } from '../element.ts';
import { Race } from '../../lib/dynamics/index.ts';
import { type Standing, standing } from '../race/standing.ts';
import type { RaceThread } from '../race/thread.ts';
import type { Start } from '../race/worker.ts';
import { frame, type Widget } from './frame.ts';

const RUNNERS: readonly { name: string; label: string; tone: Tone; dashed: boolean; says: string }[] = [
  { name: 'explicit-euler', label: 'Explicit Euler', tone: 'muted', dashed: true, says: 'adds energy' },
  {
    name: 'semi-implicit-euler', label: 'Semi-implicit Euler', tone: 'ink', dashed: true,
    says: 'symplectic only where M is constant; here it is not',
  },
  { name: 'rk4', label: 'Runge–Kutta 4', tone: 'accent', dashed: false, says: 'very small, and growing' },
  {
    name: 'variational-midpoint', label: 'Variational midpoint', tone: 'second', dashed: false, says: 'larger, and bounded',
  },
];

export function integratorRace(): Widget {
  let h = 1e-3;
  let duration = 600;
  let now: Standing;
  let thread: RaceThread | undefined;
  /** Steps that were requested, possibly before the worker was loaded. */
  let asked = 0;
  let began = 0;
  let spent = 0;

  const picture = planarPicture('The four arms now', 2.25);
  const arms = RUNNERS.map(({ tone }) => armDrawing(`thin ${tone}`));
  picture.plane.append(...arms.map((arm) => arm.element));
  const plots = plotGroup();
  const errors = plot({
    group: plots,
    title: 'Largest energy error in each interval', unit: '|E − E₀|/|E₀|, log scale',
    lines: RUNNERS.map(({ label, tone, dashed }) => ({ name: label, tone, dashed })),
    logFrom: 1e-12, atLeast: [1e-10, 1], height: 320,
  });
  const cells = RUNNERS.map(() => ({ drift: html('td'), fate: html('td') }));
  const table = html('table', { class: 'runners' },
    html('thead', {}, html('tr', {},
      ...['Method', 'Largest error'].map((text) => html('th', { scope: 'col' }, text)),
      html('th', { scope: 'col' }, html('span', { class: 'visually-hidden' }, 'What it does')))),
    html('tbody', {}, ...RUNNERS.map(({ label, tone, dashed }, i) => html('tr', {},
      html('th', { scope: 'row' }, html('span', { class: `key ${tone}${dashed ? ' dashed' : ''}` }, label)),
      cells[i]!.drift, cells[i]!.fate))));
  const progress = html('progress', { max: 1, value: 0, 'aria-label': 'Simulated time' });
  const clockText = html('p', { class: 'progress-text', 'data-reading': 'time' });

  const beginning = (): Start => ({
    names: RUNNERS.map(({ name }) => name), q: Float64Array.of(Math.PI / 4, Math.PI / 2), qd: Float64Array.of(0, 0), h, duration,
  });
  const start = (): void => {
    const { names, q, qd } = beginning();
    const race = new Race(names, q, qd, h, duration);
    now = standing(race, names.length);
    race.free();
    [began, spent, asked] = [0, 0, 0];
    thread?.start(beginning());
    draw();
  };
  const begin = async (): Promise<void> => {
    const { raceThread } = await import('../race/thread.ts');
    thread = await raceThread((next) => {
      now = next;
      if (began > 0) spent = (performance.now() - began) / 1000;
      if (clock.playing && now.time > duration - h / 2) clock.pause();
      else if (!clock.playing) draw();
    });
    thread.start(beginning());
    asked = thread.advance(asked);
  };
  const draw = (beat = 0): void => {
    now.runners.forEach(({ points }, i) => { arms[i]!.draw(armPoints(points)); });
    if (beat % 3 !== 0) return;
    errors.draw(now.times, now.runners.map((runner) => runner.errors));
    now.runners.forEach(({ drift, fault }, i) => {
      write(cells[i]!.drift, scientific(drift));
      write(cells[i]!.fate, fault === '' ? RUNNERS[i]!.says : `dropped out: ${fault}`);
    });
    progress.value = Math.min(1, now.time / duration);
    const taken = spent > 0 ? `, in ${show(spent, 1)} s` : '';
    write(clockText, `${show(now.time, 1)} s of ${show(duration, 0)} s simulated${taken}`);
  };
  const clock = transport({
    step: () => h,
    advance: (steps) => {
      if (began === 0) began = performance.now();
      const due = Math.min(steps, Math.round(duration / h) - asked);
      asked += thread === undefined ? due : thread.advance(due);
    },
    draw,
    reset: start,
    describe: () => {
      const errors = RUNNERS.map(({ label }, i) => `${label}: ${scientific(now.runners[i]!.drift)}`);
      return `${show(now.time, 0)} seconds simulated. ${errors.join('. ')}.`;
    },
    single: 1000,
    fastest: 400,
    usual: 400,
  });
  const stepLength = slider({
    label: 'Step h', unit: 'ms', min: 0.5, max: 50, step: 0.5, value: 1, onInput: (ms) => { h = ms / 1000; start(); },
  });
  const lengths = [['60', 'one minute'], ['600', 'ten minutes'], ['3600', 'one hour']] as const;
  const length = choice('Race over', lengths, '600', (text) => { duration = Number(text); start(); });

  const element = frame({
    id: 'integrator-race',
    picture: [errors.element, html('div', { class: 'pair' },
      html('figure', { class: 'captioned' }, picture.element, html('figcaption', {}, 'Where the four arms are now.')),
      html('div', { class: 'table', tabindex: 0, role: 'region', 'aria-label': 'The runners' }, table))],
    controls: [
      clock.element,
      html('div', { class: 'settings' }, length.element, stepLength.element, progress, clockText),
    ],
    plots,
    equations: [
      { name: 'drift', code: 'dynamics::energy_drift', says: 'the plotted quantity' },
      { name: 'rk4', code: 'dynamics::rk4_step', says: 'order 4' },
      { name: 'midpoint', code: 'dynamics::variational_midpoint_step', says: 'a discrete action: order 2, symplectic, reversible' },
    ],
    share: () => ({ h, duration, ...clock.shared() }),
  });
  start();
  // The worker is loaded when the experiment becomes visible.
  new IntersectionObserver((entries, observer) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    begin().catch((error: unknown) => {
      clock.say(`The race cannot be run here: ${error instanceof Error ? error.message : String(error)}`);
    });
  }, { rootMargin: '400px' }).observe(element);
  return {
    id: 'integrator-race', element,
    restore(values) {
      h = Math.min(0.05, Math.max(5e-4, numberFrom(values, 'h', 1e-3)));
      duration = Math.min(3600, Math.max(1, numberFrom(values, 'duration', 600)));
      stepLength.set(1000 * h);
      length.set(String(duration) as '600');
      clock.restore(values);
      clock.pause();
      start();
    },
  };
}

/** Updates an element only if its text differs. */
function write(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}
