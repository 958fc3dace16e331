// Horizontal bars from a common zero, with numbers.
import { html, show } from '../element.ts';
import type { Tone } from './colours.ts';

export interface Bar {
  name: string;
  unit: string;
  tone: Tone;
}

export interface Bars {
  element: HTMLElement;
  /** One value per bar; `extent` is the value at full width; `reference` marks a value on the last bar. */
  draw(values: readonly number[], extent: number, reference?: number): void;
}

export function bars(label: string, list: readonly Bar[], digits = 3): Bars {
  const rows = list.map(({ name, unit, tone }) => {
    const fill = html('span', { class: `fill ${tone}` });
    const line = html('span', { class: 'reference' });
    const number = html('span', { class: 'number' });
    const row = html(
      'div',
      { class: 'bar' },
      html('span', { class: 'name' }, name),
      html('span', { class: 'track', 'aria-hidden': 'true' }, fill, html('span', { class: 'zero' }), line),
      number,
      html('span', { class: 'unit' }, unit),
    );
    return { row, fill, line, number };
  });
  const element = html('div', { class: 'bars', role: 'group', 'aria-label': label }, ...rows.map(({ row }) => row));
  return {
    element,
    draw(values, extent, reference) {
      rows.forEach(({ fill, line, number }, i) => {
        // Bars are scaled by a transform, which needs no layout.
        const share = Math.max(-1, Math.min(1, (values[i] ?? 0) / extent));
        fill.style.transform = `scaleX(${(share / 2).toFixed(4)})`;
        fill.dataset['share'] = share.toFixed(3);
        const marked = reference !== undefined && i === rows.length - 1;
        line.hidden = !marked;
        if (marked) line.style.left = `${(50 + (reference / extent) * 50).toFixed(2)}%`;
        const text = show(values[i] ?? 0, digits);
        if (number.textContent !== text) number.textContent = text;
      });
    },
  };
}
