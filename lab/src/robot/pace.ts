// How much of a frame the physics of a robot may take: one that is slower than real time moves in slow motion, and the page stays awake.
import type { Robot } from '../../lib/dynamics/index.ts';

/** The longest that the steps of one frame may take [ms]. */
const LONGEST = 12;
/** Steps between two looks at the clock. */
const FEW = 4;

/** Takes these steps, or as many as there is time for. */
export function goOn(robot: Robot, steps: number): void {
  const until = performance.now() + LONGEST;
  for (let left = steps; left > 0 && performance.now() < until; left -= FEW) robot.advance(Math.min(FEW, left));
}
