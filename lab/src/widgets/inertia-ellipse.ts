// The inertia ellipse: the joint velocities of a given energy. The user predicts before the ellipse shows.
import { numberFrom } from '../address.ts';
import { button, buttonRow } from '../controls/choice.ts';
import { handle } from '../controls/handle.ts';
import { slider } from '../controls/slider.ts';
import { hiddenAnswer } from '../controls/hidden-answer.ts';
import { armDrawing, planarPicture } from '../drawing/planar-arm.ts';
import { readings } from '../drawing/readings.ts';
import { html, set, show, svg } from '../element.ts';
import { FallingArm, Reach2R, tuple, type Tuple } from '../../lib/dynamics/index.ts';
import { wrap } from './angle.ts';
import { frame, type Widget } from './frame.ts';
import { question } from './question.ts';

const START: Tuple<2> = [Math.PI / 4, Math.PI / 2];
/** Half-width of the window of velocities [rad/s]: the longest semi-axis, at q₂ = 0, is 3.25. */
const REACH = 3.7;
const TICKS = [-3, -2, -1, 1, 2, 3];

export function inertiaEllipse(): Widget {
  const arm = Reach2R.workedExample();
  const shape = new FallingArm(1, 2, 1, 1, 9.81);
  let [q1, q2] = START;

  const picture = planarPicture('A two-link arm; drag the elbow or the tip', 2.25);
  const drawing = armDrawing();
  const grip = { min: -3.142, max: 3.142, nudge: Math.PI / 36, radius: 0.075, doubled: true, unit: 'rad' };
  const elbow = handle({
    ...grip, label: 'q1, the first joint',
    onDrag: (x, y) => { put(Math.atan2(-y, x), q2); },
    onNudge: (by) => { put(q1 + by, q2); },
  });
  const tip = handle({
    ...grip, label: 'q2, the second joint',
    onDrag: (x, y) => {
      const [ex, ey] = tuple(shape.points, 4);
      put(q1, Math.atan2(-y - ey, x - ex) - q1);
    },
    onNudge: (by) => { put(q1, q2 + by); },
  });
  picture.plane.append(drawing.element, elbow.element, tip.element);

  const ellipse = svg('ellipse', { class: 'ellipse' });
  const axes = [svg('line', { class: 'axis long' }), svg('line', { class: 'axis short' })];
  const tick = (x: number): string => `M${String(x)} -0.08V0.08M-0.08 ${String(x)}H0.08`;
  const velocities = svg(
    'svg',
    {
      class: 'velocities', viewBox: `${String(-REACH)} ${String(-REACH)} ${String(2 * REACH)} ${String(2 * REACH)}`,
      role: 'img', 'aria-label': 'The inertia ellipse in the plane of joint velocities',
    },
    svg('path', { class: 'axes', d: 'M-3.5 0H3.5M0 -3.5V3.5' }),
    svg('path', { class: 'ticks', d: TICKS.map(tick).join('') }),
    ...TICKS.map((x) => svg('text', { x, y: 0.42, 'text-anchor': 'middle' }, String(x).replace('-', '−'))),
    svg('text', { x: 3.5, y: -0.2, 'text-anchor': 'end' }, 'q̇₁, rad/s'),
    svg('text', { x: 0.17, y: -3.3 }, 'q̇₂, rad/s'),
    ellipse,
    ...axes,
  );
  const numbers = readings('Mass matrix and ellipse', [
    ['m11', 'M₁₁', 'kg·m²'], ['m12', 'M₁₂', 'kg·m²'], ['m22', 'M₂₂', 'kg·m²'], ['q1', 'q₁', 'rad'], ['q2', 'q₂', 'rad'],
    ['long', 'longer semi-axis', 'rad/s'], ['short', 'shorter', 'rad/s'], ['ratio', 'condition of M', ''],
  ]);

  const put = (first: number, second: number): void => {
    [q1, q2] = [wrap(first), wrap(second)];
    sliders[0]!.set(q1);
    sliders[1]!.set(q2);
    draw();
  };
  const angle = (label: string, value: number, onInput: (value: number) => void): ReturnType<typeof slider> =>
    slider({ label, unit: 'rad', min: -3.142, max: 3.142, step: 0.01, value, onInput });
  const sliders = [
    angle('q₁', q1, (value) => { put(value, q2); }),
    angle('q₂', q2, (value) => { put(q1, value); }),
  ];
  const poses = ([['q₂ = 0', 0], ['q₂ = π/2', Math.PI / 2], ['q₂ = π', Math.PI]] as const)
    .map(([name, value]) => button(name, () => { put(q1, value); }));

  const draw = (): void => {
    shape.place(Float64Array.of(q1, q2), Float64Array.of(0, 0));
    const [ex, ey, tx, ty] = tuple(shape.points, 4);
    drawing.draw([[0, 0], [ex, ey], [tx, ty]]);
    elbow.place(ex, -ey, q1);
    tip.place(tx, -ty, q2);
    const [m11, m12, , m22] = tuple(arm.mass([q1, q2]).flat(), 4);
    const { semiAxes, directions } = arm.inertiaEllipse([q1, q2]);
    const [long, short] = tuple(semiAxes, 2);
    const [dx, dy] = tuple(directions[0]!, 2);
    const degrees = (-Math.atan2(dy, dx) * 180) / Math.PI;
    set(ellipse, { rx: long, ry: short, transform: `rotate(${degrees.toFixed(3)})` });
    axes.forEach((axis, i) => {
      const [x, y] = tuple(directions[i]!, 2);
      set(axis, { x1: 0, y1: 0, x2: x * semiAxes[i]!, y2: -y * semiAxes[i]! });
    });
    numbers.draw({
      m11: show(m11, 3), m12: show(m12, 3), m22: show(m22, 3), q1: show(q1), q2: show(q2),
      long: show(long), short: show(short), ratio: show((long / short) ** 2, 1),
    });
  };

  const answer = hiddenAnswer('The explanation appears with your answer.', html('p', {},
    'Nothing at all. M depends on the shape of the arm, and q₁ turns the arm without changing its shape. Only q₂ matters.'));
  const hint = 'First say what you expect: the ellipse appears with your answer.';
  const pictureVeil = hiddenAnswer(hint, velocities);
  const numbersVeil = hiddenAnswer('The numbers appear with your answer.', numbers.element);
  const equationVeil = (): void => { element.querySelector('.equations')?.removeAttribute('hidden'); };
  const reveal = (): void => {
    for (const one of [answer, pictureVeil, numbersVeil]) one.lift();
    equationVeil();
  };
  const asked = question(
    'Before you look: what happens to the ellipse when only q₁ moves?',
    ['It turns with the arm', 'It grows and shrinks', 'Nothing'], 2, reveal,
  );

  const element = frame({
    id: 'inertia-ellipse',
    picture: [html('div', { class: 'pair' }, picture.element, pictureVeil.element)],
    controls: [
      asked, answer.element,
      html('div', { class: 'settings' }, ...sliders.map((one) => one.element), buttonRow('Poses of the second joint', ...poses)),
      numbersVeil.element,
    ],
    equations: [
      { name: 'ellipse', code: 'InertiaEllipse::new', says: 'λᵢ: the eigenvalues of M' },
      { name: 'mass11', code: 'Reach2R::mass', says: '3, 2, 1 kg·m² as q₂ = 0, π/2, π' },
    ],
    share: () => ({ q1, q2 }),
  });
  // M₁₁ without q₁ would also give the answer.
  element.querySelector('.equations')?.setAttribute('hidden', '');
  draw();
  return {
    id: 'inertia-ellipse', element,
    restore: (values) => { put(numberFrom(values, 'q1', START[0]), numberFrom(values, 'q2', START[1])); },
  };
}
