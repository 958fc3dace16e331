// A torque gauge: the value on a half circle with the limit marked on both sides; beyond it the needle is red
// and stops.
import { html, set, show, svg } from '../element.ts';

export interface Gauge {
  element: HTMLElement;
  draw(value: number, peak: number): void;
}

const SWEEP = 0.75 * Math.PI;

/** The dial ends at 1.25 times the limit, where the needle stops. The number is below the dial. */
export function gauge(name: string, unit: string, limit: number): Gauge {
  const needle = svg('line', { class: 'needle', x1: 0, y1: 0, x2: 0, y2: -0.82 });
  const text = svg('text', { class: 'value', y: 1, 'text-anchor': 'middle' });
  const picture = svg(
    'svg',
    { viewBox: '-1.15 -1.15 2.3 2.25', 'aria-hidden': 'true' },
    svg('path', { class: 'dial', d: arc(-1, 1) }),
    svg('path', { class: 'over', d: arc(-1, -0.8) }),
    svg('path', { class: 'over', d: arc(0.8, 1) }),
    needle,
    svg('circle', { class: 'hub', r: 0.07 }),
    text,
  );
  const state = html('span', { class: 'state' });
  const element = html(
    'div',
    { class: 'gauge', role: 'group', 'aria-label': name },
    picture,
    html('p', {}, html('strong', {}, name), html('span', {}, `limit ${String(limit)} ${unit}`), state),
  );
  return {
    element,
    draw(value, peak) {
      const share = Math.max(-1, Math.min(1, value / (1.25 * limit)));
      const degrees = (share * SWEEP * 180) / Math.PI;
      set(needle, { transform: `rotate(${degrees.toFixed(2)})` });
      text.textContent = `${show(value, 1)} ${unit}`;
      const over = peak > limit;
      element.classList.toggle('pegged', over);
      element.dataset['pegged'] = String(over);
      const words = `peak ${show(peak, 1)} ${unit}, ${over ? 'over the limit' : 'within the limit'}`;
      if (state.textContent !== words) state.textContent = words;
    },
  };
}

/** A section of the dial, between two fractions of full scale. */
function arc(from: number, to: number): string {
  const at = (share: number): string => {
    const angle = share * SWEEP;
    return `${Math.sin(angle).toFixed(4)} ${(-Math.cos(angle)).toFixed(4)}`;
  };
  const large = (to - from) * SWEEP > Math.PI ? 1 : 0;
  return `M${at(from)}A1 1 0 ${String(large)} 1 ${at(to)}`;
}
