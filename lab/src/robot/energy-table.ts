// A robot's energy balance, as numbers for each cause.
import { readings } from '../drawing/readings.ts';
import { html, scientific, show } from '../element.ts';
import type { Robot } from '../../lib/dynamics/index.ts';

export interface RobotReadings {
  element: HTMLElement;
  draw(robot: Robot): void;
}

export function energyTable(): RobotReadings {
  const numbers = readings('Energy balance', [
    ['t', 't', 's'], ['mass', 'mass', 'kg'], ['dof', 'DoFs', ''], ['K', 'K', 'J'], ['V', 'V', 'J'], ['E', 'E', 'J'],
    ['work', 'work', 'J'], ['lost', 'lost to damping', 'J'], ['friction', 'to friction', 'J'],
    ['stops', 'to stops', 'J'], ['corrections', 'to corrections', 'J'], ['sliding', 'to sliding', 'J'], ['impacts', 'to impacts', 'J'],
    ['off', 'residual', 'J'],
  ]);
  const limited = html('p', { class: 'cost', hidden: true });
  return {
    element: html('div', {}, numbers.element, limited),
    draw(robot) {
      const cut = robot.stepsAtLimit;
      limited.hidden = cut === 0;
      if (cut > 0) limited.textContent = `In ${String(cut)} steps a torque was limited to its effort limit.`;
      const { kinetic, potential, energy, work, damping, friction, stops, corrections, sliding, impacts, unaccounted } =
        robot.energyAccount;
      numbers.draw({
        t: show(robot.time, 2), mass: show(robot.totalMass, 2), dof: String(robot.v.length), K: show(kinetic), V: show(potential),
        E: show(energy), work: show(work), lost: show(damping), friction: show(friction), stops: show(stops),
        corrections: show(corrections), sliding: show(sliding), impacts: show(impacts), off: scientific(unaccounted),
      });
    },
  };
}
