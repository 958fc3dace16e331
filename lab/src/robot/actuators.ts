// The actuators of a robot's file: a slider for each control, and the controls of the file's poses in turn.
import { numberFrom, numbered, numbersFrom, type Shared } from '../address.ts';
import { button, buttonRow, toggle } from '../controls/choice.ts';
import { slider, type Slider } from '../controls/slider.ts';
import { html } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';

export interface Actuators {
  element: HTMLElement;
  /** For a newly loaded robot: its poses in turn, if several have controls. */
  suit(robot: Robot): void;
  /** The current controls. */
  draw(robot: Robot): void;
  shared(robot: Robot | undefined): Shared;
  restoreOn(robot: Robot, values: URLSearchParams): void;
}

export function actuators(robot: () => Robot | undefined): Actuators {
  let sliders: Slider[] = [];
  let poses: { name: string; controls: Float64Array }[] = [];
  const list = html('div', { class: 'controls-list' });
  const row = html('div');
  const apply = (of: Robot): void => {
    if (turning.on) of.posesInTurn();
    else of.setControls(Float64Array.from(sliders, ({ value }) => value));
    draw(of);
  };
  const changed = (): void => {
    const now = robot();
    if (now !== undefined) apply(now);
  };
  const turning = toggle('Poses of the file in turn', false, changed);
  const element = html('details', { class: 'actuators', hidden: true }, html('summary', {}, 'Controls of the actuators'),
    html('div', { class: 'folded' }, turning.element, row, list));
  const draw = (of: Robot): void => {
    if (!element.open || element.hidden) return;
    const now = of.controls();
    sliders.forEach((one, i) => { one.set(now[i]!); });
  };
  element.addEventListener('toggle', () => {
    const now = robot();
    if (now !== undefined) draw(now);
  });
  /** Sets constant controls. */
  const hold = (controls: ArrayLike<number>): void => {
    turning.set(false);
    sliders.forEach((one, i) => { one.set(controls[i]!); });
    changed();
  };
  return {
    element,
    draw,
    suit(of) {
      const all = of.actuators();
      const named = of.namedPoses();
      poses = named.filter(({ controls }) => controls.length > 0).map(({ name, controls }) => ({ name, controls }));
      sliders = all.map(({ name, lower, upper }) => slider({
        label: name, min: Number.isFinite(lower) ? lower : -1, max: Number.isFinite(upper) ? upper : 1, step: 0.001, value: 0,
        onInput: () => {
          turning.set(false);
          changed();
        },
      }));
      list.replaceChildren(...sliders.map((one) => one.element));
      row.replaceChildren(...(poses.length === 0
        ? []
        : [buttonRow('Controls of the file’s poses', ...poses.map(({ name, controls }) => button(name, () => { hold(controls); })))]));
      element.hidden = all.length === 0;
      turning.element.hidden = poses.length < 2;
      turning.set(poses.length > 1);
      const first = poses[0]?.controls ?? new Float64Array(all.length);
      sliders.forEach((one, i) => { one.set(first[i]!); });
      apply(of);
    },
    shared(of) {
      if (of === undefined || sliders.length === 0) return {};
      return turning.on ? { turn: 1 } : { turn: 0, ...numbered('u', of.controls()) };
    },
    restoreOn(of, values) {
      if (!values.has('turn')) return;
      turning.set(numberFrom(values, 'turn', 1) !== 0 && poses.length > 1);
      const given = numbersFrom(values, 'u', sliders.map(({ value }) => value));
      sliders.forEach((one, i) => { one.set(given[i]!); });
      apply(of);
    },
  };
}
