//! Model predictive control: the first controls of a solution that is shifted and improved at each period.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use robot_dynamics_number::InvalidInput;

use super::error::OptimalControlError;
use super::problem::Problem;
use super::solver::{Fddp, FddpOptions, FddpReport};

/// The options of an [`Mpc`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MpcOptions {
    /// The options of the solver. `max_iterations` counts for the first period.
    pub solver: FddpOptions,
    /// The largest number of iterations of each later period.
    pub iterations: usize,
    /// The time of a period: after the first iteration none starts that would exceed it, if it takes as long
    /// as the longest so far. `None` for no limit.
    pub time_budget: Option<Duration>,
}

impl Default for MpcOptions {
    fn default() -> Self {
        Self { solver: FddpOptions::default(), iterations: 2, time_budget: None }
    }
}

/// The times of the periods of an [`Mpc`], the first without.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MpcTimes {
    /// The number of periods.
    pub periods: usize,
    /// The median of the last 2¹⁶ periods.
    pub median: Duration,
    /// The time that 99.9 % of them do not exceed.
    pub percentile_99_9: Duration,
    /// The longest of all.
    pub longest: Duration,
    /// The periods that took longer than the budget.
    pub over_budget: usize,
}

/// The periods of which the times are kept.
const KEPT: usize = 1 << 16;

/// A controller that solves the problem again at each period, from the measured state.
///
/// One period is one node of the problem. [`step`](Self::step) shifts the last solution by a node, sets x₀,
/// improves the solution by a few iterations, and returns u₀.
///
/// ```
/// use nalgebra::dmatrix;
/// use robot_dynamics::control::optimal::{ControlBounds, ControlResidual, Cost, LinearDynamics, Mpc};
/// use robot_dynamics::control::optimal::{MpcOptions, Problem, StateResidual, StateSpace};
/// let (a, b) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1]);
/// let mut problem = Problem::new(LinearDynamics::new(a.clone(), b.clone())?, &[1.0, 0.0], 30)?;
/// let mut cost = Cost::new();
/// cost.add(StateResidual::new(&StateSpace::vector(2), &[0.0, 0.0])?, vec![1.0, 0.1])?;
/// problem.set_terminal_cost(cost.clone())?;
/// cost.add(ControlResidual::new(&[0.0])?, 0.01)?;
/// problem.set_running_cost(0..30, cost)?;
/// problem.set_control_bounds(0..30, ControlBounds::new(&[-0.5], &[0.5])?)?;
/// let mut mpc = Mpc::new(problem, MpcOptions::default())?;
/// let mut x = dmatrix![1.0; 0.0];
/// for _ in 0..100 {
///     let u = mpc.step(x.as_slice())?[0];
///     x = &a * x + &b * u;
/// }
/// assert!(x.norm() < 1e-2 && mpc.times().periods == 99);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Mpc {
    solver: Fddp,
    options: MpcOptions,
    is_started: bool,
    last: Option<FddpReport>,
    longest_iteration: Duration,
    times: Vec<Duration>,
    /// The periods, those over the budget, and the longest.
    periods: usize,
    over_budget: usize,
    longest: Duration,
}

impl Mpc {
    /// A controller for a problem; the first step solves it with all iterations.
    ///
    /// # Errors
    /// [`InvalidInput`] if an option is invalid.
    pub fn new(problem: Problem, options: MpcOptions) -> Result<Self, InvalidInput> {
        if options.iterations == 0 {
            return Err(InvalidInput::unmet("the number of iterations of a period", "must be 1 or more"));
        }
        let solver = Fddp::new(problem, options.solver.clone())?;
        let (last, longest, times) = (None, Duration::ZERO, Vec::with_capacity(KEPT));
        Ok(Self {
            solver,
            options,
            is_started: false,
            last,
            longest_iteration: longest,
            times,
            periods: 0,
            over_budget: 0,
            longest,
        })
    }

    /// The controls of the next period, from the measured state.
    ///
    /// # Errors
    /// [`OptimalControlError`] if the state is invalid, or the dynamics fail along the shifted solution.
    pub fn step(&mut self, state: &[f64]) -> Result<&[f64], OptimalControlError> {
        let start = Instant::now();
        self.solver.set_initial_state(state)?;
        if self.is_started {
            self.solver.shift();
            self.improve(start)?;
            self.count(start.elapsed());
        } else {
            self.last = Some(self.solver.solve()?);
            self.is_started = true;
        }
        Ok(self.solver.control(0))
    }

    /// A few iterations within the time.
    fn improve(&mut self, start: Instant) -> Result<(), OptimalControlError> {
        let (iterations, budget) = (self.options.iterations, self.options.time_budget);
        let (mut before, longest) = (Instant::now(), &mut self.longest_iteration);
        let report = self.solver.solve_until(None, |record| {
            let now = Instant::now();
            *longest = (*longest).max(now - before);
            before = now;
            let is_last = record.iteration + 1 >= iterations;
            let is_late = budget.is_some_and(|budget| now - start + *longest > budget);
            if is_last || is_late { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        self.last = Some(report);
        Ok(())
    }

    fn count(&mut self, time: Duration) {
        if self.times.len() < KEPT {
            self.times.push(time);
        } else {
            self.times[self.periods % KEPT] = time;
        }
        self.periods += 1;
        self.over_budget += usize::from(self.options.time_budget.is_some_and(|budget| time > budget));
        self.longest = self.longest.max(time);
    }

    /// The times of the periods so far.
    pub fn times(&self) -> MpcTimes {
        let mut sorted = self.times.clone();
        sorted.sort_unstable();
        // The smallest time that a share of the periods does not exceed.
        let at = |per_mille: usize| {
            let rank = (sorted.len() * per_mille).div_ceil(1000);
            sorted.get(rank.saturating_sub(1)).copied().unwrap_or_default()
        };
        MpcTimes {
            periods: self.periods,
            median: at(500),
            percentile_99_9: at(999),
            longest: self.longest,
            over_budget: self.over_budget,
        }
    }

    /// The report of the last solution; `None` before the first step. A period that used its iterations ends
    /// as interrupted.
    pub fn report(&self) -> Option<&FddpReport> {
        self.last.as_ref()
    }

    /// The solver, with the planned trajectory and the gains.
    pub fn fddp(&self) -> &Fddp {
        &self.solver
    }

    /// The solver, to change its costs or its start.
    pub fn fddp_mut(&mut self) -> &mut Fddp {
        &mut self.solver
    }
}
