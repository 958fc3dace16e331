// What became of every part of a robot file, in plain words.
import { html } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';

export function reportTable(robot: Robot): HTMLElement {
  const [links, joints, freedoms, , defaulted, repaired, ignored, physics, suspicious] = Array.from(robot.counts, (count) => String(count));
  const rows = robot.report().map((line) => line.split('\t')).filter(([, treatment]) => treatment !== 'read');
  const summary = html('p', {},
    `“${robot.name}” has ${links!} links, ${joints!} joints and ${freedoms!} degrees of freedom. `,
    `${defaulted!} values were left to their defaults, ${suspicious!} are suspicious and taken as written, ${repaired!} repaired, ${ignored!} ignored, `,
    physics === '0' ? 'none of them physics: nothing that moves the robot was lost.' : `${physics!} of them physics: see below.`);
  const body = html('tbody', {}, ...rows.slice(0, 200).map(([line, treatment, place, message]) =>
    html('tr', { class: ['IGNORED PHYSICS', 'REPAIRED', 'AS WRITTEN'].includes(treatment!) ? 'failed' : undefined },
      html('td', {}, line!), html('td', {}, treatment!.toLowerCase()), html('td', {}, place!), html('td', {}, message!))));
  const table = html('table', {}, html('thead', {}, html('tr', {}, ...['Line', 'What became of it', 'Where', 'What'].map((name) => html('th', { scope: 'col' }, name)))), body);
  return html('div', {}, html('h3', {}, 'Load report'), summary,
    ...(rows.length > 0 ? [html('details', {}, html('summary', {}, `${String(rows.length)} entries`), html('div', { class: 'table scroll', tabindex: 0, role: 'region', 'aria-label': 'Load report' }, table))] : []));
}
