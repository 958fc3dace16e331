//! The steps of all states of a rollout.

use robot_dynamics_core::Model;
use robot_dynamics_integrators::{Stage, StepScheme};
use robot_dynamics_number::{Float, check_positive};
use robot_dynamics_simulation::Rollout;

use super::error::RolloutError;
use super::job::Job;
#[cfg(feature = "native")]
use super::machine_code::move_natively;
use super::outcome::StateOutcomes;
use super::progress::{RolloutObserver, SharedProgress};
use super::step::BlockRollout;
use super::torques::Torques;
use crate::distribution::for_each_block;
use crate::machine_code::Number;
use crate::tables::check_table;
use crate::workspace::BlockMemory;
use crate::{BadStates, BatchWorkspace, block};

/// The states of a rollout: the start, replaced by the end, and the samples on the way.
///
/// `q` is \[batch\]\[nq\] and `v` is \[batch\]\[nv\]. The trajectories receive the state after every
/// `stride`-th step, \[batch\]\[samples\]\[nq\] and \[batch\]\[samples\]\[nv\]; they are empty if the
/// stride is 0.
#[derive(Debug)]
pub struct RolloutStates<'a, T> {
    /// The configurations.
    pub q: &'a mut [T],
    /// The velocities.
    pub v: &'a mut [T],
    /// The configurations after every `stride`-th step.
    pub q_trajectory: &'a mut [T],
    /// The velocities after every `stride`-th step.
    pub v_trajectory: &'a mut [T],
}

impl<'a, T> RolloutStates<'a, T> {
    /// Without trajectories.
    pub fn ends(q: &'a mut [T], v: &'a mut [T]) -> Self {
        Self { q, v, q_trajectory: &mut [], v_trajectory: &mut [] }
    }
}

/// Advances each state in place: the implementation of [`rollout`](super::rollout), compiled in this crate.
#[track_caller]
pub(crate) fn move_states<T: Float + Number>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    rollout: &Rollout,
    torques: Torques<'_, T>,
    RolloutStates { q, v, q_trajectory, v_trajectory }: RolloutStates<'_, T>,
    progress: RolloutObserver<'_>,
) -> Result<(), RolloutError> {
    workspace.check(model);
    let (h, nq, nv) = (rollout.step, model.nq, model.nv);
    check_positive("the step", h, "s")?;
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
    let shared = SharedProgress::new(progress, batch as u64 * rollout.steps as u64);
    let outcome = StateOutcomes::default();
    let tables = [q, v, q_trajectory, v_trajectory];
    #[cfg(feature = "native")]
    let tables = {
        let how = (&shared, &outcome);
        match move_natively(model, workspace, (rollout, stages), torques, tables, how) {
            Ok(()) => return outcome.into_result(batch),
            Err(tables) => tables,
        }
    };
    for_each_block(workspace, batch, 1, tables, &|block, first, states, tables| {
        let [q, v, q_trajectory, v_trajectory] = tables;
        let job = Job { first, states, q, v, q_trajectory, v_trajectory };
        let (mut bits, mut finished) = (0, false);
        if !shared.is_cancelled() {
            (bits, finished) = advance(block, model, (rollout, stages), torques, job, &shared);
        }
        outcome.add(bits, finished, first..first + states);
    });
    outcome.into_result(batch)
}

/// A bit for each bad state, and whether all reached the end.
fn advance<T: Float>(
    block: &mut BlockMemory,
    model: &Model,
    (rollout, stages): (&Rollout, &[Stage]),
    torques: Torques<'_, T>,
    job: Job<'_, T>,
    shared: &SharedProgress<'_>,
) -> (u32, bool) {
    let (mut bad, mut finished) = (0, false);
    let outputs = (&mut bad, &mut finished);
    block::run(block, BlockRollout { model, rollout, stages, torques, job, shared, outputs });
    (bad, finished)
}
