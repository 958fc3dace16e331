//! The pullback of rollouts of batches.

mod backward_pass;
mod inputs;
#[cfg(feature = "native")]
mod machine_code;

use robot_dynamics_core::{Model, parameter_count};
use robot_dynamics_integrators::StepScheme;
use robot_dynamics_number::{Float, check_positive};
use robot_dynamics_simulation::Rollout;

use self::backward_pass::Backward;
pub use self::inputs::RolloutPullbackInputs;
#[cfg(feature = "native")]
use self::machine_code::pull_back_natively;
use super::error::RolloutError;
use super::outcome::StateOutcomes;
use super::progress::{RolloutObserver, SharedProgress};
use super::torques::Torques;
use crate::distribution::for_each_block;
use crate::machine_code::Number;
use crate::tables::check_table;
use crate::{BatchWorkspace, block};

/// The implementation of [`rollout_pullback`](super::rollout_pullback), compiled in this crate.
#[track_caller]
pub(crate) fn compute<T: Float + Number>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    rollout: &Rollout,
    given: &RolloutPullbackInputs<'_, T>,
    results: [&mut [T]; 4],
    progress: RolloutObserver<'_>,
) -> Result<(), RolloutError> {
    workspace.check(model);
    let (h, nq, nv, integrator) = (rollout.step, model.nq, model.nv, rollout.integrator);
    check_positive("the step", h, "s")?;
    let StepScheme::Explicit(stages) = integrator.scheme() else {
        return Err(RolloutError::Implicit { integrator });
    };
    let RolloutPullbackInputs { torques, q, v, trajectory, .. } = *given;
    assert!(q.len().is_multiple_of(nq.max(1)), "q has {} numbers, not a multiple of nq = {nq}", q.len());
    let batch = q.len() / nq.max(1);
    check_table("v", v.len(), batch, nv);
    check_table(
        "the cotangent of the trajectory's q",
        trajectory.by_position.len(),
        batch,
        rollout.samples() * nv,
    );
    check_table(
        "the cotangent of the trajectory's v",
        trajectory.by_velocity.len(),
        batch,
        rollout.samples() * nv,
    );
    let force_width = match torques {
        Torques::Zero => 0,
        Torques::Held(tau) => {
            check_table("tau", tau.len(), batch, nv);
            nv
        }
        Torques::EachStep(tau) => {
            check_table("tau", tau.len(), batch, rollout.steps * nv);
            rollout.steps * nv
        }
        Torques::Policy(_) => return Err(RolloutError::Policy),
    };
    check_table("the cotangent of q", results[0].len(), batch, nv);
    check_table("the cotangent of v", results[1].len(), batch, nv);
    check_table("the cotangent of tau", results[2].len(), batch, force_width);
    let parameters = if results[3].is_empty() { 0 } else { parameter_count(model) };
    check_table("the parameters", results[3].len(), batch, parameters);
    if batch == 0 || nv == 0 {
        return Ok(());
    }
    let shared = SharedProgress::new(progress, batch as u64 * rollout.steps as u64);
    let outcome = StateOutcomes::default();
    let spacing = rollout.spacing(given.spacing);
    #[cfg(feature = "native")]
    let results = {
        let (way, how) = ((rollout, stages, spacing), (&shared, &outcome));
        match pull_back_natively(model, workspace, way, given, results, how) {
            Ok(()) => return outcome.into_result(batch),
            Err(results) => results,
        }
    };
    for_each_block(workspace, batch, 1, results, &|block, first, states, results| {
        let (mut bits, mut finished) = (0, false);
        if !shared.is_cancelled() {
            let outputs = (&mut bits, &mut finished);
            let (stages, shared) = ((stages, spacing), &shared);
            block::run(
                block,
                Backward { model, rollout, stages, given, first, states, results, shared, outputs },
            );
        }
        outcome.add(bits, finished, first..first + states);
    });
    outcome.into_result(batch)
}
