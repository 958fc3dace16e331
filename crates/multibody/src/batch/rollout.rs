//! Motion in time of batches.

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

use dynamics::{Integrator, Method, Stage};
use thiserror::Error;

use self::step::Advance;
use super::bad_states::Found;
use super::block;
use super::compiled_once::{Motion, Progress};
use super::compute::{check_table, check_workspace};
use super::native::Number;
use super::share::for_each_block;
use super::workspace::BlockMemory;
use super::{BadStates, BatchFloat, BatchWorkspace};
use crate::Model;
use crate::motion::integrate::explicit::explicit_names;
pub use crate::motion::pullback::Rollout;

/// How far a rollout is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RolloutProgress {
    /// Steps done, over all states.
    pub done: u64,
    /// Steps to do, over all states.
    pub total: u64,
}

impl RolloutProgress {
    /// So many steps of so many, over all states: for who moves states elsewhere.
    ///
    /// ```
    /// assert_eq!(multibody::batch::RolloutProgress::new(64, 1000).done, 64);
    /// ```
    pub const fn new(done: u64, total: u64) -> Self {
        Self { done, total }
    }
}

/// Why some states have not come to the end of a rollout.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RolloutError {
    /// Some states went wrong on the way; all others are valid.
    #[error(transparent)]
    BadStates(#[from] BadStates),
    /// The progress callback said so.
    #[error("the rollout was cancelled: {} of {batch} states are as they were", .unfinished.len())]
    Cancelled {
        /// States that are as they were, ascending; all others have come to the end.
        unfinished: Vec<usize>,
        /// States in the batch.
        batch: usize,
    },
    /// A step that is not positive and finite.
    #[error("the step must be positive and finite, got {step} s")]
    BadStep {
        /// The step given \[s\].
        step: f64,
    },
    /// The row solves an equation at each step.
    #[error(
        "{integrator} solves an equation at each step; batches move by explicit rows: {}",
        explicit_names()
    )]
    Implicit {
        /// The one asked for.
        integrator: Integrator,
    },
    /// A policy gives the torques of a rollout that is to be pulled back.
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

/// What all threads of a rollout share.
struct Shared<'a> {
    progress: &'a (dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync),
    done: AtomicU64,
    total: u64,
    cancelled: AtomicBool,
}

impl<'a> Shared<'a> {
    /// For one step of one state. Nobody counts its progress.
    #[cfg(feature = "native")]
    fn of_one_step(progress: &'a (dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync)) -> Self {
        Self { progress, done: AtomicU64::new(0), total: 1, cancelled: AtomicBool::new(false) }
    }

    /// Counts steps done; whether to go on.
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

/// Moves each state (q, v) in place over `rollout.steps` steps.
///
/// q is \[batch\]\[nq\], v is \[batch\]\[nv\]. Quaternions stay of unit length: the stages are
/// Munthe-Kaas's, as in [`step`](crate::step). The trajectories take the state after
/// every `stride`-th step: \[batch\]\[samples\]\[nq\] and \[batch\]\[samples\]\[nv\], empty if the stride is 0.
///
/// `progress` is called now and then, from any thread; when it breaks, the states not yet at their end stay
/// as they were, and the trajectories of those are not to be read. For a [policy](Torques::Policy) each
/// call allocates the rows of each block.
///
/// # Errors
/// [`RolloutError`]; all states that it does not name are valid.
///
/// # Panics
/// If a table has the wrong length, or the workspace is for another model.
///
/// ```
/// use dynamics::Integrator;
/// use multibody::batch::{BatchWorkspace, Rollout, Torques, rollout};
/// use multibody::{Model, RandomRobotOptions, neutral, random_robot};
/// use std::ops::ControlFlow;
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let (mut q, mut v) = (neutral(&model).repeat(20), vec![0.0; 20 * model.nv()]);
/// let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 100);
/// let mut workspace = BatchWorkspace::new(&model);
/// let go_on = |_| ControlFlow::Continue(());
/// rollout(&model, &mut workspace, &how, Torques::Zero, &mut q, &mut v, (&mut [], &mut []), &go_on)?;
/// assert!(v.iter().any(|v| v.abs() > 0.1)); // it falls
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

/// [`rollout`], where it is compiled.
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
    let Method::Explicit(stages) = integrator.method() else {
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

/// What became of the states.
#[derive(Default)]
struct Outcome {
    bad: Found,
    unfinished: Mutex<Vec<usize>>,
}

impl Outcome {
    /// A block has come to its end, or was cancelled; the bits are those of its bad states.
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

/// The bits of the bad states, and whether all have come to the end.
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
