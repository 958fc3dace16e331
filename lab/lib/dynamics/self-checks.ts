// The numbers of the chapter, computed by the module that the page uses.
import { engine } from './engine.ts';
import { PlanarArm, PolarMass, Reach2R, RpArm } from './models.ts';
import { energyDrift, type System } from './system.ts';

export interface SelfCheck {
  name: string;
  /** The chapter's number as text. */
  expected: string;
  /** The computed number as text. */
  found: string;
  passed: boolean;
}

const HALF_TURN = Math.PI;
const POSE = [HALF_TURN / 4, HALF_TURN / 2];
const REST = [0, 0];

/** A number that must equal the chapter's within `tolerance`. */
function near(name: string, found: number, expected: number, tolerance: number, unit = ''): SelfCheck {
  return {
    name,
    expected: `${String(expected)}${unit}`,
    found: `${digits(found)}${unit}`,
    passed: Math.abs(found - expected) <= tolerance,
  };
}

/** A number that must be below a bound. */
function below(name: string, found: number, bound: number): SelfCheck {
  return { name, expected: `< ${digits(bound)}`, found: digits(found), passed: found < bound };
}

function above(name: string, found: number, bound: number): SelfCheck {
  return { name, expected: `> ${digits(bound)}`, found: digits(found), passed: found > bound };
}

function digits(x: number): string {
  if (x === 0) return '0';
  return Math.abs(x) < 1e-2 || Math.abs(x) >= 1e5 ? x.toExponential(1) : String(Number(x.toPrecision(6)));
}

export function selfChecks(): SelfCheck[] {
  return [...workedExample(), ...symbols(), ...energy(), ...constraints(), ...bricks(), ...positive()];
}

function workedExample(): SelfCheck[] {
  const arm = Reach2R.workedExample();
  const [[m11, m12], [, m22]] = arm.mass(POSE) as [[number, number], [number, number]];
  const [g1, g2] = arm.gravity(POSE) as [number, number];
  const [c1, c2] = arm.velocityProduct(POSE, [1, 0]) as [number, number];
  const [long, short] = arm.inertiaEllipse(POSE).semiAxes as [number, number];
  const sweep = [0, HALF_TURN / 2, HALF_TURN].map((q2) => arm.mass([POSE[0]!, q2])[0]![0]!);
  return [
    near('M₁₁ at q = (π/4, π/2)', m11, 2, 1e-4, ' kg·m²'),
    near('M₁₂', m12, 0.3333, 1e-4, ' kg·m²'),
    near('M₂₂', m22, 0.3333, 1e-4, ' kg·m²'),
    near('det M', m11 * m22 - m12 * m12, 0.5556, 1e-4),
    near('larger eigenvalue of M', 1 / (short * short), 2.0642, 1e-4),
    near('smaller eigenvalue of M', 1 / (long * long), 0.2691, 1e-4),
    near('g₁', g1, 10.4051, 1e-4, ' N·m'),
    near('g₂', g2, -3.4684, 1e-4, ' N·m'),
    near('first row of C q̇ at q̇ = (1, 0)', c1, 0, 1e-4, ' N·m'),
    near('second row of C q̇', c2, 0.5, 1e-4, ' N·m'),
    near('K at q̇ = (1, 0)', arm.kineticEnergy(POSE, [1, 0]), 1, 1e-4, ' J'),
    near('V', arm.potentialEnergy(POSE), 17.3418, 1e-4, ' J'),
    near('E', arm.energy(POSE, [1, 0]), 18.3418, 1e-4, ' J'),
    near('longer semi-axis of the inertia ellipse', long, 1.928, 5e-4, ' rad/s'),
    near('shorter semi-axis', short, 0.696, 5e-4, ' rad/s'),
    near('M₁₁ stretched, q₂ = 0', sweep[0]!, 3, 1e-12, ' kg·m²'),
    near('M₁₁ bent, q₂ = π/2', sweep[1]!, 2, 1e-12, ' kg·m²'),
    near('M₁₁ folded, q₂ = π', sweep[2]!, 1, 1e-12, ' kg·m²'),
  ];
}

function symbols(): SelfCheck[] {
  const arm = Reach2R.workedExample();
  const three = PlanarArm.reach3R();
  const rp = RpArm.of(0.4, 2, 0.1, 1.5, 0.05, 9.81).christoffel([0.3, 0.8]);
  const polar = PolarMass.of(2).christoffel([1.5, 0.7]);
  const q = [0.3, 0.9];
  const by = [arm.christoffel(q), arm.christoffelByDifferences(q, 1e-6)].map((cube) => cube.flat(2));
  const apart = Math.max(...by[0]!.map((symbol, i) => Math.abs(symbol - by[1]![i]!)));
  return [
    near('Γ²₁₂ of a polar mass of 2 kg at 1.5 m', polar[1]![0]![1]!, 3, 1e-12),
    near('Γ¹₂₂ of the same', polar[0]![1]![1]!, -3, 1e-12),
    near('Γ¹₁₂ of the RP arm, m₂ q₂', rp[0]![0]![1]!, 1.2, 1e-12),
    near('Γ²₁₁ of the RP arm, −m₂ q₂', rp[1]![0]![0]!, -1.2, 1e-12),
    below('Γ of the 2R arm, exact against differences of 1e-6', apart, 1e-7),
    below('skew defect of Ṁ − 2C, 3R arm', three.skewSymmetryDefect([0.3, 1.2, -0.7], [1, 2, -1]), 1e-12),
  ];
}

function energy(): SelfCheck[] {
  const arm = Reach2R.workedExample();
  const start = { q: POSE, qd: REST };
  const drift = (name: 'rk4' | 'semi-implicit-euler' | 'explicit-euler' | 'variational-midpoint'): number =>
    energyDrift(arm, start, 1e-3, 10_000, name);
  const lie = new engine.FallingArm(1, 2, 1, 1, 9.81);
  lie.place(Float64Array.from(POSE), Float64Array.from(REST));
  lie.setCoriolis(false);
  lie.advance(10_000);
  const off = lie.drift;
  lie.free();
  return [
    near('energy drift of rk4, 10 s in steps of 1 ms', drift('rk4'), 1.2e-8, 5e-10),
    near('semi-implicit Euler', drift('semi-implicit-euler'), 1.1e-1, 5e-3),
    near('explicit Euler', drift('explicit-euler'), 1.4e-1, 5e-3),
    below('variational midpoint', drift('variational-midpoint'), 1e-3),
    above('energy off its line with C q̇ left out', off, 0.2),
  ];
}

function constraints(): SelfCheck[] {
  const blade = new engine.Blade(2, 0.5, 0.25);
  blade.place(Float64Array.of(0, 0, 0), 3, 1.5);
  const lambda = blade.lambda;
  blade.setForces(3, 1, 2);
  blade.advance(20_000);
  const slip = Math.abs(blade.sideSlip);
  blade.free();
  return [
    below('knife-edge: solver against λ, q̈ and P in closed form, 30 states', engine.knifeEdgeDefect(1, 30), 1e-9),
    near('side force at v = 3 m/s, θ̇ = 1.5 rad/s, 2 kg: −m v θ̇', lambda, -9, 1e-12, ' N'),
    below('|A q̇| after 20 s of driving', slip, 1e-12),
  ];
}

function bricks(): SelfCheck[] {
  const spun = (axis: number): engine.Brick => {
    const brick = new engine.Brick(0.3, 0.2, 0.1, 1000);
    brick.spin(Float64Array.from([0.01, 0.01, 0.01], (x, i) => (i === axis ? 5 : x)));
    brick.advance(20_000);
    return brick;
  };
  const [long, middle, short] = [spun(0), spun(1), spun(2)] as [engine.Brick, engine.Brick, engine.Brick];
  const exact = middle.exactOmega;
  const apart = Math.max(...middle.omega.map((w, i) => Math.abs(w - exact[i]!)));
  const checks = [
    near('flips about the axis of least moment in 20 s', long.flips, 0, 0),
    above('flips about the middle axis', middle.flips, 1),
    near('flips about the axis of greatest moment', short.flips, 0, 0),
    below('|L − L₀|/|L₀| after 20 000 steps', middle.drift.momentum, 1e-12),
    below('|K − K₀|/K₀', middle.drift.energy, 1e-12),
    // Order 2 in steps of 1 ms over 20 s gives about 1e-7; ten times the step gives a hundred times that.
    below('ω against Jacobi’s elliptic functions, rad/s', apart, 1e-5),
  ];
  [long, middle, short].forEach((brick) => { brick.free(); });
  return checks;
}

/** M ≻ 0 at 200 seeded configurations of each arm. */
function positive(): SelfCheck[] {
  const arms: [string, System][] = [
    ['2R arm', Reach2R.workedExample()],
    ['3R arm', PlanarArm.reach3R()],
    ['RP arm', RpArm.of(0.4, 2, 0.1, 1.5, 0.05, 9.81)],
  ];
  return arms.map(([name, arm]) => {
    const random = seeded(7);
    let count = 0;
    for (let i = 0; i < 200; i += 1) {
      const q = Array.from({ length: arm.dimension }, () => (2 * random() - 1) * HALF_TURN);
      count += arm.massIsPositiveDefinite(q) ? 1 : 0;
    }
    return near(`M ≻ 0 at 200 seeded configurations, ${name}`, count, 200, 0);
  });
}

/** Park and Miller's generator, for configurations that are the same everywhere. */
function seeded(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state * 48271) % 2147483647;
    return state / 2147483647;
  };
}
