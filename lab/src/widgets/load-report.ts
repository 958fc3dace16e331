// The treatment of every part of a robot file, in words.
import { html } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';

const ALARMING = ['IGNORED PHYSICS', 'REPAIRED', 'AS WRITTEN'];

export function reportTable(robot: Robot, absent: readonly string[]): HTMLElement {
  const rows = robot.report().map((line) => line.split('\t')).filter(([, treatment]) => treatment !== 'read');
  const cells = rows.slice(0, 200).map(([line, treatment, place, message]) =>
    html('tr', { class: ALARMING.includes(treatment!) ? 'failed' : undefined },
      html('td', {}, line!), html('td', {}, treatment!.toLowerCase()), html('td', {}, place!), html('td', {}, message!)));
  const heads = ['Line', 'Treatment', 'Place', 'Message'].map((name) => html('th', { scope: 'col' }, name));
  const table = html('table', {}, html('thead', {}, html('tr', {}, ...heads)), html('tbody', {}, ...cells));
  const scroll = html('div', { class: 'table scroll', tabindex: 0, role: 'region', 'aria-label': 'Load report' }, table);
  return html('div', {},
    html('h3', {}, 'Load report'),
    ...inWords(robot, absent).map((sentence) => html('p', {}, sentence)),
    ...(rows.length > 0 ? [html('details', {}, html('summary', {}, `All ${String(rows.length)} entries, by line`), scroll)] : []));
}

/** The first few of a list. */
const some = (names: readonly string[]): string => names.slice(0, 4).join(', ') + (names.length > 4 ? ', …' : '');

/** The report in sentences. */
function inWords(robot: Robot, absent: readonly string[]): string[] {
  const { counts } = robot;
  const { links, joints, dofs, defaulted, repaired, suspicious, ignored, ignoredPhysics, equalities, tendons, actuators } = counts;
  const many = (count: number, one: string, more = `${one}s`): string => `${String(count)} ${count === 1 ? one : more}`;
  const sentences = [
    `“${robot.name}” has ${many(links, 'link')}, ${many(joints, 'joint')} and ${many(dofs, 'degree')} of freedom. `
    + (ignoredPhysics === 0
      ? 'All physics in the file was read.'
      : `${many(ignoredPhysics, 'entry', 'entries')} of physics are not supported and marked below.`),
  ];
  const said = [
    [defaulted, 'uses a default', 'use defaults'],
    [suspicious, 'looks wrong and was taken as written', 'look wrong and were taken as written'],
    [repaired, 'was repaired', 'were repaired'],
    [ignored, 'does not affect motion', 'do not affect motion'],
  ] as const;
  const parts = said.filter(([count]) => count > 0).map(([count, one, more]) => `${many(count, 'value')} ${count === 1 ? one : more}`);
  if (parts.length > 0) sentences.push(`${parts.join('; ')}.`);
  const beside = ([
    [equalities, 'closed loop or coupling', 'closed loops or couplings'],
    [tendons, 'tendon', 'tendons'], [actuators, 'actuator', 'actuators'],
  ] as const).filter(([count]) => count > 0).map(([count, one, more]) => many(count, one, more));
  if (beside.length > 0) {
    const listed = beside.length > 1 ? `${beside.slice(0, -1).join(', ')} and ${beside.at(-1)!}` : beside[0]!;
    sentences.push(`The file also has ${listed}.`);
  }
  if (robot.loose !== undefined) sentences.push(`The loops and couplings cannot be satisfied: ${robot.loose}.`);
  const locked = robot.locked();
  if (locked.length > 0) {
    const one = locked.length === 1;
    sentences.push(`${many(locked.length, 'joint')} ${one ? 'moves' : 'move'} no mass (${some(locked)}) and `
      + `${one ? 'is' : 'are'} locked.`);
  }
  if (absent.length > 0) {
    const names = [...new Set(absent.map((name) => name.replace(/^.*[\\/]/, '')))];
    sentences.push(`${many(names.length, 'mesh is', 'meshes are')} missing (${some(names)}), and rods are shown instead. `
      + 'Drop the whole folder, or a zip of it, to see them. STL, OBJ and DAE files are read.');
  }
  return sentences;
}
