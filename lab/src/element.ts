// Elements as expressions: tag, attributes, children.

type Value = string | number | boolean | undefined | ((event: never) => void);
export type Child = Node | string;

function dress(element: Element, attributes: Record<string, Value>, children: readonly Child[]): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    if (typeof value === 'function') element.addEventListener(name, value as EventListener);
    else element.setAttribute(name, value === true ? '' : String(value));
  }
  element.append(...children);
}

/** An HTML element. Functions among the attributes become listeners. */
export function html<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, Value> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  dress(element, attributes, children);
  return element;
}

/** An SVG element. */
export function svg<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Record<string, Value> = {},
  ...children: Child[]
): SVGElementTagNameMap[K] {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  dress(element, attributes, children);
  return element;
}

/** Changes attributes of an existing element. */
export function set(element: Element, attributes: Record<string, string | number>): void {
  for (const [name, value] of Object.entries(attributes)) {
    const text = typeof value === 'number' ? short(value) : value;
    if (element.getAttribute(name) !== text) element.setAttribute(name, text);
  }
}

/** A number with enough digits for a picture. */
export function short(x: number): string {
  return String(Math.round(x * 1e4) / 1e4);
}

/** A number for display: fixed digits, a true minus sign, no negative zero. */
export function show(x: number, digits = 3): string {
  if (!Number.isFinite(x)) return '–';
  const text = x.toFixed(digits);
  return (Number(text) === 0 ? text.replace('-', '') : text).replace('-', '−');
}

/** Keeps a product on one line: M q̈, C q̇, A q̇. */
export function tied(text: string): string {
  return text.replace(/([MCA]) (?=q)/g, '$1\u00a0');
}

/** 10 raised to a whole number. */
export function powerOfTen(exponent: number): string {
  const digits = '⁰¹²³⁴⁵⁶⁷⁸⁹';
  return `10${Array.from(String(exponent), (c) => (c === '-' ? '⁻' : digits[Number(c)]!)).join('')}`;
}

/** Two digits, with a power of ten if far from one: for errors. */
export function scientific(x: number): string {
  if (x === 0) return '0';
  if (!Number.isFinite(x)) return '–';
  if (Math.abs(x) >= 0.01 && Math.abs(x) < 1000) return String(Number(x.toPrecision(2))).replace('-', '−');
  const [mantissa, exponent] = x.toExponential(1).split('e') as [string, string];
  return `${mantissa.replace('-', '−')}·${powerOfTen(Number(exponent))}`;
}
