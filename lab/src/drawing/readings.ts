// Numbers with names and units, in a list.
import { html } from '../element.ts';

export interface Readings {
  element: HTMLElement;
  draw(values: Record<string, string>): void;
}

/** Each entry: a key, a label, a unit. */
export function readings(label: string, entries: readonly (readonly [string, string, string])[]): Readings {
  const outputs = new Map<string, HTMLElement>();
  const shown = new Map<string, string>();
  const rows = entries.map(([key, name, unit]) => {
    const value = html('span', { 'data-reading': key });
    outputs.set(key, value);
    return html('div', {}, html('dt', {}, name), html('dd', {}, value, html('span', { class: 'unit' }, unit)));
  });
  return {
    element: html('dl', { class: 'readings', 'aria-label': label }, ...rows),
    draw(values) {
      for (const [key, value] of Object.entries(values)) {
        if (shown.get(key) === value) continue;
        shown.set(key, value);
        const output = outputs.get(key);
        if (output !== undefined) output.textContent = value;
      }
    },
  };
}
