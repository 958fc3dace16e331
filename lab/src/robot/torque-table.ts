// What the motors must give to hold the present pose.
import { html, show } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';

export interface TorqueTable {
  element: HTMLElement;
  show(robot: Robot): void;
  draw(robot: Robot): void;
}

export function torqueTable(): TorqueTable {
  const body = html('tbody');
  let rows: { value: HTMLElement; over: HTMLElement; unit: string; effort: number }[] = [];
  const heads = ['Joint', 'g(q)', 'Limit'].map((name) => html('th', { scope: 'col' }, name));
  const table = html('table', { class: 'torques' }, html('thead', {}, html('tr', {}, ...heads)), body);
  const label = 'Torque to hold this pose';
  return {
    element: html('div', {}, html('h3', {}, label),
      html('div', { class: 'table scroll', tabindex: 0, role: 'region', 'aria-label': label }, table)),
    show(robot) {
      rows = [];
      body.replaceChildren(...robot.coordinates().map(({ name, slides, effort }) => {
        const [value, over] = [html('td'), html('td')];
        rows.push({ value, over, unit: slides ? 'N' : 'N·m', effort });
        return html('tr', {}, html('th', { scope: 'row' }, name), value, over);
      }));
    },
    draw(robot) {
      const torques = robot.holdTorques();
      rows.forEach(({ value, over, unit, effort }, i) => {
        const text = `${show(torques[i]!, 2)} ${unit}`;
        if (value.textContent !== text) value.textContent = text;
        const excess = Math.abs(torques[i]!) > effort ? `over its limit of ${show(effort, 0)}` : '';
        if (over.textContent !== excess) over.textContent = excess;
      });
    },
  };
}
