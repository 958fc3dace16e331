// The equation of motion for each joint: the terms, and the torques that balance them.
import { html, show } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';
import { TERMS } from './terms.ts';

export interface TorqueTable {
  element: HTMLElement;
  show(robot: Robot): void;
  draw(robot: Robot): void;
}

export function torqueTable(): TorqueTable {
  const body = html('tbody');
  let rows: { values: HTMLElement[]; over: HTMLElement; effort: number }[] = [];
  let seen = false;
  let shown: Robot | undefined;
  const heads = ['Joint', ...TERMS.map(([, name]) => name), 'Limit'].map((name) => html('th', { scope: 'col' }, name));
  const table = html('table', { class: 'torques' }, html('thead', {}, html('tr', {}, ...heads)), body);
  const label = 'The equation of motion, joint by joint';
  const draw = (robot: Robot): void => {
    shown = robot;
    if (!seen) return;
    const torques = robot.torques();
    const columns = TERMS.map(([term]) => torques[term]);
    rows.forEach(({ values, over, effort }, i) => {
      columns.forEach((column, k) => { write(values[k]!, column.length > 0 ? show(column[i]!, 2) : '–'); });
      write(over, Math.abs(torques.gravity[i]!) > effort ? `g exceeds ${show(effort, 0)}` : '');
    });
  };
  // It is not updated while invisible.
  new IntersectionObserver((entries) => {
    seen = entries.at(-1)?.isIntersecting ?? false;
    if (shown !== undefined) draw(shown);
  }, { rootMargin: '100px' }).observe(table);
  return {
    draw,
    element: html('div', {}, html('h3', {}, label),
      html('p', { class: 'cost' }, 'M q̈ + C q̇ + g(q) = forces of motors, actuators and hand + forces of damping, stops, contacts and '
        + 'loops, over the last step. At rest motors must provide g(q) to hold the pose.'),
      html('div', { class: 'table scroll', tabindex: 0, role: 'region', 'aria-label': label }, table)),
    show(robot) {
      rows = [];
      shown = undefined;
      body.replaceChildren(...robot.coordinates().map(({ name, slides, effort }) => {
        const values = TERMS.map(([term]) => html('td', { 'data-term': term }));
        const over = html('td');
        rows.push({ values, over, effort });
        return html('tr', {}, html('th', { scope: 'row' }, name, html('span', { class: 'unit' }, slides ? 'N' : 'N·m')), ...values, over);
      }));
    },
  };
}

function write(cell: HTMLElement, text: string): void {
  if (cell.textContent !== text) cell.textContent = text;
}
