//! Damped steps of a least-squares problem over configurations, from one start and from several.

use robot_dynamics_core::{Model, Workspace, integrate, random_within_limits};
use robot_dynamics_number::SplitMix64;

use super::InverseKinematicsOptions;
use super::bounds::Bounds;

/// The initial μ and its bounds; beyond the largest, a step does not change q.
const FIRST_DAMPING: f64 = 1.0;
const LEAST_DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e16;

/// An attempt with a `Short` budget ends if |e|² stays above this fraction of itself over `STAGNATION_STEPS`
/// steps.
const STAGNATION: f64 = 0.9;
const STAGNATION_STEPS: usize = 10;

/// When an attempt ends without success.
#[derive(Clone, Copy, PartialEq, Eq)]
enum IterationBudget {
    /// At slow convergence, because another start may be better.
    Short,
    /// When no step reduces the error.
    Long,
}

/// The error at a configuration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evaluation {
    /// |e|².
    pub squared: f64,
    /// Whether the error is within the tolerances.
    pub is_found: bool,
}

/// The problem min |e(q)|².
pub(crate) trait LeastSquares {
    /// Computes e at q, and keeps it until the next call.
    fn evaluate(&mut self, workspace: &mut Workspace, q: &[f64]) -> Evaluation;

    /// Makes the last e, which belongs to q, the one from which steps start.
    fn accept(&mut self);

    /// Computes the Jacobian of the accepted e, at its q.
    fn linearize(&mut self, workspace: &mut Workspace, q: &[f64]);

    /// Writes δ, which minimizes |e + J δ|² + ½ μ |e|² |δ|² within the limits, and returns |e + J δ|²; `None`
    /// if the system cannot be solved.
    fn step(&mut self, damping: f64, step: &mut [f64]) -> Option<f64>;
}

/// The nearest configuration of one or several attempts.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    pub q: Vec<f64>,
    pub evaluation: Evaluation,
    pub iterations: usize,
    pub restarts: usize,
}

impl Search {
    /// The better of this result and another, with the iterations of both.
    fn joined(self, other: Self) -> Self {
        let iterations = self.iterations + other.iterations;
        let restarts = self.restarts + other.restarts;
        let other_wins = other.evaluation.is_found || other.evaluation.squared < self.evaluation.squared;
        let best = if other_wins { other } else { self };
        Self { iterations, restarts, ..best }
    }
}

/// The memory of the steps.
pub(crate) struct Iteration<'a> {
    model: &'a Model,
    options: &'a InverseKinematicsOptions,
    bounds: &'a Bounds,
    q: Vec<f64>,
    trial: Vec<f64>,
    step: Vec<f64>,
}

impl<'a> Iteration<'a> {
    pub(crate) fn new(model: &'a Model, options: &'a InverseKinematicsOptions, bounds: &'a Bounds) -> Self {
        let (q, trial, step) = (vec![0.0; model.nq()], vec![0.0; model.nq()], vec![0.0; model.nv()]);
        Self { model, options, bounds, q, trial, step }
    }

    /// The nearest configuration from a start, and then from random ones. Without success, the steps from the
    /// nearest one continue to a local minimum.
    pub(crate) fn search(
        &mut self,
        problem: &mut impl LeastSquares,
        workspace: &mut Workspace,
        start: &[f64],
    ) -> Search {
        let mut best = self.run(problem, workspace, start, IterationBudget::Short);
        let mut random = SplitMix64::new(self.options.seed);
        while !best.evaluation.is_found && best.restarts < self.options.max_restarts {
            let start = random_within_limits(self.model, &mut random);
            let other = self.run(problem, workspace, &start, IterationBudget::Short);
            best = best.joined(Search { restarts: 1, ..other });
        }
        if !best.evaluation.is_found {
            let start = best.q.clone();
            best = best.joined(self.run(problem, workspace, &start, IterationBudget::Long));
        }
        best
    }

    /// Iterates from a start until the error is within the tolerances, or the limit of steps or of patience
    /// is reached.
    fn run(
        &mut self,
        problem: &mut impl LeastSquares,
        workspace: &mut Workspace,
        start: &[f64],
        budget: IterationBudget,
    ) -> Search {
        self.q.copy_from_slice(start);
        self.bounds.clamp(&mut self.q);
        let mut current = problem.evaluate(workspace, &self.q);
        problem.accept();
        let mut damping = FIRST_DAMPING;
        let (mut iterations, mut mark) = (0, current.squared);
        let mut is_new = true;
        while !current.is_found && iterations < self.options.max_iterations && damping <= MOST_DAMPING {
            if is_new {
                problem.linearize(workspace, &self.q);
            }
            iterations += 1;
            let gained = self.try_step(problem, workspace, current.squared, damping);
            is_new = gained.is_some();
            match gained {
                // Adapt the damping to the ratio of actual and predicted reduction.
                Some((next, share)) => {
                    if share > 0.75 {
                        damping = (damping / 4.0).max(LEAST_DAMPING);
                    } else if share < 0.25 {
                        damping *= 4.0;
                    }
                    std::mem::swap(&mut self.q, &mut self.trial);
                    problem.accept();
                    current = next;
                }
                None => damping *= 8.0,
            }
            if budget == IterationBudget::Short && iterations % STAGNATION_STEPS == 0 {
                if current.squared > STAGNATION * mark {
                    break;
                }
                mark = current.squared;
            }
        }
        Search { q: self.q.clone(), evaluation: current, iterations, restarts: 0 }
    }

    /// The error after a step, in `trial`, and its reduction relative to that of the linear model; `None`
    /// without a reduction.
    fn try_step(
        &mut self,
        problem: &mut impl LeastSquares,
        workspace: &mut Workspace,
        squared: f64,
        damping: f64,
    ) -> Option<(Evaluation, f64)> {
        let promised = problem.step(damping, &mut self.step)?;
        integrate(self.model, &self.q, &self.step, &mut self.trial);
        self.bounds.clamp(&mut self.trial);
        let next = problem.evaluate(workspace, &self.trial);
        let (gain, promise) = (squared - next.squared, squared - promised);
        // NaN fails this test, too.
        (gain > 0.0 && promise > 0.0).then(|| (next, gain / promise))
    }
}
