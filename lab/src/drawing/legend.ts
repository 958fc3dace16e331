// The legend of an arm's drawing, by name and colour; each layer can be switched off.
import type { Shared } from '../address.ts';
import { roving } from '../controls/choice.ts';
import { html } from '../element.ts';
import type { Layer, MechanismDrawing } from './mechanism.ts';

/** `drive` names the sum of the first three torques. */
const names = (drive: string): readonly (readonly [Layer, string, readonly (readonly [string, string])[]])[] => [
  ['angles', 'angles', [['ink', 'q']]],
  ['torques', 'torques', [['second', 'M q̈'], ['accent', 'C q̇'], ['muted', 'g'], ['ink', drive]]],
  ['weights', 'weights', [['muted', 'm g']]],
  ['mass', 'mass at the tip', [['second', 'Λ']]],
  ['trail', 'trail', [['accent', '']]],
];

export interface Legend {
  element: HTMLElement;
  /** Its part of the address: the hidden layers, if they are not the default. */
  shared(): Shared;
  restore(values: URLSearchParams): void;
}

export function legend(drawing: MechanismDrawing, redraw: () => void, hidden: readonly Layer[] = [], drive = 'u'): Legend {
  const off = new Set<Layer>();
  const buttons = names(drive).map(([layer, name, keys]) => {
    const marks = keys.map(([tone, symbol]) => html('span', { class: `key ${tone}` }, symbol));
    const one = html('button', { type: 'button', class: 'layer', 'aria-pressed': 'true', click: () => {
      put(layer, off.has(layer));
      redraw();
    } }, html('span', { class: 'layer-name' }, name), ...marks);
    return [layer, one] as const;
  });
  const put = (layer: Layer, on: boolean): void => {
    if (on) off.delete(layer);
    else off.add(layer);
    drawing.show(layer, on);
    buttons.find(([one]) => one === layer)?.[1].setAttribute('aria-pressed', String(on));
  };
  for (const layer of hidden) put(layer, false);
  const words = (): string => [...off].sort().join(' ');
  const usual = words();
  return {
    element: roving(html('div', { class: 'layers-row', role: 'toolbar', 'aria-label': 'What is drawn on the arm' },
      ...buttons.map(([, one]) => one))),
    shared: () => (words() === usual ? {} : { off: words() }),
    restore(values) {
      const named = (values.get('off') ?? usual).split(' ');
      for (const [layer] of buttons) put(layer, !named.includes(layer));
    },
  };
}
