// The closed-form models M(q) q̈ + C q̇ + g + b = u.
import { engine, floats, rows, type Vector } from './engine.ts';

export type IntegratorName =
  'explicit-euler' | 'semi-implicit-euler' | 'rk4' | 'variational-midpoint' | 'variational-yoshida4';

export interface State {
  q: number[];
  qd: number[];
}

export interface InertiaEllipse {
  /** Longest first. */
  semiAxes: number[];
  /** Unit vectors, one per semi-axis. */
  directions: number[][];
}

/** A model of the library. Every call takes the state. */
export class System {
  protected constructor(
    protected readonly model: engine.ClosedForm,
    readonly dimension: number,
  ) {}

  mass(q: Vector): number[][] {
    return rows(this.model.mass(floats(q)), this.dimension);
  }

  velocityProduct(q: Vector, qd: Vector): number[] {
    return Array.from(this.model.velocityProduct(floats(q), floats(qd)));
  }

  gravity(q: Vector): number[] {
    return Array.from(this.model.gravity(floats(q)));
  }

  potentialEnergy(q: Vector): number {
    return this.model.potentialEnergy(floats(q));
  }

  kineticEnergy(q: Vector, qd: Vector): number {
    return this.model.kineticEnergy(floats(q), floats(qd));
  }

  energy(q: Vector, qd: Vector): number {
    return this.kineticEnergy(q, qd) + this.potentialEnergy(q);
  }

  forward(q: Vector, qd: Vector, u: Vector): number[] {
    return Array.from(this.model.forward(floats(q), floats(qd), floats(u)));
  }

  inverse(q: Vector, qd: Vector, qdd: Vector): number[] {
    return Array.from(this.model.inverse(floats(q), floats(qd), floats(qdd)));
  }

  /** symbols[i][j][k] = Γⁱⱼₖ, counted from zero. */
  christoffel(q: Vector): number[][][] {
    return this.cube(this.model.christoffel(floats(q)));
  }

  christoffelByDifferences(q: Vector, step: number): number[][][] {
    return this.cube(this.model.christoffelByDifferences(floats(q), step));
  }

  /** max |(Ṁ−2C) + (Ṁ−2C)ᵀ|. */
  skewSymmetryDefect(q: Vector, qd: Vector): number {
    return this.model.skewSymmetryDefect(floats(q), floats(qd));
  }

  massIsPositiveDefinite(q: Vector): boolean {
    return this.model.massIsPositiveDefinite(floats(q));
  }

  inertiaEllipse(q: Vector): InertiaEllipse {
    const flat = this.model.inertiaEllipse(floats(q));
    const n = this.dimension;
    return { semiAxes: Array.from(flat.subarray(0, n)), directions: rows(flat.subarray(n), n) };
  }

  step(integrator: IntegratorName, state: State, u: Vector, h: number): State {
    const next = this.model.step(integrator, floats(state.q), floats(state.qd), floats(u), h);
    const n = this.dimension;
    return { q: Array.from(next.subarray(0, n)), qd: Array.from(next.subarray(n)) };
  }

  energyDrift(integrator: IntegratorName, state: State, h: number, steps: number): number {
    return this.model.energyDrift(integrator, floats(state.q), floats(state.qd), h, steps);
  }

  private cube(flat: Float64Array): number[][][] {
    const n = this.dimension;
    return rows(flat, n * n).map((face) => rows(Float64Array.from(face), n));
  }
}

/** One classical Runge–Kutta step with constant u. */
export function rk4Step(system: System, state: State, u: Vector, h: number): State {
  return system.step('rk4', state, u, h);
}

/** max |E − E₀|/|E₀| over a run without torque. */
export function energyDrift(
  system: System,
  state: State,
  h: number,
  steps: number,
  integrator: IntegratorName = 'rk4',
): number {
  return system.energyDrift(integrator, state, h, steps);
}
