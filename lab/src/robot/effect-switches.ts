// Switches for the effects of a robot's file, and a list of those that the simulation leaves out.
import { toggle, type Toggle } from '../controls/choice.ts';
import { html } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';

/** Backticks mark the library's names. */
const quoted = (line: string): string => line.replace(/`([^`]*)`/g, '“$1”');

/** Labels by the library's names. */
const EFFECTS: readonly (readonly [string, string])[] = [
  ['dissipation', 'Damping, friction, fluid'], ['limits', 'Position limits'], ['effort-limits', 'Effort limits of torques'],
  ['springs', 'Springs and tendons'], ['actuators', 'Actuators of the file'], ['equalities', 'Closed loops, couplings'],
  ['contacts', 'Contacts'], ['link-contacts', 'Contacts between links'],
];

export interface EffectSwitches {
  element: HTMLElement;
  /** The effects that are switched off. */
  readonly off: string[];
  set(off: readonly string[]): void;
  /** Shows switches for the effects of the robot's file, and the simulation's texts. */
  show(robot: Robot): void;
}

export function effectSwitches(onChange: () => void): EffectSwitches {
  const switches = new Map<string, Toggle>(EFFECTS.map(([name, label]) => [name, toggle(label, true, onChange)]));
  const method = html('p', { class: 'says', 'data-reading': 'method' });
  const absent = html('ul', { class: 'left-out', 'aria-label': 'Left out of the simulation' });
  const element = html('details', { class: 'acting' }, html('summary', {}, 'Effects'),
    html('div', { class: 'folded' }, ...Array.from(switches.values(), (one) => one.element)));
  const off = (): string[] => EFFECTS.map(([name]) => name).filter((name) => switches.get(name)?.on === false);
  return {
    element: html('div', { class: 'simulation' }, method, absent, element),
    get off() { return off(); },
    set(names) {
      for (const [name, one] of switches) one.set(!names.includes(name));
    },
    show(robot) {
      const stated = robot.effects();
      const now = new Set(robot.acting());
      for (const [name, one] of switches) {
        one.element.hidden = !stated.includes(name);
        // Without contacts there are no contacts of links.
        one.element.classList.toggle('idle', one.on && !now.has(name));
      }
      element.hidden = stated.length === 0;
      method.textContent = `Steps by ${robot.method}: ${robot.reason}.`;
      const lines = robot.leftOut;
      absent.hidden = lines.length === 0;
      absent.replaceChildren(...lines.map((line) => html('li', {}, quoted(line))));
      absent.dataset['count'] = String(lines.length);
    },
  };
}
