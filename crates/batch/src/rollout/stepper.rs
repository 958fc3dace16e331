//! Rollouts of batches by any stepper, state by state: stiff joints, stops, friction and contact.

use robot_dynamics_core::Model;
use robot_dynamics_number::check_positive;
use robot_dynamics_simulation::{StepForces, StepWorkspace, Stepper, StepperRollout};

use super::error::RolloutError;
use super::outcome::StateOutcomes;
use super::progress::{RolloutObserver, SharedProgress, UNOBSERVED};
use super::states::RolloutStates;
use super::torques::Torques;
use crate::BatchWorkspace;
use crate::distribution::for_each_state;
use crate::tables::check_table;

/// The number of steps of one state between checks of the progress.
const STEPS_PER_LOOK: usize = 64;

/// [`rollout`](super::rollout) by any [`Stepper`], with contacts and actuators, such as that of a simulation
/// ([`Simulation::stepper`](robot_dynamics_simulation::simulator::Simulation::stepper)). Each thread advances
/// one state at a time in scalar code.
///
/// Shapes, progress and cancellation are those of [`rollout`](super::rollout). Each state has its own copy of
/// the stepper, so the results are the same bits for any number of threads. Each call allocates the copies
/// and the threads' memory.
///
/// ```
/// use robot_dynamics::batch::{BatchWorkspace, RolloutStates, StepperRollout, Torques, rollout_by_stepper};
/// use robot_dynamics::contact::Ground;
/// use robot_dynamics::description::{Base, LinkDescription, LinkShape, MassProperties, Pose};
/// use robot_dynamics::description::{RobotDescription, Shape, ShapeRole};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::SimulationBuilder;
/// let mut robot = RobotDescription::new("brick");
/// robot.base = Base::Floating;
/// let brick = MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
/// robot.links.push(LinkDescription::new("brick", brick));
/// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
/// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
/// let model = Model::new(robot)?;
/// let stepper = SimulationBuilder::new(&model).ground(Ground::level(0.0)).build()?.stepper();
/// // Drop ten bricks flat from 5 to 14 cm.
/// let mut q: Vec<f64> = (5..15).flat_map(|cm| [0.0, 0.0, 0.05 + 0.01 * f64::from(cm), 0.0, 0.0, 0.0, 1.0]).collect();
/// let mut v = vec![0.0; 60];
/// let second = StepperRollout::new(&stepper, 1e-3, 1000);
/// let workspace = BatchWorkspace::new(&model);
/// let states = RolloutStates::ends(&mut q, &mut v);
/// rollout_by_stepper(&model, &workspace, &second, Torques::Zero, states, None)?;
/// assert!(q.chunks(7).all(|q| (q[2] - 0.05).abs() < 1e-6)); // all are at rest on the ground
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`RolloutError`]; all states that it does not list are valid. A state whose step fails for any reason is a
/// bad state.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn rollout_by_stepper<S: Stepper + Clone + Sync>(
    model: &Model,
    workspace: &BatchWorkspace<f64>,
    rollout: &StepperRollout<'_, S>,
    torques: Torques<'_, f64>,
    states: RolloutStates<'_, f64>,
    progress: Option<RolloutObserver<'_>>,
) -> Result<(), RolloutError> {
    let RolloutStates { q, v, q_trajectory, v_trajectory } = states;
    let progress = progress.unwrap_or(UNOBSERVED);
    workspace.check(model);
    let (h, nq, nv) = (rollout.step, model.nq(), model.nv());
    check_positive("the step", h, "s")?;
    assert!(q.len().is_multiple_of(nq.max(1)), "q has {} numbers, not a multiple of nq = {nq}", q.len());
    let batch = q.len() / nq.max(1);
    check_table("v", v.len(), batch, nv);
    check_table("the trajectory of q", q_trajectory.len(), batch, rollout.samples() * nq);
    check_table("the trajectory of v", v_trajectory.len(), batch, rollout.samples() * nv);
    torques.check(batch, rollout.steps, nv);
    let shared = SharedProgress::new(progress, batch as u64 * rollout.steps as u64);
    let outcome = StateOutcomes::default();
    for_each_state(
        workspace,
        batch,
        [q, v, q_trajectory, v_trajectory],
        &|| StepperMemory {
            workspace: StepWorkspace::new(model),
            tau: vec![0.0; nv],
            start: vec![0.0; nq + nv],
        },
        &|mover: &mut StepperMemory, state, tables| {
            let finished = !shared.is_cancelled();
            let moved = if finished {
                mover.advance_state(model, rollout, torques, (state, tables), &shared)
            } else {
                None
            };
            outcome.add(u32::from(moved == Some(false)), moved.is_some(), state..state + 1);
        },
    );
    outcome.into_result(batch)
}

/// The memory of a thread.
struct StepperMemory {
    workspace: StepWorkspace,
    tau: Vec<f64>,
    /// The initial q and v.
    start: Vec<f64>,
}

impl StepperMemory {
    /// Whether the state reached the end (true) or failed (false); `None` if it was cancelled.
    fn advance_state<S: Stepper + Clone>(
        &mut self,
        model: &Model,
        rollout: &StepperRollout<'_, S>,
        torques: Torques<'_, f64>,
        (state, [q, v, q_trajectory, v_trajectory]): (usize, [&mut [f64]; 4]),
        shared: &SharedProgress<'_>,
    ) -> Option<bool> {
        let Self { workspace, tau, start } = self;
        let (nq, nv, h) = (q.len(), v.len(), rollout.step);
        start[..nq].copy_from_slice(q);
        start[nq..].copy_from_slice(v);
        let is_finite = |q: &[f64], v: &[f64]| q.iter().chain(v).all(|x| x.is_finite());
        let mut stepper = rollout.stepper.clone();
        let mut is_good =
            is_finite(q, v) && stepper.check_start(model, workspace.dynamics(), h, q, v).is_ok();
        tau.fill(0.0);
        let mut looked = 0;
        for step in 0..rollout.steps {
            if step - looked == STEPS_PER_LOOK {
                looked = step;
                if !shared.go_on(STEPS_PER_LOOK as u64) {
                    q.copy_from_slice(&start[..nq]);
                    v.copy_from_slice(&start[nq..]);
                    return None;
                }
            }
            is_good = is_good && {
                torques.at(state, (step, rollout.steps), h, (q, v), tau);
                let forces = StepForces::new(tau, rollout.dissipation);
                if rollout.restarts {
                    stepper.clone_from(rollout.stepper);
                }
                tau.iter().all(|x| x.is_finite())
                    && stepper.check_mass(model, workspace.dynamics(), q).is_ok()
                    && stepper.step(model, workspace, &forces, h, q, v).is_ok()
                    && is_finite(q, v)
            };
            if !is_good {
                q.fill(f64::NAN);
                v.fill(f64::NAN);
            }
            if rollout.stride > 0 && (step + 1) % rollout.stride == 0 {
                let sample = (step + 1) / rollout.stride - 1;
                q_trajectory[sample * nq..(sample + 1) * nq].copy_from_slice(q);
                v_trajectory[sample * nv..(sample + 1) * nv].copy_from_slice(v);
            }
        }
        shared.go_on((rollout.steps - looked) as u64);
        Some(is_good)
    }
}
