// Which layers of a robot are seen.
import { numberFrom, type Shared } from '../address.ts';
import { toggle } from '../controls/choice.ts';
import { html } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import type { Layers } from './stage.ts';

const LAYERS = [['shapes', 'Shapes', 1], ['collision', 'Collision', 0], ['inertia', 'Inertia', 0], ['forces', 'Forces', 1]] as const;

export interface LayerToggles {
  element: HTMLElement;
  readonly value: Layers;
  /** Leaves out what a robot has none of. */
  suit(robot: Robot): void;
  shared(): Shared;
  restore(values: URLSearchParams): void;
}

export function layerToggles(onChange: () => void): LayerToggles {
  const toggles = LAYERS.map(([name, label, usual]) => ({ name, usual, one: toggle(label, usual === 1, onChange) }));
  const on = (name: keyof Layers): boolean => toggles.find((entry) => entry.name === name)?.one.on ?? false;
  return {
    element: html('div', { class: 'layers', role: 'group', 'aria-label': 'Layers' }, ...toggles.map(({ one }) => one.element)),
    get value() { return { shapes: on('shapes'), collision: on('collision'), inertia: on('inertia'), forces: on('forces') }; },
    suit(robot) {
      for (const { name, one } of toggles) one.element.hidden = name === 'forces' && !robot.floats;
    },
    shared: () => Object.fromEntries(toggles.map(({ name, one }) => [name, one.on ? 1 : 0])),
    restore(values) {
      for (const { name, usual, one } of toggles) one.set(numberFrom(values, name, usual) !== 0);
    },
  };
}
