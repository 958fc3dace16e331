//! Control of a frame's position through its operational-space inertia.

use super::operational_space;
use crate::constraint::ClosureRow;
use crate::{
    Controller, FrameId, Model, Workspace, bias, frame_pose, frame_velocity_world_aligned, mass_matrix,
};

/// Where a frame's origin should be at a time, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskReference {
    /// x\* \[m\].
    pub position: [f64; 3],
    /// ẋ\* \[m/s\].
    pub velocity: [f64; 3],
    /// ẍ\* \[m/s²\].
    pub acceleration: [f64; 3],
}

/// τ = Jᵀ(Λ (ẍ\* + kp (x\* − x) + kd (ẋ\* − ẋ)) + μ + p) + (1 − JᵀJ̄ᵀ)(C v + g − kn M v) for a frame's position.
///
/// The position obeys ë + kd ė + kp e = 0; what the frame does not feel is damped with kn. Where the frame cannot
/// accelerate in every direction, the torque is not finite, which a run reports.
#[derive(Clone, Debug)]
pub struct TaskControl<'a, F> {
    /// The robot.
    pub model: &'a Model,
    /// Scratch.
    pub workspace: Workspace,
    /// The frame.
    pub frame: FrameId,
    /// Where it should be.
    pub reference: F,
    /// kp \[1/s²\].
    pub stiffness: f64,
    /// kd \[1/s\].
    pub damping: f64,
    /// kn \[1/s\].
    pub null_damping: f64,
}

impl<F: FnMut(f64) -> TaskReference> Controller for TaskControl<'_, F> {
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) {
        const ROWS: [ClosureRow; 3] = [ClosureRow::X, ClosureRow::Y, ClosureRow::Z];
        let Self { model, workspace, frame, .. } = self;
        let wanted = (self.reference)(t);
        let Ok(space) = operational_space(model, workspace, q, v, *frame, &ROWS) else {
            tau.fill(f64::NAN);
            return;
        };
        let x = frame_pose(model, workspace, q, *frame).translation;
        let rate = frame_velocity_world_aligned(model, workspace, q, v, *frame).linear;
        let acceleration: [f64; 3] = core::array::from_fn(|k| {
            wanted.acceleration[k]
                + self.stiffness * (wanted.position[k] - x[k])
                + self.damping * (wanted.velocity[k] - rate[k])
        });
        let nv = model.nv();
        let (mut rest, mut mass) = (vec![0.0; nv], vec![0.0; nv * nv]);
        bias(model, workspace, q, v, &mut rest);
        mass_matrix(model, workspace, q, &mut mass);
        for (rest, row) in rest.iter_mut().zip(mass.chunks_exact(nv)) {
            *rest -= self.null_damping * row.iter().zip(v).map(|(m, v)| m * v).sum::<f64>();
        }
        let total = space.torque(&acceleration) + space.null_torque(&rest);
        tau.copy_from_slice(total.as_slice());
    }
}
