//! Constraints of states and controls by an augmented Lagrangian around FDDP.
//!
//! The inner solver minimizes J + Σ ½ μ |z − Π z|² with z = c + λ/μ. If the violation is below its tolerance,
//! λ ← μ (z − Π z) and the tolerances shrink; otherwise μ grows. Bounds on the controls stay in the inner
//! solver.
//!
//! Sources: Conn, Gould, Toint, *A globally convergent augmented Lagrangian algorithm*, SIAM Journal on
//! Numerical Analysis 28 (1991); Jallet, Bambade, Arlaud, El-Kazdadi, Mansard, Carpentier, *ProxDDP: proximal
//! constrained trajectory optimization*, IEEE Trans. Robotics 41 (2025).

use std::ops::ControlFlow;
use std::time::Instant;

use robot_dynamics_number::{InvalidInput, check_positive};

use super::error::OptimalControlError;
use super::problem::Problem;
use super::solver::{Fddp, FddpOptions, FddpReport, IterationRecord, Termination};

/// The options of an [`AugmentedLagrangian`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AugmentedLagrangianOptions {
    /// The options of the inner solver. Its time limit counts for the whole solution.
    pub inner: FddpOptions,
    /// Converged only if no constraint is violated by more.
    pub constraint_tolerance: f64,
    /// The first penalty μ.
    pub initial_penalty: f64,
    /// The largest μ; the solver ends beyond it.
    pub max_penalty: f64,
    /// The factor by which μ grows.
    pub penalty_factor: f64,
    /// The largest number of inner solutions.
    pub max_outer_iterations: usize,
}

impl Default for AugmentedLagrangianOptions {
    fn default() -> Self {
        Self {
            inner: FddpOptions::default(),
            constraint_tolerance: 1e-6,
            initial_penalty: 10.0,
            max_penalty: 1e9,
            penalty_factor: 10.0,
            max_outer_iterations: 50,
        }
    }
}

/// One inner solution of an [`AugmentedLagrangian`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct OuterRecord {
    /// The penalty μ.
    pub penalty: f64,
    /// The largest violation after it.
    pub violation: f64,
    /// The report of the inner solver; its cost includes the terms of the constraints.
    pub inner: FddpReport,
}

/// The result of an [`AugmentedLagrangian`]; the trajectory is read from its [`Fddp`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedReport {
    /// The reason for the end.
    pub termination: Termination,
    /// The iterations of all inner solutions.
    pub iterations: usize,
    /// The cost J without the terms of the constraints.
    pub cost: f64,
    /// The largest violation of a constraint, or slack of one with a multiplier.
    pub violation: f64,
    /// The largest entry of a defect.
    pub defect: f64,
    /// The largest derivative of the Lagrangian by an unbounded control.
    pub gradient: f64,
}

/// The solver of a [`Problem`] with constraints: an augmented Lagrangian around [`Fddp`].
///
/// ```
/// use nalgebra::dmatrix;
/// use robot_dynamics::control::optimal::{AugmentedLagrangian, AugmentedLagrangianOptions, ControlResidual};
/// use robot_dynamics::control::optimal::{Cost, LinearDynamics, Problem, StateResidual, StateSpace};
/// // The least effort that moves a mass from rest by exactly 1 m in 20 steps of 0.1 s, and stops it.
/// let mass = LinearDynamics::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1])?;
/// let mut problem = Problem::new(mass, &[0.0, 0.0], 20)?;
/// let mut effort = Cost::new();
/// effort.add(ControlResidual::new(&[0.0])?, 1.0)?;
/// problem.set_running_cost(0..20, effort)?;
/// let arrive = StateResidual::new(&StateSpace::vector(2), &[1.0, 0.0])?;
/// problem.add_terminal_constraint(arrive, &[0.0; 2], &[0.0; 2])?;
/// let mut solver = AugmentedLagrangian::new(problem, AugmentedLagrangianOptions::default())?;
/// let report = solver.solve()?;
/// assert!(report.violation < 1e-6);
/// // The force falls linearly, by antisymmetry.
/// let u = |k: usize| solver.fddp().control(k)[0];
/// assert!((u(0) + u(19)).abs() < 1e-4 && (u(0) - 2.0 * u(1) + u(2)).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
#[doc(alias = "ProxDDP")]
#[doc(alias = "ALTRO")]
pub struct AugmentedLagrangian {
    solver: Fddp,
    options: AugmentedLagrangianOptions,
    log: Vec<OuterRecord>,
}

/// The exponents by which the tolerances of the violation depend on μ. (Conn, Gould, Toint, §3)
const FIRST_EXPONENT: f64 = 0.1;
const NEXT_EXPONENT: f64 = 0.9;

/// The inner gradient's tolerance with the penalty 1, and that of the violation.
const FIRST_GRADIENT: f64 = 0.1;
const FIRST_VIOLATION: f64 = 1.0;

impl AugmentedLagrangian {
    /// A solver that starts as [`Fddp`] does, with multipliers 0.
    ///
    /// # Errors
    /// [`InvalidInput`] if an option is invalid.
    pub fn new(problem: Problem, options: AugmentedLagrangianOptions) -> Result<Self, InvalidInput> {
        check_positive("the constraint tolerance", options.constraint_tolerance, "")?;
        check_positive("the first penalty", options.initial_penalty, "")?;
        let is_growing = options.penalty_factor > 1.0 && options.penalty_factor.is_finite();
        if !is_growing {
            let (quantity, value) = ("the factor of the penalty", options.penalty_factor);
            return Err(InvalidInput::out_of_range(quantity, value, "", "above 1 and finite"));
        }
        let solver = Fddp::with_constraints(problem, options.inner.clone())?;
        let log = Vec::with_capacity(options.max_outer_iterations);
        Ok(Self { solver, options, log })
    }

    /// Solves the problem from the current trajectory, with the multipliers 0.
    ///
    /// # Errors
    /// As [`Fddp::solve`].
    pub fn solve(&mut self) -> Result<ConstrainedReport, OptimalControlError> {
        self.solve_with(|_| ControlFlow::Continue(()))
    }

    /// The same; calls `callback` after each inner iteration, which may end the solver.
    ///
    /// # Errors
    /// As [`Fddp::solve`].
    pub fn solve_with(
        &mut self,
        mut callback: impl FnMut(&IterationRecord) -> ControlFlow<()>,
    ) -> Result<ConstrainedReport, OptimalControlError> {
        let options = self.options.clone();
        let deadline = options.inner.time_limit.map(|limit| Instant::now() + limit);
        let mut penalty = options.initial_penalty;
        let first = |penalty: f64| (FIRST_GRADIENT / penalty, FIRST_VIOLATION / penalty.powf(FIRST_EXPONENT));
        let (mut gradient, mut allowed) = first(penalty);
        self.log.clear();
        self.solver.set_penalty(penalty, true);
        for _ in 0..options.max_outer_iterations {
            self.solver.set_gradient_tolerance(gradient.max(options.inner.gradient_tolerance));
            let inner = self.solver.solve_until(deadline, &mut callback)?;
            let violation = self.solver.violation()?;
            self.log.push(OuterRecord { penalty, violation, inner });
            let is_solved = inner.is_solved() && gradient <= options.inner.gradient_tolerance;
            if violation <= options.constraint_tolerance && is_solved {
                return self.report(inner.termination);
            }
            if matches!(inner.termination, Termination::TimeLimit | Termination::Interrupted) {
                return self.report(inner.termination);
            }
            if violation <= allowed.max(options.constraint_tolerance) {
                self.solver.update_multipliers()?;
                allowed /= penalty.powf(NEXT_EXPONENT);
                gradient /= penalty;
            } else {
                penalty *= options.penalty_factor;
                if penalty > options.max_penalty {
                    return self.report(Termination::PenaltyLimit);
                }
                self.solver.set_penalty(penalty, false);
                (gradient, allowed) = first(penalty);
            }
        }
        self.report(Termination::IterationLimit)
    }

    fn report(&mut self, termination: Termination) -> Result<ConstrainedReport, OptimalControlError> {
        let cost = self.solver.cost_without_constraints()?;
        let last = self.log.last().expect("an inner solution");
        let iterations = self.log.iter().map(|record| record.inner.iterations).sum();
        let FddpReport { defect, gradient, .. } = last.inner;
        Ok(ConstrainedReport { termination, iterations, cost, violation: last.violation, defect, gradient })
    }

    /// The inner solver, with the trajectory.
    pub fn fddp(&self) -> &Fddp {
        &self.solver
    }

    /// The inner solver, to set its start.
    pub fn fddp_mut(&mut self) -> &mut Fddp {
        &mut self.solver
    }

    /// The inner solutions of the last solution.
    pub fn log(&self) -> &[OuterRecord] {
        &self.log
    }
}

impl ConstrainedReport {
    /// Whether the solver ended at a local minimum that satisfies the constraints to their tolerance.
    pub fn is_solved(&self) -> bool {
        matches!(self.termination, Termination::Converged | Termination::NegligibleDecrease)
    }
}
