// Formulas on the page: each rendered to MathML at build time, with the name of the Rust function that
// computes it.
import { html } from '../element.ts';
import mathml from '../equations.tex';

export interface Equation {
  /** Its name in equations.tex. */
  name: string;
  /** The Rust function that computes it. */
  code: string;
  says: string;
}

/** A formula by its name. On a narrow screen a long one scrolls, and is then reachable by keyboard. */
export function formula(name: string): HTMLElement {
  const math = html('span', { class: 'math' });
  const source = mathml[name];
  if (source === undefined) throw new Error(`no equation is named ${name}`);
  math.innerHTML = source;
  new ResizeObserver(() => {
    if (math.scrollWidth > math.clientWidth) math.tabIndex = 0;
    else math.removeAttribute('tabindex');
  }).observe(math);
  return math;
}

export function equationList(equations: readonly Equation[]): HTMLElement {
  const rows = equations.map(({ name, code, says }) =>
    html('li', {}, formula(name), html('span', { class: 'says' }, says), html('code', {}, code)));
  return html('ul', { class: 'equations', 'aria-label': 'Equations, and the Rust function that computes each' }, ...rows);
}
