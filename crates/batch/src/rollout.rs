//! Rollouts of batches.

mod by_stepper;
#[cfg(feature = "native")]
mod native;
pub(super) mod pullback;
mod step;
mod torques;

pub use by_stepper::{StepperRollout, rollout_by_stepper};
pub use pullback::rollout_pullback;
pub use torques::{PolicyInput, Torques};

use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use robot_dynamics_core::Model;
use robot_dynamics_integrators::{Integrator, Stage, StepScheme};
use robot_dynamics_simulation::motion::integrate::explicit::explicit_names;
use thiserror::Error;

use self::step::Advance;
use super::bad_states::BadStateSet;
use super::compiled_once::{Motion, Progress};
use super::compute::{check_table, check_workspace};
use super::native::Number;
use super::share::for_each_block;
use super::workspace::BlockMemory;
use super::{BadStates, BatchFloat, BatchWorkspace, block};

pub use robot_dynamics_simulation::Rollout;

/// The progress of a rollout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RolloutProgress {
    /// Completed steps over all states.
    pub done: u64,
    /// The total number of steps over all states.
    pub total: u64,
}

impl RolloutProgress {
    /// The progress of a rollout that is computed outside this crate.
    ///
    /// ```
    /// assert_eq!(robot_dynamics::batch::RolloutProgress::new(64, 1000).done, 64);
    /// ```
    pub const fn new(done: u64, total: u64) -> Self {
        Self { done, total }
    }
}

/// The error of a rollout that some states did not complete.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RolloutError {
    /// Some states became invalid; all others are valid.
    #[error(transparent)]
    BadStates(#[from] BadStates),
    /// The progress callback cancelled the rollout.
    #[error("the rollout was cancelled: {} of {batch} states are as they were", .unfinished.len())]
    Cancelled {
        /// The indices of the unchanged states, ascending; all others are at the end of the rollout.
        unfinished: Vec<usize>,
        /// The number of states in the batch.
        batch: usize,
    },
    /// The step is not positive and finite.
    #[error("the step must be positive and finite, got {step} s")]
    BadStep {
        /// The given step \[s\].
        step: f64,
    },
    /// The row solves an equation in each step.
    #[error(
        "{integrator} solves an equation at each step; batches move by explicit rows: {}",
        explicit_names()
    )]
    Implicit {
        /// The requested row.
        integrator: Integrator,
    },
    /// A policy gives the torques of a rollout whose pullback is requested.
    #[error(
        "a policy's torques depend on the state in a way that is not known here: keep the torques it gave, pull the \
         rollout back with `Torques::EachStep`, and add what the policy's own slopes make of `by_force`"
    )]
    Policy,
}

/// One block's part of every table.
struct Job<'a, T> {
    first: usize,
    states: usize,
    q: &'a mut [T],
    v: &'a mut [T],
    q_trajectory: &'a mut [T],
    v_trajectory: &'a mut [T],
}

/// The data that all threads of a rollout share.
struct Shared<'a> {
    progress: &'a (dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync),
    done: AtomicU64,
    total: u64,
    cancelled: AtomicBool,
}

impl<'a> Shared<'a> {
    /// For one step of one state, whose progress is not counted.
    #[cfg(feature = "native")]
    fn of_one_step(progress: &'a (dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync)) -> Self {
        Self { progress, done: AtomicU64::new(0), total: 1, cancelled: AtomicBool::new(false) }
    }

    /// Counts completed steps; returns whether to continue.
    fn go_on(&self, steps: u64) -> bool {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        if !self.cancelled.load(Ordering::Relaxed)
            && (self.progress)(RolloutProgress { done, total: self.total }).is_break()
        {
            self.cancelled.store(true, Ordering::Relaxed);
        }
        !self.cancelled.load(Ordering::Relaxed)
    }
}

/// Advances each state (q, v) in place over `rollout.steps` steps.
///
/// q is \[batch\]\[nq\], v is \[batch\]\[nv\]. Quaternions keep unit length, because the stages are those of
/// Munthe-Kaas, as in [`step`](robot_dynamics_simulation::step). The trajectories receive the state after
/// every `stride`-th step, \[batch\]\[samples\]\[nq\] and \[batch\]\[samples\]\[nv\]; they are empty if the
/// stride is 0.
///
/// `progress` is called occasionally from any thread. If it breaks, the states that are not at the end remain
/// unchanged, and their trajectories are unspecified. With a [policy](Torques::Policy) each call allocates
/// the rows of each block.
///
/// # Errors
/// [`RolloutError`]; all states that it does not list are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
///
/// ```
/// use robot_dynamics::batch::{BatchWorkspace, Rollout, Torques, rollout};
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, neutral};
/// use robot_dynamics::simulation::Integrator;
/// use std::ops::ControlFlow;
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let (mut q, mut v) = (neutral(&model).repeat(20), vec![0.0; 20 * model.nv()]);
/// let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 100);
/// let mut workspace = BatchWorkspace::new(&model);
/// let go_on = |_| ControlFlow::Continue(());
/// rollout(&model, &mut workspace, &how, Torques::Zero, &mut q, &mut v, (&mut [], &mut []), &go_on)?;
/// assert!(v.iter().any(|v| v.abs() > 0.1)); // the robot falls
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[allow(clippy::too_many_arguments)]
#[track_caller]
pub fn rollout<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    rollout: &Rollout,
    torques: Torques<'_, T>,
    q: &mut [T],
    v: &mut [T],
    trajectory: (&mut [T], &mut [T]),
    progress: &(dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync),
) -> Result<(), RolloutError> {
    T::rollout(model, workspace, rollout, torques, Motion { q, v, trajectory }, progress)
}

/// The implementation of [`rollout`], compiled in this crate.
#[track_caller]
pub(super) fn move_states<T: BatchFloat + Number>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    rollout: &Rollout,
    torques: Torques<'_, T>,
    Motion { q, v, trajectory: (q_trajectory, v_trajectory) }: Motion<'_, T>,
    progress: Progress<'_>,
) -> Result<(), RolloutError> {
    check_workspace(model, workspace);
    let (h, nq, nv) = (rollout.step, model.nq, model.nv);
    if !(h > 0.0 && h.is_finite()) {
        return Err(RolloutError::BadStep { step: h });
    }
    let integrator = rollout.integrator;
    let StepScheme::Explicit(stages) = integrator.scheme() else {
        return Err(RolloutError::Implicit { integrator });
    };
    assert!(q.len().is_multiple_of(nq.max(1)), "q has {} numbers, not a multiple of nq = {nq}", q.len());
    let batch = q.len() / nq.max(1);
    check_table("v", v.len(), batch, nv);
    check_table("the trajectory of q", q_trajectory.len(), batch, rollout.samples() * nq);
    check_table("the trajectory of v", v_trajectory.len(), batch, rollout.samples() * nv);
    torques.check(batch, rollout.steps, nv);
    if batch == 0 {
        return Ok(());
    }
    if rollout.steps == 0 {
        let is_bad = |i: &usize| {
            let numbers = q[i * nq..(i + 1) * nq].iter().chain(&v[i * nv..(i + 1) * nv]);
            !numbers.copied().all(T::is_finite)
        };
        return Ok(BadStates::unless_empty((0..batch).filter(is_bad).collect(), batch)?);
    }
    let shared = Shared {
        progress,
        done: AtomicU64::new(0),
        total: batch as u64 * rollout.steps as u64,
        cancelled: AtomicBool::new(false),
    };
    let outcome = Outcome::default();
    let tables = [q, v, q_trajectory, v_trajectory];
    #[cfg(feature = "native")]
    let tables = {
        let how = (&shared, &outcome);
        match native::move_natively(model, workspace, (rollout, stages), torques, tables, how) {
            Ok(()) => return outcome.into_result(batch),
            Err(tables) => tables,
        }
    };
    for_each_block(workspace, batch, 1, tables, &|block, first, states, tables| {
        let [q, v, q_trajectory, v_trajectory] = tables;
        let job = Job { first, states, q, v, q_trajectory, v_trajectory };
        let (mut bits, mut finished) = (0, false);
        if !shared.cancelled.load(Ordering::Relaxed) {
            (bits, finished) = advance(block, model, (rollout, stages), torques, job, &shared);
        }
        outcome.add(bits, finished, first..first + states);
    });
    outcome.into_result(batch)
}

/// The outcome of each state.
#[derive(Default)]
struct Outcome {
    bad: BadStateSet,
    unfinished: Mutex<Vec<usize>>,
}

impl Outcome {
    /// Records a block that is complete or cancelled, with a bit for each bad state.
    fn add(&self, bits: u32, finished: bool, states: Range<usize>) {
        if finished {
            self.bad.add(bits, states.start);
        } else {
            self.unfinished.lock().unwrap_or_else(PoisonError::into_inner).extend(states);
        }
    }

    fn into_result(self, batch: usize) -> Result<(), RolloutError> {
        let mut unfinished = self.unfinished.into_inner().unwrap_or_else(PoisonError::into_inner);
        if !unfinished.is_empty() {
            unfinished.sort_unstable();
            return Err(RolloutError::Cancelled { unfinished, batch });
        }
        Ok(self.bad.into_result(batch)?)
    }
}

/// A bit for each bad state, and whether all reached the end.
fn advance<T: BatchFloat>(
    block: &mut BlockMemory,
    model: &Model,
    (rollout, stages): (&Rollout, &[Stage]),
    torques: Torques<'_, T>,
    job: Job<'_, T>,
    shared: &Shared<'_>,
) -> (u32, bool) {
    let (mut bad, mut finished) = (0, false);
    let outputs = (&mut bad, &mut finished);
    block::run(block, Advance { model, rollout, stages, torques, job, shared, outputs });
    (bad, finished)
}
