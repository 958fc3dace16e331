//! Options, records and results of the solver.

use core::fmt;
use std::time::Duration;

use robot_dynamics_number::{InvalidInput, check_positive};

/// The options of [`Fddp`](super::Fddp).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FddpOptions {
    /// The largest number of iterations.
    pub max_iterations: usize,
    /// Converged if no derivative of the Lagrangian by an unbounded control is larger.
    pub gradient_tolerance: f64,
    /// Converged only if no entry of a defect is larger.
    pub defect_tolerance: f64,
    /// Ends if the predicted decrease of the cost is below this share of the cost, or of 1 for smaller costs.
    pub decrease_tolerance: f64,
    /// The first regularization μ of Quu + μ 1, and its bounds.
    pub initial_regularization: f64,
    /// The smallest μ.
    pub min_regularization: f64,
    /// The largest μ; the solver ends beyond it.
    pub max_regularization: f64,
    /// The factor by which μ grows or shrinks.
    pub regularization_factor: f64,
    /// The share of the predicted decrease of the merit that a step must reach.
    pub armijo: f64,
    /// The number of halvings of a step before it is rejected.
    pub max_halvings: usize,
    /// The threads that linearize the nodes; 1 for none beside the caller's.
    pub threads: usize,
    /// The solver starts no iteration after this time.
    pub time_limit: Option<Duration>,
}

impl Default for FddpOptions {
    fn default() -> Self {
        Self {
            max_iterations: 100,
            gradient_tolerance: 1e-6,
            defect_tolerance: 1e-9,
            decrease_tolerance: 1e-12,
            initial_regularization: 1e-9,
            min_regularization: 1e-9,
            max_regularization: 1e9,
            regularization_factor: 10.0,
            armijo: 0.1,
            max_halvings: 10,
            threads: 1,
            time_limit: None,
        }
    }
}

impl FddpOptions {
    /// Checks each number.
    pub(crate) fn check(&self) -> Result<(), InvalidInput> {
        for (quantity, value) in [
            ("the gradient tolerance", self.gradient_tolerance),
            ("the defect tolerance", self.defect_tolerance),
            ("the decrease tolerance", self.decrease_tolerance),
            ("the smallest regularization", self.min_regularization),
            ("the largest regularization", self.max_regularization),
        ] {
            check_positive(quantity, value, "")?;
        }
        let range = self.min_regularization..=self.max_regularization;
        if !range.contains(&self.initial_regularization) {
            let (quantity, value) = ("the first regularization", self.initial_regularization);
            return Err(InvalidInput::out_of_range(quantity, value, "", "between its bounds"));
        }
        if !(self.regularization_factor > 1.0 && self.regularization_factor.is_finite()) {
            let (quantity, value) = ("the factor of the regularization", self.regularization_factor);
            return Err(InvalidInput::out_of_range(quantity, value, "", "above 1 and finite"));
        }
        if !(self.armijo > 0.0 && self.armijo < 1.0) {
            let quantity = "the share of the predicted decrease";
            return Err(InvalidInput::out_of_range(quantity, self.armijo, "", "between 0 and 1"));
        }
        if self.threads == 0 {
            return Err(InvalidInput::unmet("the number of threads", "must be 1 or more"));
        }
        Ok(())
    }
}

/// One iteration of a solver.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct IterationRecord {
    /// Its index, from 0.
    pub iteration: usize,
    /// The cost after it.
    pub cost: f64,
    /// The largest entry of a defect f(x_k, u_k) ⊖ x_{k+1} after it.
    pub defect: f64,
    /// The largest derivative of the Lagrangian by an unbounded control before it.
    pub gradient: f64,
    /// The decrease of the merit that the linear-quadratic model predicts for a full step.
    pub predicted_decrease: f64,
    /// The length of the step, 0 if all were rejected.
    pub step_length: f64,
    /// The regularization μ.
    pub regularization: f64,
}

/// The reason for which a solver ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Termination {
    /// The gradient and the defects are below their tolerances.
    Converged,
    /// The predicted decrease is below its tolerance, the gradient is not: the cost changes by rounding only.
    NegligibleDecrease,
    /// All iterations were used.
    IterationLimit,
    /// No step decreases the merit, also with the largest regularization.
    NoDescent,
    /// The time limit was reached.
    TimeLimit,
    /// The callback ended the solver.
    Interrupted,
    /// The constraints are not satisfied with the largest penalty; they may contradict each other.
    PenaltyLimit,
}

impl fmt::Display for Termination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Converged => "converged",
            Self::NegligibleDecrease => "the cost decreases by rounding only",
            Self::IterationLimit => "the iterations were used up",
            Self::NoDescent => "no step decreases the cost",
            Self::TimeLimit => "the time limit was reached",
            Self::Interrupted => "interrupted",
            Self::PenaltyLimit => "the constraints are not satisfied with the largest penalty",
        })
    }
}

/// The result of a solver; the trajectory is read from the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FddpReport {
    /// The reason for the end.
    pub termination: Termination,
    /// The number of iterations.
    pub iterations: usize,
    /// The cost of the trajectory.
    pub cost: f64,
    /// The largest entry of a defect.
    pub defect: f64,
    /// The largest derivative of the Lagrangian by an unbounded control.
    pub gradient: f64,
}

impl FddpReport {
    /// Whether the solver ended at a local minimum, to its tolerances or to rounding.
    pub fn is_solved(&self) -> bool {
        matches!(self.termination, Termination::Converged | Termination::NegligibleDecrease)
    }
}
