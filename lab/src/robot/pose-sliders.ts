// One slider for each joint of a robot.
import { slider, type Slider } from '../controls/slider.ts';
import { html } from '../element.ts';
import type { Robot, RobotCoordinate } from '../../lib/dynamics/index.ts';

export interface PoseSliders {
  element: HTMLElement;
  show(robot: Robot): void;
  draw(q: ArrayLike<number>): void;
}

/** One slider for each coordinate with a number in q. */
export function poseSliders(onMove: (place: number, value: number) => void, onOpen: () => void): PoseSliders {
  let rows: { coordinate: RobotCoordinate; slider: Slider }[] = [];
  const list = html('div', { class: 'coordinates' });
  const element = html('details', { class: 'pose' }, html('summary', {}, 'Pose, joint by joint'), list);
  const set = (q: ArrayLike<number>): void => {
    for (const { coordinate, slider: one } of rows) one.set(q[coordinate.place!]!);
  };
  // They are not updated while closed.
  element.addEventListener('toggle', onOpen);
  return {
    element,
    show(robot) {
      rows = robot.coordinates().flatMap((coordinate) => {
        const { name, place, slides, lower, upper } = coordinate;
        if (place === undefined) return [];
        const most = slides ? 1 : Math.PI;
        const one = slider({
          label: name, unit: slides ? 'm' : 'rad', step: 0.01, value: 0,
          min: Number.isFinite(lower) ? lower : -most, max: Number.isFinite(upper) ? upper : most,
          onInput: (value) => { onMove(place, value); },
        });
        return [{ coordinate, slider: one }];
      });
      list.replaceChildren(...rows.map(({ slider: one }) => one.element));
      set(robot.q);
    },
    draw(q) {
      if (element.open) set(q);
    },
  };
}
