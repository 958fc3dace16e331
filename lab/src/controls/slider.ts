// A slider with a number beside it: drag it, use arrow keys, or type the value.
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

/** One tab stop: the number, which accepts digits and arrow keys. The slider beside it is for pointers. */
export function slider(options: SliderOptions): Slider {
  const { label, unit = '', min, max, step, onInput } = options;
  const id = `slider-${String((count += 1))}`;
  let value = options.value;
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const text = (x: number): string => String(Number(x.toFixed(digits + 1)));
  const range = html('input', { type: 'range', min, max, step: 'any', tabindex: -1, 'aria-label': `${label}, by dragging` });
  const number = html('input', { type: 'number', id, min, max, step: 'any', 'aria-label': `${label}${unit && `, ${unit}`}` });

  let written = NaN;
  let typing = false;
  const write = (from?: HTMLInputElement): void => {
    if (value === written && from === undefined && number.value === text(value)) return;
    written = value;
    if (from !== range) range.value = String(value);
    if (from !== number) number.value = text(value);
    range.setAttribute('aria-valuetext', `${text(value)} ${unit}`.trim());
    range.style.setProperty('--share', `${String(((value - min) / (max - min)) * 100)}%`);
  };
  range.addEventListener('input', () => {
    // Dragging gives whole steps, typing any value.
    value = clamp(Math.round(Number(range.value) / step) * step, min, max);
    write(range);
    onInput(value);
  });
  const byKeys = (event: KeyboardEvent): void => {
    const by: Record<string, number> = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 };
    // In the number, left and right move the text cursor.
    if (event.target === range) Object.assign(by, { ArrowRight: 1, ArrowLeft: -1 });
    const steps = by[event.key];
    if (steps === undefined) return;
    event.preventDefault();
    value = clamp((Math.round(value / step) + steps) * step, min, max);
    write();
    onInput(value);
  };
  range.addEventListener('keydown', byKeys);
  number.addEventListener('keydown', byKeys);
  number.addEventListener('input', () => {
    const typed = number.valueAsNumber;
    if (!Number.isFinite(typed) || typed < min || typed > max) return;
    value = typed;
    typing = true;
    write(number);
    onInput(value);
  });
  for (const end of ['change', 'blur']) {
    number.addEventListener(end, () => {
      typing = false;
      write();
    });
  }
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
      // A value that is being typed is not overwritten.
      write(typing ? number : undefined);
    },
  };
}

function clamp(x: number, min: number, max: number): number {
  return Math.min(max, Math.max(min, x));
}
