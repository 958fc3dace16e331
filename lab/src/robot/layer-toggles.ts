// Switches for the layers of a robot.
import { numberFrom, type Shared } from '../address.ts';
import { roving, toggle } from '../controls/choice.ts';
import { html } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import { glowControl } from './glow-control.ts';
import type { Layers } from './stage.ts';

const LAYERS = [['shapes', 'Shapes', 1], ['collision', 'Collision', 0], ['inertia', 'Inertia', 0], ['forces', 'Forces', 1]] as const;

export interface LayerToggles {
  element: HTMLElement;
  readonly value: Layers;
  /** The current brightness of each link; undefined for none. */
  glow(): Float64Array | undefined;
  /** The value of the brightest link. */
  write(): void;
  /** Hides the switches of layers that a robot does not have. */
  suit(robot: Robot): void;
  shared(): Shared;
  restore(values: URLSearchParams): void;
}

export function layerToggles(onChange: () => void, onGlow: () => void): LayerToggles {
  const glow = glowControl(onGlow);
  const toggles = LAYERS.map(([name, label, usual]) => ({ name, usual, one: toggle(label, usual === 1, onChange) }));
  const on = (name: keyof Layers): boolean => toggles.find((entry) => entry.name === name)?.one.on ?? false;
  return {
    element: html('div', { class: 'looks' },
      roving(html('div', { class: 'layers', role: 'toolbar', 'aria-label': 'Layers' }, ...toggles.map(({ one }) => one.element))),
      glow.element),
    glow: glow.now,
    write: glow.write,
    get value() { return { shapes: on('shapes'), collision: on('collision'), inertia: on('inertia'), forces: on('forces') }; },
    suit(robot) {
      glow.suit(robot);
      for (const { name, one } of toggles) one.element.hidden = name === 'forces' && !robot.effects().includes('contacts');
    },
    shared: () => ({ ...Object.fromEntries(toggles.map(({ name, one }) => [name, one.on ? 1 : 0])), ...glow.shared() }),
    restore(values) {
      glow.restore(values);
      for (const { name, usual, one } of toggles) one.set(numberFrom(values, name, usual) !== 0);
    },
  };
}
