// A number in a sentence that is changed by dragging sideways or by arrow keys.
import { html, show } from '../element.ts';

export interface ScrubOptions {
  label: string;
  unit?: string;
  min: number;
  max: number;
  step: number;
  value: number;
  /** The term of the formula that this number affects. */
  term?: string;
  onInput: (value: number) => void;
}

export interface Scrub {
  element: HTMLElement;
  readonly value: number;
  /** Shows a value without calling back. */
  set(value: number): void;
}

/** Drag distance in pixels for one step. */
const PIXELS = 5;

export function scrub(options: ScrubOptions): Scrub {
  const { label, unit = '', min, max, step, term, onInput } = options;
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  let value = options.value;
  const element = html('span', {
    class: 'scrub', role: 'slider', tabindex: 0, 'aria-label': label, 'aria-valuemin': min, 'aria-valuemax': max,
    'data-lights': term,
  });
  const write = (): void => {
    element.textContent = `${show(value, digits)}${unit === '' || unit === '°' ? unit : ` ${unit}`}`;
    element.setAttribute('aria-valuenow', value.toFixed(digits));
    element.setAttribute('aria-valuetext', `${value.toFixed(digits)} ${unit}`.trim());
  };
  const go = (to: number): void => {
    const next = Math.min(max, Math.max(min, Math.round(to / step) * step));
    if (Math.abs(next - value) < 1e-12) return;
    value = next;
    write();
    onInput(value);
    element.dispatchEvent(new Event('moved', { bubbles: true }));
  };
  let from: { x: number; value: number } | undefined;
  element.addEventListener('pointerdown', (event) => {
    event.preventDefault();
    element.focus({ preventScroll: true });
    element.setPointerCapture(event.pointerId);
    from = { x: event.clientX, value };
  });
  element.addEventListener('pointermove', (event) => {
    if (from !== undefined) go(from.value + Math.round((event.clientX - from.x) / PIXELS) * step);
  });
  for (const end of ['pointerup', 'pointercancel'] as const) element.addEventListener(end, () => { from = undefined; });
  element.addEventListener('keydown', (event) => {
    const by: Record<string, number> = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 };
    const to = event.key === 'Home' ? min : event.key === 'End' ? max : value + (by[event.key] ?? NaN) * step;
    if (Number.isNaN(to)) return;
    event.preventDefault();
    go(to);
  });
  write();
  return {
    element,
    get value() { return value; },
    set(next) {
      value = next;
      write();
    },
  };
}
