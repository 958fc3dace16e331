// The effects that act on a robot: a switch for each effect that its file states, and a list of those that the simulation leaves out.
import { toggle, type Toggle } from '../controls/choice.ts';
import { html } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';

/** The library's names are set off by backticks. */
const quoted = (line: string): string => line.replace(/`([^`]*)`/g, '“$1”');

/** By the library's names. */
const EFFECTS: readonly (readonly [string, string])[] = [
  ['dissipation', 'Damping and friction'], ['limits', 'Position limits'], ['effort-limits', 'Effort limits of torques'],
  ['springs', 'Springs and tendons'], ['actuators', 'Actuators of the file'], ['equalities', 'Closed loops, couplings'],
  ['contacts', 'Contacts'], ['link-contacts', 'Contacts between links'],
];

export interface Acting {
  element: HTMLElement;
  /** The effects that are switched off. */
  readonly off: string[];
  set(off: readonly string[]): void;
  /** Switches for what the robot's file states, and what is said of the simulation. */
  show(robot: Robot): void;
}

export function acting(onChange: () => void): Acting {
  const switches = new Map<string, Toggle>(EFFECTS.map(([name, label]) => [name, toggle(label, true, onChange)]));
  const method = html('p', { class: 'says', 'data-reading': 'method' });
  const absent = html('ul', { class: 'left-out', 'aria-label': 'Left out of the simulation' });
  const element = html('details', { class: 'acting' }, html('summary', {}, 'What acts'),
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
        // Links touch nothing while contacts are switched off.
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
