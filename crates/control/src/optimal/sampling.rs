//! Optimal control by sampling: path integrals (MPPI) and the cross-entropy method (CEM).
//!
//! An iteration draws sequences of controls about a mean, rolls each out, and moves the mean by their costs.
//! It needs no derivatives. It finds its way around obstacles of the cost, and through contacts that have no
//! slope. Near a minimum FDDP is faster by orders.

mod options;
mod samples;

pub use options::{SamplingLaw, SamplingOptions, SamplingRecord, SamplingReport};

use std::ops::ControlFlow;
use std::time::Instant;

use robot_dynamics_number::{InputProblem, InvalidInput, SplitMix64, check_finite};

use self::samples::{Distribution, Worker, evaluate};
use super::error::OptimalControlError;
use super::problem::Problem;
use super::solver::Termination;

/// The sampling of one [`Problem`] by a [`SamplingLaw`].
///
/// The controls are the best that a solution evaluated, and the mean of the next solution. They stay within
/// their bounds. Equal seeds give equal results for any number of threads. The constraints of a problem
/// beyond the bounds of controls are refused: write them as barriers of the cost.
///
/// ```
/// use nalgebra::dmatrix;
/// use robot_dynamics::control::optimal::{ControlBounds, ControlResidual, Cost, LinearDynamics, Problem};
/// use robot_dynamics::control::optimal::{Sampling, SamplingLaw, SamplingOptions, StateResidual, StateSpace};
/// // A mass of 1 kg, pushed for 10 steps of 0.1 s with at most 5 N, moves to the origin.
/// let mass = LinearDynamics::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1])?;
/// let mut problem = Problem::new(mass, &[1.0, 0.0], 10)?;
/// let mut terminal = Cost::new();
/// terminal.add(StateResidual::new(&StateSpace::vector(2), &[0.0, 0.0])?, 100.0)?;
/// problem.set_terminal_cost(terminal)?;
/// problem.set_control_bounds(0..10, ControlBounds::new(&[-5.0], &[5.0])?)?;
/// let law = SamplingLaw::CrossEntropy { elites: 16, least_deviation: 0.05 };
/// let mut sampling = Sampling::new(problem, SamplingOptions::new(law, &[3.0]))?;
/// let report = sampling.solve()?;
/// assert!(report.cost < 0.1 * report.initial_cost);
/// assert!((0..10).all(|k| sampling.control(k)[0].abs() <= 5.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
#[doc(alias = "MPPI")]
#[doc(alias = "CEM")]
pub struct Sampling {
    workers: Vec<Worker>,
    options: SamplingOptions,
    /// The first control of each node, and the end.
    starts: Vec<usize>,
    mean: Vec<f64>,
    deviation: Vec<f64>,
    initial_deviation: Vec<f64>,
    /// The controls of all samples, their costs, their weights, and their order by cost.
    samples: Vec<f64>,
    costs: Vec<f64>,
    weights: Vec<f64>,
    order: Vec<usize>,
    best: (f64, Vec<f64>),
    log: Vec<SamplingRecord>,
    /// The iterations of all solutions, each with its own random numbers.
    drawn: u64,
    is_started: bool,
}

impl Sampling {
    /// A sampling that starts with the controls nearest to zero within their bounds.
    ///
    /// # Errors
    /// [`InvalidInput`] if an option is invalid, the deviation is not one number or one for each control of
    /// every node with controls, or the problem has constraints.
    pub fn new(problem: Problem, options: SamplingOptions) -> Result<Self, InvalidInput> {
        options.check()?;
        if !problem.constraints.is_empty() {
            let required = "has constraints beyond the bounds of controls; use barriers of the cost";
            return Err(InvalidInput::unmet("the problem", required));
        }
        let (mut starts, mut initial_deviation) = (vec![0], Vec::new());
        for node in 0..problem.nodes() {
            let m = problem.controls(node);
            match options.deviation.as_slice() {
                [one] => initial_deviation.resize(starts[node] + m, *one),
                all if all.len() == m || m == 0 => initial_deviation.extend_from_slice(&all[..m]),
                all => {
                    let counts = format!("are {}; node {node} has {m} controls", all.len());
                    return Err(InvalidInput::unmet("the deviations of the controls", counts));
                }
            }
            starts.push(starts[node] + m);
        }
        let (length, count) = (initial_deviation.len(), options.samples);
        let mut sampling = Self {
            workers: vec![Worker::new(problem); options.threads],
            starts,
            mean: vec![0.0; length],
            deviation: initial_deviation.clone(),
            initial_deviation,
            samples: vec![0.0; count * length],
            costs: vec![0.0; count],
            weights: vec![0.0; count],
            order: (0..count).collect(),
            best: (f64::INFINITY, vec![0.0; length]),
            log: Vec::with_capacity(options.iterations),
            drawn: 0,
            is_started: false,
            options,
        };
        sampling.clamp_mean();
        Ok(sampling)
    }

    /// Takes all iterations from the current controls.
    ///
    /// # Errors
    /// [`OptimalControlError`] if no sample of an iteration can be rolled out.
    pub fn solve(&mut self) -> Result<SamplingReport, OptimalControlError> {
        self.solve_with(|_| ControlFlow::Continue(()))
    }

    /// The same; calls `callback` after each iteration, which may end the sampling.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_with(
        &mut self,
        mut callback: impl FnMut(&SamplingRecord) -> ControlFlow<()>,
    ) -> Result<SamplingReport, OptimalControlError> {
        let deadline = self.options.time_limit.map(|limit| Instant::now() + limit);
        self.log.clear();
        self.deviation.copy_from_slice(&self.initial_deviation);
        self.best.0 = f64::INFINITY;
        let mut termination = Termination::IterationLimit;
        for iteration in 0..self.options.iterations {
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                termination = Termination::TimeLimit;
                break;
            }
            let record = self.iterate(iteration)?;
            self.log.push(record);
            if callback(&record).is_break() {
                termination = Termination::Interrupted;
                break;
            }
        }
        // The last mean was not evaluated.
        let cost = self.workers[0].cost(&self.mean);
        if cost < self.best.0 {
            self.best.0 = cost;
            self.best.1.copy_from_slice(&self.mean);
        } else if self.best.0 < f64::INFINITY {
            self.mean.copy_from_slice(&self.best.1);
        }
        let initial_cost = self.log.first().map_or(cost, |record| record.mean_cost);
        let (iterations, failed) = (self.log.len(), self.log.iter().map(|record| record.failed).sum());
        Ok(SamplingReport { termination, iterations, cost: self.best.0, initial_cost, failed })
    }

    /// Draws samples, and moves the mean by their costs.
    fn iterate(&mut self, iteration: usize) -> Result<SamplingRecord, OptimalControlError> {
        let hash = SplitMix64::new(self.drawn).next_u64();
        self.drawn += 1;
        let from = Distribution {
            mean: &self.mean,
            deviation: &self.deviation,
            correlation: self.options.correlation,
            seed: SplitMix64::new(self.options.seed ^ hash).next_u64(),
        };
        evaluate(&mut self.workers, &from, &mut self.samples, &mut self.costs);
        self.order.sort_by(|a, b| self.costs[*a].total_cmp(&self.costs[*b]).then(a.cmp(b)));
        let best = self.order[0];
        let failed = self.costs.iter().filter(|cost| !cost.is_finite()).count();
        if !self.costs[best].is_finite() {
            return Err(self.failure());
        }
        if self.costs[best] < self.best.0 {
            let length = self.mean.len();
            self.best.0 = self.costs[best];
            self.best.1.copy_from_slice(&self.samples[best * length..][..length]);
        }
        let mean_cost = self.costs[0];
        self.weigh();
        self.move_mean();
        let squares: f64 = self.weights.iter().map(|w| w * w).sum();
        let effective_samples = 1.0 / squares;
        Ok(SamplingRecord { iteration, mean_cost, best_cost: self.best.0, effective_samples, failed })
    }

    /// The weights of the samples, with the sum 1.
    fn weigh(&mut self) {
        match self.options.law {
            SamplingLaw::Mppi { temperature } => {
                let least = self.costs[self.order[0]];
                for (weight, cost) in self.weights.iter_mut().zip(&self.costs) {
                    *weight = (-(cost - least) / temperature).exp();
                }
            }
            SamplingLaw::CrossEntropy { elites, .. } => {
                self.weights.fill(0.0);
                for &index in self.order[..elites].iter().filter(|index| self.costs[**index].is_finite()) {
                    self.weights[index] = 1.0;
                }
            }
        }
        let sum: f64 = self.weights.iter().sum();
        self.weights.iter_mut().for_each(|weight| *weight /= sum);
    }

    /// The weighted mean, and for cross entropy the deviation about it.
    fn move_mean(&mut self) {
        let length = self.mean.len();
        let weighted = || self.samples.chunks_exact(length).zip(&self.weights).filter(|(_, w)| **w > 0.0);
        self.mean.fill(0.0);
        for (sample, weight) in weighted() {
            self.mean.iter_mut().zip(sample).for_each(|(mean, u)| *mean += weight * u);
        }
        if let SamplingLaw::CrossEntropy { least_deviation, .. } = self.options.law {
            self.deviation.fill(0.0);
            for (sample, weight) in weighted() {
                for ((variance, u), mean) in self.deviation.iter_mut().zip(sample).zip(&self.mean) {
                    *variance += weight * (u - mean) * (u - mean);
                }
            }
            for (deviation, first) in self.deviation.iter_mut().zip(&self.initial_deviation) {
                *deviation = deviation.sqrt().max(least_deviation * first);
            }
        }
        // A mean of numbers within bounds is within them, apart from rounding.
        self.clamp_mean();
    }

    fn clamp_mean(&mut self) {
        let problem = &self.workers[0].problem;
        for node in 0..problem.nodes() {
            problem.control_bounds(node).clamp(&mut self.mean[self.starts[node]..self.starts[node + 1]]);
        }
    }

    /// The failure of the mean's rollout; all samples failed.
    fn failure(&mut self) -> OptimalControlError {
        let mean = self.mean.clone();
        self.workers[0].first_failure(&mean).unwrap_or_else(|| {
            InvalidInput::unmet("the samples", "cannot be rolled out; take a smaller deviation").into()
        })
    }

    /// The controls of the next period from the measured state. After the first call, the last solution is
    /// shifted by a node. Each call takes all iterations of the options: a few suffice then.
    ///
    /// # Errors
    /// [`OptimalControlError`] if the state is invalid, or no sample can be rolled out.
    pub fn step(&mut self, state: &[f64]) -> Result<&[f64], OptimalControlError> {
        self.set_initial_state(state)?;
        if self.is_started {
            self.shift();
        }
        self.is_started = true;
        self.solve()?;
        Ok(self.control(0))
    }

    /// Starts from these controls, one slice for each node.
    ///
    /// # Errors
    /// [`InvalidInput`] if a count or a length differs from the problem's, or a number is not finite.
    pub fn set_controls<U: AsRef<[f64]>>(&mut self, controls: &[U]) -> Result<(), InvalidInput> {
        check_count("the controls", controls.len(), self.starts.len() - 1)?;
        for (node, control) in controls.iter().enumerate() {
            let (quantity, control) = (format!("the controls of node {node}"), control.as_ref());
            check_count(&quantity, control.len(), self.starts[node + 1] - self.starts[node])?;
            check_finite(&quantity, control)?;
        }
        for (control, start) in controls.iter().zip(&self.starts) {
            let control = control.as_ref();
            self.mean[*start..start + control.len()].copy_from_slice(control);
        }
        self.clamp_mean();
        Ok(())
    }

    /// Changes x₀.
    ///
    /// # Errors
    /// [`InvalidInput`] if it is not a state.
    pub fn set_initial_state(&mut self, state: &[f64]) -> Result<(), InvalidInput> {
        self.workers.iter_mut().try_for_each(|worker| worker.problem.set_initial_state(state))
    }

    /// Shifts the controls by one node: u_k ← u_{k+1}; the last controls repeat. Nodes keep their own
    /// controls if the next node has another number of them.
    pub fn shift(&mut self) {
        for node in 0..self.starts.len() - 2 {
            let (own, next) = (self.starts[node], self.starts[node + 1]);
            if self.starts[node + 2] - next == next - own {
                self.mean.copy_within(next..self.starts[node + 2], own);
            }
        }
        self.clamp_mean();
    }

    /// The problem.
    pub fn problem(&self) -> &Problem {
        &self.workers[0].problem
    }

    /// The iterations of the last solution.
    pub fn log(&self) -> &[SamplingRecord] {
        &self.log
    }

    /// The controls u_k, with k below N.
    ///
    /// # Panics
    /// If the node does not exist.
    #[track_caller]
    pub fn control(&self, node: usize) -> &[f64] {
        &self.mean[self.starts[node]..self.starts[node + 1]]
    }
}

fn check_count(quantity: &str, found: usize, expected: usize) -> Result<(), InvalidInput> {
    if found == expected {
        return Ok(());
    }
    let (owner, hint) = ("the problem".to_owned(), "");
    Err(InvalidInput::new(quantity, InputProblem::WrongLength { found, expected, owner, hint }))
}
