// A slider with a number beside it: drag, arrow keys, or type the value.
import { html } from '../element.ts';

export interface SliderOptions {
  label: string;
  unit?: string;
  min: number;
  max: number;
  step: number;
  value: number;
  onInput: (value: number) => void;
}

export interface Slider {
  element: HTMLElement;
  readonly value: number;
  /** Shows a value without calling back. */
  set(value: number): void;
}

let count = 0;

export function slider(options: SliderOptions): Slider {
  const { label, unit = '', min, max, step, onInput } = options;
  const id = `slider-${String((count += 1))}`;
  let value = options.value;
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const text = (x: number): string => String(Number(x.toFixed(digits + 1)));
  const range = html('input', { type: 'range', id, min, max, step: 'any' });
  const number = html('input', { type: 'number', min, max, step: 'any', 'aria-label': `${label}${unit && `, ${unit}`}` });

  const write = (from?: HTMLInputElement): void => {
    if (from !== range) range.value = String(value);
    if (from !== number) number.value = text(value);
    range.setAttribute('aria-valuetext', `${text(value)} ${unit}`.trim());
    range.style.setProperty('--share', `${String(((value - min) / (max - min)) * 100)}%`);
  };
  range.addEventListener('input', () => {
    // Whole steps while dragging; typing is free.
    value = clamp(Math.round(Number(range.value) / step) * step, min, max);
    write(range);
    onInput(value);
  });
  range.addEventListener('keydown', (event) => {
    const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (sign === undefined) return;
    event.preventDefault();
    value = clamp((Math.round(value / step) + sign) * step, min, max);
    write();
    onInput(value);
  });
  number.addEventListener('input', () => {
    const typed = number.valueAsNumber;
    if (!Number.isFinite(typed) || typed < min || typed > max) return;
    value = typed;
    write(number);
    onInput(value);
  });
  number.addEventListener('change', () => {
    write();
  });
  write();
  const element = html(
    'div',
    { class: 'slider' },
    html('label', { for: id }, label),
    range,
    html('span', { class: 'entry' }, number, html('span', { class: 'unit' }, unit)),
  );
  return {
    element,
    get value() {
      return value;
    },
    set(next) {
      value = next;
      write();
    },
  };
}

function clamp(x: number, min: number, max: number): number {
  return Math.min(max, Math.max(min, x));
}
