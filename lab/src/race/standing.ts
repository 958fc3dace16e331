// How a race stands, as it is drawn.
import type { Race } from '../../wasm/chapter.js';

/** How things stand; a list has an entry for each runner. */
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
