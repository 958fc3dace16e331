//! Motion in time of batches by any stepper, state by state: stiff joints, stops, friction and contact.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::{Outcome, RolloutError, Shared, Torques};
use crate::batch::BatchWorkspace;
use crate::batch::compiled_once::Progress;
use crate::batch::compute::{check_table, check_workspace};
use crate::batch::share::for_each_state;
use crate::{Model, StepForces, StepWorkspace, Stepper};

/// Steps of one state between two looks at the progress.
const STEPS_PER_LOOK: usize = 64;

/// How states move by a [`Stepper`].
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct StepperRollout<'a, S> {
    /// Each state's begins as a copy of this one.
    pub stepper: &'a S,
    /// One step \[s\].
    pub step: f64,
    /// How many steps.
    pub steps: usize,
    /// Whether the joints' damping and friction act.
    pub dissipation: bool,
    /// Every how many-th step goes into the trajectory; 0 for none.
    pub stride: usize,
}

impl<'a, S> StepperRollout<'a, S> {
    /// So many steps of that length \[s\], damping and friction acting, without a trajectory.
    pub const fn new(stepper: &'a S, step: f64, steps: usize) -> Self {
        Self { stepper, step, steps, dissipation: true, stride: 0 }
    }

    /// Whether the joints' damping and friction act.
    pub const fn with_dissipation(self, dissipation: bool) -> Self {
        Self { dissipation, ..self }
    }

    /// With every `stride`-th step in the trajectory; 0 for none.
    pub const fn with_stride(self, stride: usize) -> Self {
        Self { stride, ..self }
    }

    /// States of one trajectory: those after every `stride`-th step.
    pub fn samples(&self) -> usize {
        self.steps.checked_div(self.stride).unwrap_or(0)
    }
}

/// [`rollout`](super::rollout) by any [`Stepper`], such as that of a simulation ([`Simulation::stepper`](crate::simulator::Simulation::stepper)),
/// with contacts and actuators: one state after the other on each thread, in scalar code.
///
/// Shapes, progress and cancelling are those of [`rollout`](super::rollout). Each state is moved by a copy of the stepper and by
/// nothing of the others, so that the results are the same bits for any number of threads. Copies and the threads' memory are allocated in
/// each call.
///
/// ```
/// use dynamics::MassProperties;
/// use multibody::batch::{BatchWorkspace, StepperRollout, Torques, rollout_by_stepper};
/// use multibody::simulator::SimulationBuilder;
/// use multibody::{Base, Ground, LinkDescription, LinkShape, Model, Pose, RobotDescription, Shape};
/// use multibody::ShapeRole;
/// use std::ops::ControlFlow;
/// let mut robot = RobotDescription::new("brick");
/// robot.base = Base::Floating;
/// let brick = MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
/// robot.links.push(LinkDescription::new("brick", brick));
/// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
/// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
/// let model = Model::new(robot)?;
/// let stepper = SimulationBuilder::new(&model).ground(Ground::level(0.0)).build()?.stepper();
/// // Ten bricks, dropped flat from 5 to 14 cm.
/// let mut q: Vec<f64> = (5..15).flat_map(|cm| [0.0, 0.0, 0.05 + 0.01 * f64::from(cm), 0.0, 0.0, 0.0, 1.0]).collect();
/// let mut v = vec![0.0; 60];
/// let second = StepperRollout::new(&stepper, 1e-3, 1000);
/// let go_on = |_| ControlFlow::Continue(());
/// let workspace = BatchWorkspace::new(&model);
/// rollout_by_stepper(&model, &workspace, &second, Torques::Zero, &mut q, &mut v, (&mut [], &mut []), &go_on)?;
/// assert!(q.chunks(7).all(|q| (q[2] - 0.05).abs() < 1e-6)); // all lie on the ground
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`RolloutError`]; all states that it does not name are valid. A state whose step fails, for whatever reason, is a bad one.
///
/// # Panics
/// If a table has the wrong length, or the workspace is for another model.
#[allow(clippy::too_many_arguments)] // those of `rollout`
#[track_caller]
pub fn rollout_by_stepper<S: Stepper + Clone + Sync>(
    model: &Model,
    workspace: &BatchWorkspace<f64>,
    rollout: &StepperRollout<'_, S>,
    torques: Torques<'_, f64>,
    q: &mut [f64],
    v: &mut [f64],
    (q_trajectory, v_trajectory): (&mut [f64], &mut [f64]),
    progress: Progress<'_>,
) -> Result<(), RolloutError> {
    check_workspace(model, workspace);
    let (h, nq, nv) = (rollout.step, model.nq(), model.nv());
    if !(h > 0.0 && h.is_finite()) {
        return Err(RolloutError::BadStep { step: h });
    }
    assert!(q.len().is_multiple_of(nq.max(1)), "q has {} numbers, not a multiple of nq = {nq}", q.len());
    let batch = q.len() / nq.max(1);
    check_table("v", v.len(), batch, nv);
    check_table("the trajectory of q", q_trajectory.len(), batch, rollout.samples() * nq);
    check_table("the trajectory of v", v_trajectory.len(), batch, rollout.samples() * nv);
    torques.check(batch, rollout.steps, nv);
    let shared = Shared {
        progress,
        done: AtomicU64::new(0),
        total: batch as u64 * rollout.steps as u64,
        cancelled: AtomicBool::new(false),
    };
    let outcome = Outcome::default();
    for_each_state(
        workspace,
        batch,
        [q, v, q_trajectory, v_trajectory],
        &|| Mover { workspace: StepWorkspace::new(model), tau: vec![0.0; nv], start: vec![0.0; nq + nv] },
        &|mover: &mut Mover, state, tables| {
            let finished = !shared.cancelled.load(Ordering::Relaxed);
            let moved =
                if finished { mover.go(model, rollout, torques, (state, tables), &shared) } else { None };
            outcome.add(u32::from(moved == Some(false)), moved.is_some(), state..state + 1);
        },
    );
    outcome.into_result(batch)
}

/// A thread's memory.
struct Mover {
    workspace: StepWorkspace,
    tau: Vec<f64>,
    /// q and v as they were.
    start: Vec<f64>,
}

impl Mover {
    /// Whether the state came to its end, or went wrong; `None` if it was cancelled.
    fn go<S: Stepper + Clone>(
        &mut self,
        model: &Model,
        rollout: &StepperRollout<'_, S>,
        torques: Torques<'_, f64>,
        (state, [q, v, q_trajectory, v_trajectory]): (usize, [&mut [f64]; 4]),
        shared: &Shared<'_>,
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
