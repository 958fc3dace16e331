// The parameters of the two-link arm that the user can change: rods, gravity, joint friction, motors.
import { numberFrom, type Shared } from '../address.ts';
import { slider } from '../controls/slider.ts';
import { html } from '../element.ts';
import type { Tuple } from '../../lib/dynamics/index.ts';

/** Name, label, unit, minimum, maximum, step, the chapter's value. */
const NUMBERS = [
  ['l1', 'Length 1', 'm', 0.3, 1.2, 0.05, 1], ['m1', 'Mass 1', 'kg', 0.2, 5, 0.1, 2],
  ['l2', 'Length 2', 'm', 0.3, 1.2, 0.05, 1], ['m2', 'Mass 2', 'kg', 0.2, 5, 0.1, 1],
  ['gravity', 'Gravity', 'm/s²', 0, 25, 0.01, 9.81], ['damping', 'Damping', 'N·m·s', 0, 5, 0.05, 0],
  ['u1', 'Motor 1', 'N·m', -60, 60, 0.5, 0], ['u2', 'Motor 2', 'N·m', -30, 30, 0.5, 0],
] as const;
export type RodNumber = (typeof NUMBERS)[number][0];
/** The parameters that do not change the arm itself. */
const FORCES: ReadonlySet<RodNumber> = new Set(['damping', 'u1', 'u2'] as const);

export interface Rods {
  element: HTMLElement;
  readonly rods: Tuple<5>;
  readonly torque: Tuple<2>;
  /** Damping of both joints [N·m·s]. */
  readonly damping: number;
  /** Its part of the address: values that differ from the chapter's. */
  shared(): Shared;
  restore(values: URLSearchParams): void;
}

/** Sliders in a collapsed section. */
export function rodSliders(onRods: () => void, onForce: () => void): Rods {
  const sliders = new Map(NUMBERS.map(([name, label, unit, min, max, step, value]) =>
    [name, slider({ label, unit, min, max, step, value, onInput: FORCES.has(name) ? onForce : onRods })] as const));
  const value = (name: RodNumber): number => sliders.get(name)!.value;
  const element = html('details', { class: 'rods' },
    html('summary', {}, 'Rods, gravity, damping, motors'),
    html('div', { class: 'folded' }, ...[...sliders.values()].map((one) => one.element)));
  return {
    element,
    get rods(): Tuple<5> { return [value('l1'), value('m1'), value('l2'), value('m2'), value('gravity')]; },
    get torque(): Tuple<2> { return [value('u1'), value('u2')]; },
    get damping() { return value('damping'); },
    shared: () => {
      const changed = NUMBERS.filter(([name, , , , , , usual]) => value(name) !== usual);
      return Object.fromEntries(changed.map(([name]) => [name, value(name)]));
    },
    restore(values) {
      for (const [name, , , min, max, , usual] of NUMBERS) {
        sliders.get(name)!.set(Math.min(max, Math.max(min, numberFrom(values, name, usual))));
        if (values.has(name)) element.open = true;
      }
      onRods();
      onForce();
    },
  };
}
