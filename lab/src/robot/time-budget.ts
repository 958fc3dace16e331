// Limits the time of a robot's physics in a frame. A robot slower than real time moves in slow motion, and
// the page stays responsive.
import type { Robot } from '../../lib/dynamics/index.ts';

/** Time limit for the steps of one frame [ms]. */
const LONGEST = 12;
/** Steps between two clock readings. */
const FEW = 4;

/** Takes these steps, or as many as the time allows. */
export function advanceWithinBudget(robot: Robot, steps: number): void {
  const until = performance.now() + LONGEST;
  for (let left = steps; left > 0 && performance.now() < until; left -= FEW) robot.advance(Math.min(FEW, left));
}
