// The state of a race, for drawing.
import type { Race } from '../../wasm/chapter.js';

/** The state of a race; lists have an entry for each runner. */
export interface Standing {
  time: number;
  times: Float64Array;
  runners: { points: Float64Array; errors: Float64Array; drift: number; fault: string }[];
}

export function standing(of: Race, runners: number): Standing {
  return {
    time: of.time, times: of.times,
    runners: Array.from({ length: runners }, (_, i) =>
      ({ points: of.points(i), errors: of.errors(i), drift: of.drift(i), fault: of.fault(i) })),
  };
}
