// The terms of the equation of motion M q̈ + C q̇ + g = τ + others, for a robot's joints and their links.
import type { Robot } from '../../lib/dynamics/index.ts';

export type Term = 'inertial' | 'coriolis' | 'gravity' | 'applied' | 'rest';

/** The terms, each with its symbol or name. */
export const TERMS: readonly (readonly [Term, string])[] = [
  ['inertial', 'M q̈'], ['coriolis', 'C q̇'], ['gravity', 'g(q)'], ['applied', 'motors, hand'], ['rest', 'other forces'],
];

/** The brightness of each link, 0 to 1: its joint's load relative to the largest. */
export interface Glow {
  links: Float64Array;
  /** That joint and its load; undefined without a load. */
  most: Load | undefined;
}

export interface Load {
  joint: string;
  amount: number;
  unit: 'N' | 'N·m';
}

/** State of the scale between pictures, so that links regain their brightness gradually after an impact. */
const KEPT = 0.8;
/** Smallest load [N·m or N]. */
const NOTHING = 1e-6;

/**
 * A robot's current loads by any term. A joint with several coordinates has the norm of its vector. A
 * floating base has no motor and no brightness. A link fixed to another has the same brightness.
 */
export function loadsOf(robot: Robot): (term: Term) => Glow {
  const coordinates = robot.coordinates();
  const all = robot.joints();
  const joints = all.flatMap(({ child, coordinates: places }) => {
    const first = coordinates[places[0] ?? -1];
    if (first === undefined || first.floats) return [];
    const own = Array.from(places).filter((k) => coordinates[k]!.slides === first.slides);
    const name = places.length === 1 ? first.name : first.name.replace(/\.[^.]*$/, '');
    const unit: Load['unit'] = first.slides ? 'N' : 'N·m';
    return [{ child, own, name, unit }];
  });
  const drivers = driversOf(all, robot.bodies().length, joints.map(({ child }) => child));
  const scale = { 'N': 0, 'N·m': 0 };
  let last: Term | undefined;
  return (term) => {
    const values = robot.torques()[term];
    const amounts = joints.map(({ own }) => Math.hypot(...own.map((k) => values[k] ?? 0)));
    if (term !== last) scale['N'] = scale['N·m'] = 0;
    last = term;
    for (const unit of ['N', 'N·m'] as const) {
      scale[unit] = Math.max(KEPT * scale[unit], ...amounts.filter((_, k) => joints[k]!.unit === unit));
    }
    const shares = joints.map(({ unit }, k) => (scale[unit] > NOTHING ? amounts[k]! / scale[unit] : 0));
    const brightest = shares.reduce((best, share, k) => (share > (shares[best] ?? 0) ? k : best), -1);
    return {
      links: Float64Array.from(drivers, (driver) => shares[driver ?? -1] ?? 0),
      most: amounts[brightest]! > NOTHING ? { joint: joints[brightest]!.name, amount: amounts[brightest]!, unit: joints[brightest]!.unit }
        : undefined,
    };
  };
}

/** For each link the nearest link on its way to the root that is a joint's child. */
function driversOf(joints: ReturnType<Robot['joints']>, links: number, children: readonly number[]): (number | undefined)[] {
  const above = new Map(joints.map(({ parent, child, coordinates }) => [child, coordinates.length > 0 ? undefined : parent]));
  return Array.from({ length: links }, (_, link) => {
    for (let at: number | undefined = link; at !== undefined; at = above.get(at)) {
      const found = children.indexOf(at);
      if (found >= 0) return found;
    }
    return undefined;
  });
}
