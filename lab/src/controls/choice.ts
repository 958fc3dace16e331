// Choices among a few words, and switches.
import { html } from '../element.ts';

export interface Choice<W extends string> {
  element: HTMLElement;
  readonly value: W;
  set(value: W): void;
}

let count = 0;

export function choice<W extends string>(
  label: string,
  options: readonly (readonly [W, string])[],
  value: W,
  onChange: (value: W) => void,
): Choice<W> {
  const id = `choice-${String((count += 1))}`;
  const select = html('select', { id }, ...options.map(([word, text]) => html('option', { value: word }, text)));
  select.value = value;
  select.addEventListener('change', () => {
    onChange(select.value as W);
  });
  return {
    element: html('div', { class: 'choice' }, html('label', { for: id }, label), select),
    get value() {
      return select.value as W;
    },
    set(next) {
      select.value = next;
    },
  };
}

export interface Toggle {
  element: HTMLElement;
  readonly on: boolean;
  set(on: boolean): void;
}

export function toggle(label: string, on: boolean, onChange: (on: boolean) => void): Toggle {
  const box = html('input', { type: 'checkbox', role: 'switch' });
  box.checked = on;
  box.addEventListener('change', () => {
    onChange(box.checked);
  });
  return {
    element: html('label', { class: 'toggle' }, box, html('span', {}, label)),
    get on() {
      return box.checked;
    },
    set(next) {
      box.checked = next;
    },
  };
}

export function button(text: string, onClick: () => void, kind = ''): HTMLButtonElement {
  return html('button', { type: 'button', class: kind || undefined, click: onClick }, text);
}

/** A row of buttons with a name for screen readers. */
export function buttonRow(label: string, ...buttons: HTMLElement[]): HTMLElement {
  return roving(html('div', { class: 'button-row', role: 'toolbar', 'aria-label': label }, ...buttons));
}

const STOPS = 'button, a[href], input[type="checkbox"]';

/** One tab stop: Tab reaches the button last used, and arrow keys move between buttons. */
export function roving(row: HTMLElement): HTMLElement {
  const stops = (): HTMLElement[] =>
    Array.from(row.querySelectorAll<HTMLElement>(STOPS)).filter((one) => one.closest('[hidden]') === null);
  const choose = (chosen: HTMLElement | undefined): void => {
    for (const one of stops()) one.tabIndex = one === chosen ? 0 : -1;
  };
  row.addEventListener('focusin', (event) => {
    if (event.target instanceof HTMLElement) choose(event.target.closest<HTMLElement>(STOPS) ?? undefined);
  });
  row.addEventListener('keydown', (event) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (by === undefined || !(event.target instanceof HTMLElement)) return;
    event.preventDefault();
    const list = stops();
    list[(list.indexOf(event.target) + by + list.length) % list.length]?.focus();
  });
  choose(stops()[0]);
  return row;
}
