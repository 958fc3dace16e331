// A fork: at any time a second arm goes on with one law changed, drawn as a ghost. Plots show the distance of
// the arms and their energies, on the timeline of the first.
import { numbered, numbersFrom, wordFrom, type Shared } from '../address.ts';
import { button, choice } from '../controls/choice.ts';
import { armDrawing, armPoints } from '../drawing/planar-arm.ts';
import { plot } from '../drawing/plot.ts';
import type { PlotGroup } from '../drawing/plot-group.ts';
import { html, show } from '../element.ts';
import type { FallingArm, IntegratorName } from '../../lib/dynamics/index.ts';

const LAWS = [
  ['coriolis', 'without C q̇'], ['damping', 'without damping'], ['mass', 'outer rod 10 % heavier'],
  ['euler', 'by explicit Euler'], ['step', 'in steps ten times as long'],
] as const;
type Law = (typeof LAWS)[number][0];
const NAMES = LAWS.map(([law]) => law);
/** Number of points of the plot. */
const KEPT = 2000;

export interface Fork {
  /** The drawing of the second arm, for the plane of the picture. */
  ghost: SVGGElement;
  controls: HTMLElement;
  plots: HTMLElement[];
  advance(steps: number): void;
  draw(beat: number): void;
  /** Ends the fork. */
  end(): void;
  shared(): Shared;
  restore(values: URLSearchParams): void;
}

export function fork(
  arm: () => FallingArm, method: () => { name: IntegratorName; h: number }, draw: () => void, group: PlotGroup,
): Fork {
  let other: FallingArm | undefined;
  let owed = 0;
  let times: number[] = [];
  let apart: number[] = [];
  let energies: [number[], number[]] = [[], []];
  const drawing = armDrawing('thin second');
  drawing.element.setAttribute('visibility', 'hidden');
  const distance = plot({
    group,
    title: 'Distance of the tips', unit: 'm, log scale', lines: [{ name: 'distance', tone: 'second' }],
    logFrom: 1e-9, atLeast: [1e-6, 1], height: 140,
  });
  const both = plot({
    group,
    title: 'Energy since the fork', unit: 'J',
    lines: [{ name: 'the arm’s', tone: 'accent' }, { name: 'the fork’s', tone: 'second' }], height: 140,
  });
  const plots = [distance.element, both.element];
  for (const one of plots) one.hidden = true;
  const law = choice<Law>('One law changed', LAWS, 'coriolis', () => { if (other !== undefined) begin(); });
  const says = html('p', { class: 'says', 'aria-live': 'polite' });
  const toggle = button('Fork', () => {
    if (other === undefined) begin();
    else end();
    draw();
  });

  const begin = (): void => {
    other?.free();
    other = arm().fork(law.value === 'mass' ? 1.1 : 1);
    const { name, h } = method();
    if (law.value === 'coriolis') other.setCoriolis(false);
    if (law.value === 'damping') other.setDamping(0);
    if (law.value === 'euler') other.setMethod('explicit-euler', h);
    if (law.value === 'step') other.setMethod(name, 10 * h);
    [owed, times, apart, energies] = [0, [], [], [[], []]];
    measure();
    seen(true);
  };
  const end = (): void => {
    if (other === undefined) return;
    other.free();
    other = undefined;
    seen(false);
  };
  const seen = (on: boolean): void => {
    drawing.element.setAttribute('visibility', on ? 'visible' : 'hidden');
    for (const one of plots) one.hidden = !on;
    toggle.textContent = on ? 'End the fork' : 'Fork';
    if (!on) says.textContent = '';
  };
  const measure = (): void => {
    if (other === undefined) return;
    times.push(arm().time);
    apart.push(arm().tipDistance(other));
    [arm(), other].forEach(({ energies: { total } }, k) => { energies[k]!.push(total); });
    if (times.length <= KEPT) return;
    for (const list of [times, apart, ...energies]) list.shift();
  };

  return {
    ghost: drawing.element,
    controls: html('div', { class: 'fork' }, law.element, toggle, says),
    plots,
    advance(steps) {
      if (other === undefined) return;
      // One long step is due after ten short ones.
      owed += steps;
      const each = law.value === 'step' ? 10 : 1;
      const due = Math.floor(owed / each);
      owed -= due * each;
      other.advance(due);
      measure();
    },
    draw(beat) {
      if (other === undefined) return;
      drawing.draw(armPoints(other.points));
      if (beat % 4 === 0) distance.draw(times, [apart]);
      if (beat % 4 === 2 || beat === 0) both.draw(times, energies);
      if (beat % 6 !== 0) return;
      const isSame = law.value === 'damping' && arm().damping === 0;
      const text = `The fork’s energy is ${show(other.energies.total, 3)} J; the tips are ${show(arm().tipDistance(other), 3)} m apart.`
        + (isSame ? ' Neither arm is damped: give this one some damping.' : '');
      if (says.textContent !== text) says.textContent = text;
    },
    end,
    shared: () => (other === undefined ? {} : { fork: law.value, ...numbered('fq', other.q), ...numbered('fv', other.qd) }),
    restore(values) {
      end();
      if (!values.has('fork')) return;
      law.set(wordFrom(values, 'fork', NAMES, 'coriolis'));
      begin();
      other?.place(numbersFrom(values, 'fq', arm().q), numbersFrom(values, 'fv', arm().qd));
    },
  };
}
