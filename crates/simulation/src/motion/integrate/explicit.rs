//! Explicit stages on a tree, for one state and for batches, with and without constraints.

use robot_dynamics_core::configuration::displacement_rate::displacement_rate;
use robot_dynamics_core::workspace::native::computed_natively;
use robot_dynamics_core::{Model, NativeFunction, Workspace, integrate};
use robot_dynamics_integrators::{Integrator, IntegratorError, Stage, check_computed};
use robot_dynamics_number::Scalar;

use super::forces::{StepForces, accelerate};
use super::stage_memory::StageMemory;
use super::vectors::{scale, start_from, sum_stages};
use super::workspace::StepWorkspace;

/// The system that the stages integrate.
pub trait StageSystem<S: Scalar> {
    /// The error of an acceleration.
    type Error;

    /// `moved` = q ⊕ δ.
    fn move_along(&self, q: &[S], displacement: &[S], moved: &mut [S]);

    /// v̇ at a stage.
    fn accelerate(&mut self, q: &[S], v: &[S], acceleration: &mut [S]) -> Result<(), Self::Error>;
}

/// The names of the rows with explicit stages, for messages.
pub fn explicit_names() -> String {
    let names: Vec<_> =
        Integrator::ALL.into_iter().filter(|row| row.is_explicit()).map(Integrator::name).collect();
    names.join(", ")
}

/// Takes a step from (q, v) over h, and writes the end to `memory.q` and `memory.v`. See [`Stage`]. On joints
/// with quaternions these are the methods of Munthe-Kaas, with stages in exponential coordinates Θ. **(HLW
/// §IV.8)**
#[inline(always)]
pub fn explicit_step<S: Scalar, M: StageSystem<S>>(
    model: &Model,
    stages: &[Stage],
    motion: &mut M,
    h: S,
    memory: &mut StageMemory<'_, S>,
    (q, v): (&[S], &[S]),
) -> Result<(), M::Error> {
    let nv = model.nv;
    let StageMemory { q: q_stage, v: v_stage, displacement, rates, accelerations } = memory;
    for (i, stage) in stages.iter().enumerate() {
        let stays = stage.q_row.is_empty();
        if stage.v_row.is_empty() {
            v_stage.copy_from_slice(v);
        } else {
            sum_stages(stage.v_row.len(), |j| stage.v_row[j], accelerations, v_stage);
            start_from(v, h, v_stage);
        }
        if !stays {
            sum_stages(stage.q_row.len(), |j| stage.q_row[j], rates, displacement);
            scale(h, displacement);
        }
        if Stage::needs_acceleration(stages, i) {
            if stays {
                q_stage.copy_from_slice(q);
            } else {
                motion.move_along(q, displacement, q_stage);
            }
            motion.accelerate(q_stage, v_stage, &mut accelerations[i * nv..(i + 1) * nv])?;
        }
        if Stage::needs_rate(stages, i) {
            let rate = &mut rates[i * nv..(i + 1) * nv];
            if stays {
                // Θ = 0.
                rate.copy_from_slice(v_stage);
            } else {
                displacement_rate(model, displacement, v_stage, rate);
            }
        }
    }
    sum_stages(stages.len(), |j| stages[j].v_weight, accelerations, v_stage);
    start_from(v, h, v_stage);
    sum_stages(stages.len(), |j| stages[j].q_weight, rates, displacement);
    scale(h, displacement);
    motion.move_along(q, displacement, q_stage);
    Ok(())
}

/// A tree under constant forces.
struct TreeUnderForces<'a> {
    model: &'a Model,
    workspace: &'a mut Workspace,
    /// τ − b(v).
    force: &'a mut [f64],
    forces: &'a StepForces<'a>,
}

impl StageSystem<f64> for TreeUnderForces<'_> {
    type Error = IntegratorError;

    fn move_along(&self, q: &[f64], displacement: &[f64], moved: &mut [f64]) {
        integrate(self.model, q, displacement, moved);
    }

    fn accelerate(&mut self, q: &[f64], v: &[f64], acceleration: &mut [f64]) -> Result<(), IntegratorError> {
        accelerate(self.model, self.workspace, self.forces, self.force, (q, v), acceleration)
    }
}

/// A step of a row with explicit stages.
pub(super) fn step(
    model: &Model,
    workspace: &mut StepWorkspace,
    (row, stages): (Integrator, &[Stage]),
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<(), IntegratorError> {
    let StepWorkspace { dynamics, force, stages: memory, .. } = workspace;
    let mut memory = StageMemory::new(model, stages.len(), memory);
    if let Some(function) = NativeFunction::step(row, forces.dissipation) {
        let (native, ends) = (&mut dynamics.tree.native, &mut [&mut *memory.q, &mut *memory.v]);
        // If a result is not finite, the stages determine the first such number.
        if computed_natively(model, native, function, &[q, v, forces.tau, &[h]], ends)
            && memory.q.iter().chain(&*memory.v).all(|x| x.is_finite())
        {
            q.copy_from_slice(memory.q);
            v.copy_from_slice(memory.v);
            return Ok(());
        }
    }
    let mut motion = TreeUnderForces { model, workspace: dynamics, force, forces };
    advance(model, stages, &mut motion, h, &mut memory, (q, v))
}

/// [`explicit_step`] in place; on an error, or if a result is not finite, (q, v) are unchanged.
pub fn advance(
    model: &Model,
    stages: &[Stage],
    motion: &mut impl StageSystem<f64, Error = IntegratorError>,
    h: f64,
    memory: &mut StageMemory<'_, f64>,
    (q, v): (&mut [f64], &mut [f64]),
) -> Result<(), IntegratorError> {
    explicit_step(model, stages, motion, h, memory, (q, v))?;
    check_computed("v after the step", memory.v)?;
    check_computed("q after the step", memory.q)?;
    q.copy_from_slice(memory.q);
    v.copy_from_slice(memory.v);
    Ok(())
}
