//! Newton's method for x, with p̄ and s fixed.
//!
//! Each step solves H δ = −(M x + f − Aᵀp). Factoring H costs most of a step. An earlier factor is used again
//! while every block acts as it did there and the steps converge fast enough.

use robot_dynamics_number::dispatch::{Call, Hardware, run_here};

use super::ConeProblem;
use super::entries::{dot, map, sum};
use super::hessian::Add;
use super::projection::MultiplierZone;
use super::tolerances::TOLERANCES;

/// The progress of one run of Newton's method.
#[derive(Clone, Copy, Debug)]
struct Progress {
    /// Whether the first step assumes that each contact continues to stick or slide as p̄ does.
    first: bool,
    /// Whether the run may end before the last digit, as p̄ and s are about to change.
    is_inexact: bool,
    /// The decrease of the last step.
    last_decrease: f64,
    /// The relative decrease that ends the run.
    tolerance: f64,
}

/// A Newton step δ, and the estimates that tell whether it is the last one.
#[derive(Clone, Copy, Debug)]
struct NewtonStep {
    /// gᵀH⁻¹g, twice the decrease of the quadratic model.
    decrease: f64,
    /// The energy that `decrease` is compared with.
    energy: f64,
    /// 1 for a step with H of this x, `old_factor_decrease` with an older factor.
    factor_share: f64,
    /// The estimated ratio of the next decrease to this one.
    next_ratio: f64,
}

impl Progress {
    fn new(first: bool, is_inexact: bool) -> Self {
        Self { first, is_inexact, last_decrease: f64::INFINITY, tolerance: TOLERANCES.decrease }
    }

    /// Whether a step of this decrease with an older factor needs no new factor.
    fn accepts_old_factor(&self, decrease: f64, energy: f64) -> bool {
        decrease <= TOLERANCES.old_factor_decrease * self.tolerance * energy
            || (self.is_inexact && decrease <= TOLERANCES.reuse_ratio * self.last_decrease)
    }

    /// Sets the tolerance of an inexact run by the decrease of its first step.
    fn set_tolerance(&mut self, step: &NewtonStep) {
        self.tolerance = if self.first {
            TOLERANCES.inexact_decrease
        } else {
            (TOLERANCES.inexact_decrease_ratio * step.decrease / step.energy)
                .clamp(TOLERANCES.decrease, TOLERANCES.inexact_decrease)
        };
    }
}

impl NewtonStep {
    /// Whether the decrease is below this fraction of the energy.
    fn gains_less_than(&self, fraction: f64) -> bool {
        self.decrease <= self.factor_share * fraction * self.energy + f64::MIN_POSITIVE
    }

    /// Whether the next step is expected to gain less than this fraction of the energy.
    fn next_gains_less_than(&self, fraction: f64) -> bool {
        self.next_ratio * self.decrease <= fraction * self.energy
    }
}

impl ConeProblem {
    /// Minimizes over x by Newton's method, with p̄ and s fixed. Returns whether x is exact to the last
    /// significant digit; an inexact run may end before that.
    ///
    /// Returns `None` if a number is not finite or the solution was interrupted.
    pub(super) fn minimize(&mut self, first: bool, is_inexact: bool) -> Option<bool> {
        let mut progress = Progress::new(first, is_inexact);
        let mut is_exact = false;
        self.follow_x();
        let mut acts_as_before = self.respond(0.0, first);
        for round in 0..TOLERANCES.newton_steps {
            if self.interrupt.is_set() {
                return None;
            }
            self.rounds += 1;
            let mut step = self.newton_step(&progress, acts_as_before);
            if !step.decrease.is_finite() {
                return None;
            }
            progress.last_decrease = step.decrease;
            self.known.is_fresh &= step.decrease <= TOLERANCES.fresh_factor_decrease * step.energy;
            if is_inexact && round == 0 {
                progress.set_tolerance(&step);
            }
            let curvature = self.follow();
            step.energy += curvature;
            // The first step from assumed blocks does not start at their true response.
            let is_begun = !(first && round == 0);
            if is_begun && let Some(is_exact) = self.take_last_step(&progress, &step) {
                return Some(is_exact);
            }
            acts_as_before = self.descend(curvature, step.decrease, is_begun);
            // If every block acts as in the factor and none slides, the objective is quadratic and x its
            // minimum.
            is_exact = acts_as_before
                && self.derivatives.iter().all(|derivatives| derivatives.place != MultiplierZone::Border);
            if is_inexact && is_exact {
                break;
            }
        }
        Some(is_exact)
    }

    /// Finds the step δ at x: with the last factor if that suffices, and otherwise with a new one.
    fn newton_step(&mut self, progress: &Progress, acts_as_before: bool) -> NewtonStep {
        let energy = self.find_slope();
        let decrease = if acts_as_before { self.find_step() } else { f64::INFINITY };
        if acts_as_before && progress.accepts_old_factor(decrease, energy) {
            let mut next_ratio = if self.known.is_fresh { TOLERANCES.fresh_factor_ratio } else { 1.0 };
            if progress.last_decrease.is_finite() {
                next_ratio = next_ratio.min(decrease / progress.last_decrease);
            }
            return NewtonStep { decrease, energy, factor_share: TOLERANCES.old_factor_decrease, next_ratio };
        }
        self.assemble();
        let decrease = self.find_step();
        // A step changes the derivatives of p by its change of p, which is 1/R times its change of c.
        let next_ratio = decrease / (TOLERANCES.relative_softness * energy);
        NewtonStep { decrease, energy, factor_share: 1.0, next_ratio }
    }

    /// Takes the full step if it, or the one after it, changes no significant digit. Then it returns whether
    /// x is exact to the last significant digit.
    fn take_last_step(&mut self, progress: &Progress, step: &NewtonStep) -> Option<bool> {
        if step.gains_less_than(progress.tolerance) {
            self.advance(1.0);
            self.evaluate(0.0);
            return Some(step.gains_less_than(TOLERANCES.decrease));
        }
        if step.next_ratio <= TOLERANCES.trusted_ratio && step.next_gains_less_than(progress.tolerance) {
            if self.respond(1.0, false) {
                self.advance(1.0);
                return Some(step.next_gains_less_than(TOLERANCES.decrease));
            }
            self.known.is_factored = false;
        }
        None
    }

    /// Computes −(M x + f − Aᵀp) into `slope`. Returns an estimate of the energy in the problem: that of the
    /// initial velocities and that of the multipliers.
    fn find_slope(&mut self) -> f64 {
        let mut energy = self.start_energy;
        run_here(FindSlope { problem: self, energy: &mut energy });
        self.rows.add_forces(&self.support, &self.missing, &mut self.slope);
        energy
    }

    /// Moves x, c and M x + f by `length` along δ.
    pub(super) fn advance(&mut self, length: f64) {
        run_here(Advance { problem: self, length });
    }

    /// Computes δ = H⁻¹ slope. Returns the decrease slopeᵀδ.
    fn find_step(&mut self) -> f64 {
        self.step.copy_from_slice(&self.slope);
        self.paths.solve(&self.hessian, &mut self.step);
        dot(&self.slope, &self.step)
    }

    /// Computes A δ into `change` and M δ into `slope`. Returns δᵀM δ.
    fn follow(&mut self) -> f64 {
        self.rows.multiply(&self.support, &self.step, &mut self.change);
        self.paths.multiply(&self.mass, &self.step, &mut self.slope);
        dot(&self.slope, &self.step)
    }

    /// Assembles and factors H.
    pub(super) fn assemble(&mut self) {
        let Self {
            blocks, cones, support, rows, mass, hessian, weighted, weights, derivatives, paths, ..
        } = self;
        hessian.clone_from(mass);
        run_here(Add {
            blocks,
            cones,
            derivatives,
            weights,
            support,
            rows,
            paths,
            matrix: hessian,
            weighted,
        });
        paths.factor(hessian);
        self.known.is_factored = true;
        self.known.is_fresh = true;
    }
}

/// `ConeProblem::find_slope` without Aᵀp.
struct FindSlope<'a> {
    problem: &'a mut ConeProblem,
    energy: &'a mut f64,
}

impl Call for FindSlope<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let ConeProblem { slope, residual, missing, p, counted, moved, .. } = self.problem;
        map(slope, [residual], |_, [residual]| -residual);
        map(missing, [p, counted], |_, [p, counted]| p - counted);
        *self.energy += sum([p, moved], |[p, moved]| p * p * moved);
    }
}

/// [`ConeProblem::advance`].
struct Advance<'a> {
    problem: &'a mut ConeProblem,
    length: f64,
}

impl Call for Advance<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let ConeProblem { x, step, c, change, residual, slope, .. } = self.problem;
        for (to, along) in [(x, step), (c, change), (residual, slope)] {
            map(to, [along], |to, [along]| to + self.length * along);
        }
    }
}
