//! Feasibility-driven differential dynamic programming (FDDP) with bounds on the controls.
//!
//! Each iteration linearizes all nodes, solves the linear-quadratic problem by a Riccati recursion with a
//! quadratic program for the bounded controls, and rolls the policies out. Multiple shooting: the states may
//! have defects, which a step of length α shrinks by 1 − α. Without defects and bounds this is iLQR.
//!
//! A step is accepted if the merit J + ν Σ|f̄| decreases by a share of its predicted decrease. The weight ν is
//! large enough that the full step of the model decreases the merit.
//!
//! Sources: Mastalli et al., *Crocoddyl*, ICRA 2020; Mastalli et al., *A feasibility-driven approach to
//! control-limited DDP*, Autonomous Robots 46 (2022); Nocedal, Wright, *Numerical Optimization*, §18.3.

mod constraints;
mod evaluation;
mod memory;
mod model;
mod options;
mod riccati;
mod rollout;
mod warm_start;

pub use options::{FddpOptions, FddpReport, IterationRecord, Termination};

use std::ops::ControlFlow;
use std::time::Instant;

use robot_dynamics_number::InvalidInput;

use self::evaluation::linearize_nodes;
use self::memory::{NodeModel, Policy, Trajectory};
use self::model::{ModelChange, ModelPass};
use self::riccati::Riccati;
use self::rollout::RolloutMemory;
use super::dense::{largest, sum_of_magnitudes};
use super::error::OptimalControlError;
use super::problem::Problem;

/// The share of the merit's decrease that the weight of the defects leaves to them.
const DEFECT_SHARE: f64 = 0.5;

/// Steps at or above this length reduce the regularization.
const LONG_STEP: f64 = 0.5;

/// The changes of the cost, relative to it, that are rounding.
const COST_ROUNDING: f64 = 10.0 * f64::EPSILON;

/// The solver of one [`Problem`]: FDDP, box-FDDP if controls have bounds, iLQR from a rollout.
///
/// The memory is allocated once; an iteration in one thread allocates nothing beyond what the dynamics
/// allocate, as held contacts do. The trajectory of the last solution is the start of the next.
///
/// ```
/// use robot_dynamics::control::optimal::{ControlResidual, Cost, Fddp, FddpOptions, Problem};
/// use robot_dynamics::control::optimal::{SmoothStep, StateResidual};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::Integrator;
/// // Hold a pendulum at rest 0.3 rad below the horizontal after 40 steps of 20 ms.
/// let step = SmoothStep::new(Model::new(pendulum(1.0, 0.5))?, Integrator::SemiImplicitEuler, 0.02)?;
/// let mut problem = Problem::new(step, &[0.0, 0.0], 40)?;
/// let space = problem.state_space().clone();
/// let (mut running, mut terminal) = (Cost::new(), Cost::new());
/// running.add(ControlResidual::new(&[0.0])?, 1e-3)?;
/// terminal.add(StateResidual::new(&space, &[0.3, 0.0])?, 100.0)?;
/// problem.set_running_cost(0..40, running)?;
/// problem.set_terminal_cost(terminal)?;
/// let mut solver = Fddp::new(problem, FddpOptions::default())?;
/// let report = solver.solve()?;
/// assert!(report.is_solved() && (solver.state(40)[0] - 0.3).abs() < 1e-2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
#[doc(alias = "DDP")]
#[doc(alias = "iLQR")]
#[doc(alias = "BoxFDDP")]
pub struct Fddp {
    /// The problem, and its clones for further threads.
    workers: Vec<Problem>,
    options: FddpOptions,
    current: Trajectory,
    trial: Trajectory,
    /// f̄: N + 1 defects.
    gaps: Vec<f64>,
    models: Vec<NodeModel>,
    policies: Vec<Policy>,
    riccati: Riccati,
    pass: ModelPass,
    rollout: RolloutMemory,
    log: Vec<IterationRecord>,
    /// The weight ν of the defects in the merit.
    defect_weight: f64,
    regularization: f64,
    cost: f64,
}

/// The direction of an iteration, before its line search.
struct Direction {
    gradient: f64,
    change: ModelChange,
    predicted_decrease: f64,
}

impl Fddp {
    /// A solver that starts at x₀ in all nodes, and with the controls nearest to zero within their bounds.
    ///
    /// # Errors
    /// [`InvalidInput`] if an option is invalid, or the problem has constraints.
    pub fn new(problem: Problem, options: FddpOptions) -> Result<Self, InvalidInput> {
        if !problem.constraints.is_empty() {
            let required = "has constraints beyond the bounds of controls; use AugmentedLagrangian";
            return Err(InvalidInput::unmet("the problem", required));
        }
        Self::with_constraints(problem, options)
    }

    /// The inner solver of an augmented Lagrangian.
    pub(super) fn with_constraints(problem: Problem, options: FddpOptions) -> Result<Self, InvalidInput> {
        options.check()?;
        let (n, nodes) = (problem.state_space().tangent(), problem.nodes());
        let counts: Vec<usize> = (0..nodes).map(|node| problem.controls(node)).collect();
        let terminal = std::iter::once(NodeModel::new(n, 0, true));
        let current = Trajectory::new(&problem);
        let regularization = options.initial_regularization;
        Ok(Self {
            trial: current.clone(),
            current,
            gaps: vec![0.0; (nodes + 1) * n],
            models: counts.iter().map(|m| NodeModel::new(n, *m, false)).chain(terminal).collect(),
            policies: counts.iter().map(|m| Policy::new(n, *m)).collect(),
            riccati: Riccati::new(&problem),
            pass: ModelPass::new(&problem),
            rollout: RolloutMemory::new(&problem),
            log: Vec::with_capacity(options.max_iterations),
            workers: vec![problem; options.threads],
            options,
            defect_weight: 0.0,
            regularization,
            cost: 0.0,
        })
    }

    /// Solves the problem from the current trajectory.
    ///
    /// # Errors
    /// [`OptimalControlError`] if the dynamics or the cost cannot be computed along the start, or the
    /// derivatives along a later trajectory.
    pub fn solve(&mut self) -> Result<FddpReport, OptimalControlError> {
        self.solve_with(|_| ControlFlow::Continue(()))
    }

    /// The same; calls `callback` after each iteration, which may end the solver.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_with(
        &mut self,
        callback: impl FnMut(&IterationRecord) -> ControlFlow<()>,
    ) -> Result<FddpReport, OptimalControlError> {
        let deadline = self.options.time_limit.map(|limit| Instant::now() + limit);
        self.solve_until(deadline, callback)
    }

    /// The same with a time after which no iteration starts.
    pub(super) fn solve_until(
        &mut self,
        deadline: Option<Instant>,
        mut callback: impl FnMut(&IterationRecord) -> ControlFlow<()>,
    ) -> Result<FddpReport, OptimalControlError> {
        self.log.clear();
        self.defect_weight = 0.0;
        self.regularization = self.options.initial_regularization;
        self.current.clamp(&self.workers[0]);
        self.cost = self.rollout.defects(&mut self.workers[0], &self.current, &mut self.gaps)?;
        let (mut gradient, mut is_new) = (f64::NAN, true);
        for iteration in 0..self.options.max_iterations {
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                return Ok(self.report(Termination::TimeLimit, gradient));
            }
            if is_new {
                linearize_nodes(&mut self.workers, &self.current, &mut self.models)?;
            }
            let Some(direction) = self.find_direction() else {
                return Ok(self.report(Termination::NoDescent, gradient));
            };
            gradient = direction.gradient;
            if let Some(termination) = self.is_solved(&direction) {
                return Ok(self.report(termination, gradient));
            }
            let step_length = self.search(&direction);
            is_new = step_length.is_some();
            let record = self.record(iteration, &direction, step_length.unwrap_or(0.0));
            self.log.push(record);
            let is_interrupted = callback(&record).is_break();
            if is_interrupted {
                return Ok(self.report(Termination::Interrupted, gradient));
            }
            if !self.adapt_regularization(step_length) {
                return Ok(self.report(Termination::NoDescent, gradient));
            }
        }
        Ok(self.report(Termination::IterationLimit, gradient))
    }

    /// The policies of the regularized model and the change that they promise; `None` if the model is not
    /// convex with the largest regularization.
    fn find_direction(&mut self) -> Option<Direction> {
        let (problem, trajectory) = (&self.workers[0], (&self.current, &self.gaps[..]));
        let (models, policies) = (&self.models, &mut self.policies);
        let gradient = loop {
            match self.riccati.solve(problem, trajectory, models, policies, self.regularization) {
                Ok(gradient) => break gradient,
                Err(_) if increase(&mut self.regularization, &self.options) => {}
                Err(_) => return None,
            }
        };
        let change = self.pass.change(&self.gaps, models, policies);
        let gap = sum_of_magnitudes(&self.gaps);
        if gap > 0.0 {
            let rise = change.slope + 0.5 * change.curvature.max(0.0);
            self.defect_weight = self.defect_weight.max(rise / (DEFECT_SHARE * gap));
        }
        let predicted_decrease = self.defect_weight * gap - change.along(1.0);
        Some(Direction { gradient, change, predicted_decrease })
    }

    fn is_solved(&self, direction: &Direction) -> Option<Termination> {
        if largest(&self.gaps) > self.options.defect_tolerance {
            return None;
        }
        if direction.gradient <= self.options.gradient_tolerance {
            return Some(Termination::Converged);
        }
        let tolerance = self.options.decrease_tolerance * self.cost.abs().max(1.0);
        (direction.predicted_decrease <= tolerance).then_some(Termination::NegligibleDecrease)
    }

    /// Takes the first of the step lengths 1, ½, ¼ … that decreases the merit enough; returns its length.
    fn search(&mut self, direction: &Direction) -> Option<f64> {
        let gap = self.defect_weight * sum_of_magnitudes(&self.gaps);
        let mut length = 1.0;
        for _ in 0..=self.options.max_halvings {
            let (start, policies) = ((&self.current, &self.gaps[..]), &self.policies);
            let problem = &mut self.workers[0];
            // A trial whose dynamics fails is too long.
            if let Ok(cost) = self.rollout.roll_out(problem, start, policies, length, &mut self.trial) {
                let predicted = direction.change.along(length) - length * gap;
                let actual = cost - self.cost - length * gap;
                if actual <= self.options.armijo * predicted + COST_ROUNDING * self.cost.abs() {
                    std::mem::swap(&mut self.current, &mut self.trial);
                    self.gaps.iter_mut().for_each(|f| *f *= 1.0 - length);
                    self.cost = cost;
                    return Some(length);
                }
            }
            length *= 0.5;
        }
        None
    }

    /// Shrinks μ after long steps, and increases it after a rejected one; returns false beyond its bound.
    fn adapt_regularization(&mut self, step_length: Option<f64>) -> bool {
        match step_length {
            None => increase(&mut self.regularization, &self.options),
            Some(length) => {
                if length >= LONG_STEP {
                    let smaller = self.regularization / self.options.regularization_factor;
                    self.regularization = smaller.max(self.options.min_regularization);
                }
                true
            }
        }
    }

    fn record(&self, iteration: usize, direction: &Direction, step_length: f64) -> IterationRecord {
        IterationRecord {
            iteration,
            cost: self.cost,
            defect: largest(&self.gaps),
            gradient: direction.gradient,
            predicted_decrease: direction.predicted_decrease,
            step_length,
            regularization: self.regularization,
        }
    }

    fn report(&self, termination: Termination, gradient: f64) -> FddpReport {
        let (iterations, defect) = (self.log.len(), largest(&self.gaps));
        FddpReport { termination, iterations, cost: self.cost, defect, gradient }
    }

    /// The problem.
    pub fn problem(&self) -> &Problem {
        &self.workers[0]
    }

    /// The iterations of the last solution.
    pub fn log(&self) -> &[IterationRecord] {
        &self.log
    }

    /// The cost of the trajectory after the last solution.
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// The state x_k, with k from 0 to N.
    ///
    /// # Panics
    /// If the node does not exist.
    #[track_caller]
    pub fn state(&self, node: usize) -> &[f64] {
        self.current.state(node)
    }

    /// The controls u_k, with k below N.
    ///
    /// # Panics
    /// If the node does not exist.
    #[track_caller]
    pub fn control(&self, node: usize) -> &[f64] {
        self.current.control(node)
    }

    /// The gain K of the policy u = u_k + K (x ⊖ x_k), m×n, row-major. It belongs to the start of the last
    /// iteration, which is the solution up to the tolerances; the rows of controls at a bound are zero.
    ///
    /// # Panics
    /// If the node does not exist.
    #[track_caller]
    pub fn gain(&self, node: usize) -> &[f64] {
        &self.policies[node].gain
    }
}

/// Increases μ; returns false beyond its bound.
fn increase(regularization: &mut f64, options: &FddpOptions) -> bool {
    *regularization *= options.regularization_factor;
    *regularization <= options.max_regularization
}
