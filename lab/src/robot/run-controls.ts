// Controls of a robot's motion: method, motors, pose, and their part of the address.
import { numberFrom, numbered, numbersFrom, wordFrom, type Shared } from '../address.ts';
import { choice, toggle } from '../controls/choice.ts';
import { slider } from '../controls/slider.ts';
import { html } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import { INTEGRATORS } from '../widgets/integrators.ts';
import type { EffectSwitches } from './effect-switches.ts';
import type { Actuators } from './actuators.ts';

/** The library's choice, and its methods by name. */
const METHODS: readonly (readonly [string, string])[] = [
  ['auto', 'Automatic'], ['implicit', 'Implicit'], ['mujoco', 'MuJoCo'], ...INTEGRATORS,
];

export interface RunControls {
  elements: HTMLElement[];
  readonly h: number;
  /** Loads the switches of effects and the actuators, before the first robot is shown. */
  ready(): Promise<void>;
  /** For a newly loaded robot: the longest stable step, with motors off. */
  suit(robot: Robot): void;
  /** Shows the texts of a rebuilt simulation. */
  show(robot: Robot): void;
  /** Makes the motors, if on, hold the robot's current pose. */
  grip(robot: Robot): void;
  /** Updates the controls that follow the robot. */
  draw(robot: Robot): void;
  shared(robot: Robot | undefined): Shared;
  restore(values: URLSearchParams): void;
  /** The part of an address that belongs to a loaded robot. */
  restoreOn(values: URLSearchParams): void;
}

/** `say` shows the user why a choice is not possible. */
export function runControls(robot: () => Robot | undefined, say: (text: string) => void): RunControls {
  /** The last valid choice for the robot. */
  let taken = { method: 'auto', h: 1e-3, off: [] as string[] };
  const withRobot = (act: (robot: Robot) => void): void => {
    const now = robot();
    if (now === undefined) return;
    try {
      act(now);
      say('');
    } catch (error) {
      say(error instanceof Error ? error.message : String(error));
    }
    effects?.show(now);
  };
  const choose = (of: Robot): void => {
    const next = { method: method.value, h: stepLength.value / 1000, off: effects?.off ?? off };
    try {
      of.choose(next.method === 'auto' ? '' : next.method, next.h, next.off);
      taken = next;
    } catch (error) {
      method.set(taken.method);
      stepLength.set(1000 * taken.h);
      effects?.set(taken.off);
      throw error;
    }
  };
  const changed = (): void => { withRobot(choose); };
  const hold = (of: Robot): void => {
    if (holding.on) of.hold(frequency.value, ratio.value);
    else of.release();
  };
  const regain = (): void => {
    withRobot((of) => {
      if (holding.on) of.holdAt(of.held, frequency.value, ratio.value);
    });
  };
  let effects: EffectSwitches | undefined;
  let servos: Actuators | undefined;
  /** The effects that an address switched off before the switches were loaded. */
  let off: string[] = [];
  const panels = html('div');
  const holding = toggle('Motors hold the pose', false, () => { withRobot(hold); });
  const method = choice<string>('Method', METHODS, 'auto', changed);
  const stepLength = slider({ label: 'Step h', unit: 'ms', min: 0.1, max: 10, step: 0.1, value: 1, onInput: changed });
  const frequency = slider({ label: 'Hold at', unit: 'rad/s', min: 0, max: 40, step: 1, value: 20, onInput: regain });
  const ratio = slider({ label: 'Damping ζ', unit: '', min: 0, max: 2, step: 0.05, value: 1, onInput: regain });
  const motors = html('details', {}, html('summary', {}, 'Method and gains'),
    html('div', { class: 'folded' }, method.element, stepLength.element, frequency.element, ratio.element));
  return {
    elements: [holding.element, panels, motors],
    get h() { return stepLength.value / 1000; },
    async ready() {
      if (effects !== undefined) return;
      const { effectSwitches, actuators } = await import('./panels.ts');
      [effects, servos] = [effectSwitches(changed), actuators(robot)];
      effects.set(off);
      panels.replaceChildren(effects.element, servos.element);
    },
    suit(of) {
      try {
        choose(of);
      } catch {
        // The choices of the previous robot do not apply to this one.
        method.set('auto');
        effects?.set([]);
        choose(of);
      }
      stepLength.set(1000 * of.steadyStep());
      taken.h = stepLength.value / 1000;
      servos?.suit(of);
      effects?.show(of);
    },
    show(of) { effects?.show(of); },
    grip(of) {
      if (holding.on || of.held.length > 0) hold(of);
    },
    draw(of) { servos?.draw(of); },
    shared(of) {
      const held = of?.held ?? [];
      return {
        h: stepLength.value / 1000, off: (effects?.off ?? off).join('.'),
        method: method.value, frequency: frequency.value, ratio: ratio.value,
        ...(held.length > 0 ? { hold: 1, ...numbered('to', held) } : {}), ...servos?.shared(of),
      };
    },
    restore(values) {
      // Older links switch friction off by a number.
      const friction = numberFrom(values, 'friction', 1) === 0 ? ['dissipation'] : [];
      off = [...(values.get('off') ?? '').split('.').filter((name) => name !== ''), ...friction];
      effects?.set(off);
      method.set(wordFrom(values, 'method', METHODS.map(([name]) => name), 'auto'));
      frequency.set(Math.min(40, Math.max(0, numberFrom(values, 'frequency', 20))));
      ratio.set(Math.min(2, Math.max(0, numberFrom(values, 'ratio', 1))));
      holding.set(numberFrom(values, 'hold', 0) !== 0);
    },
    restoreOn(values) {
      if (values.has('h')) stepLength.set(1000 * Math.min(0.01, Math.max(1e-4, numberFrom(values, 'h', 1e-3))));
      withRobot((now) => {
        choose(now);
        servos?.restoreOn(now, values);
        if (holding.on) now.holdAt(numbersFrom(values, 'to', now.q), frequency.value, ratio.value);
      });
    },
  };
}
