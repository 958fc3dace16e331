//! The derivatives of forces by controls and by inertial parameters.
//!
//! Inverse dynamics is linear in the inertial parameters π: M a + C v + g = Y(q, v, a) π. So
//! ∂(M a + C v + g)/∂π = Y(q, v, a), and ∂(M x)/∂π = Y(q, 0, x) − Y(q, 0, 0).

use robot_dynamics_core::{Model, Workspace, joint_torque_regressor};

use super::super::ImplicitIntegrator;
use super::columns::Columns;

/// The increment of a control, relative to its size or to 1. The forces of actuators are linear in their
/// controls, or smooth as those of muscles.
const MOVE: f64 = 1e-6;

/// One-sided derivatives by a control that differ by more than this fraction belong to a bound of the control
/// or of a force.
const KINK: f64 = 1e-3;

impl ImplicitIntegrator {
    /// ∂f/∂u of the forces of actuators at (q, v), nv×nu. At a bound it is that of larger controls, and the
    /// result says so.
    pub(super) fn forces_by_controls(
        &mut self,
        model: &Model,
        columns: &Columns,
        (q, v): (&[f64], &[f64]),
    ) -> (Vec<f64>, bool) {
        let (nv, count) = (v.len(), columns.controls);
        let (mut by, mut is_at_bound) = (vec![0.0; nv * count], false);
        let Some(drive) = self.drive.as_mut().filter(|_| count > 0) else { return (by, false) };
        let [mut after, mut middle, mut before] = [(); 3].map(|()| vec![0.0; nv]);
        drive.forces(model, q, v, &mut middle);
        for k in 0..count {
            let control = drive.controls()[k];
            let step = MOVE * control.abs().max(1.0);
            drive.controls()[k] = control + step;
            drive.forces(model, q, v, &mut after);
            drive.controls()[k] = control - step;
            drive.forces(model, q, v, &mut before);
            drive.controls()[k] = control;
            for i in 0..nv {
                let [up, down] = [after[i] - middle[i], middle[i] - before[i]].map(|force| force / step);
                let is_kink = (up - down).abs() > KINK * up.abs().max(down.abs()).max(MOVE);
                is_at_bound |= is_kink;
                by[i * count + k] = if is_kink { up } else { 0.5 * (up + down) };
            }
        }
        (by, is_at_bound)
    }
}

/// Y(q, v, a), nv × 10·links; empty without inertial parameters.
pub(super) fn regressor(
    model: &Model,
    workspace: &mut Workspace,
    columns: &Columns,
    [q, v, a]: [&[f64]; 3],
) -> Vec<f64> {
    let mut regressor = vec![0.0; model.nv * columns.inertial];
    if columns.inertial > 0 {
        joint_torque_regressor(model, workspace, q, v, a, &mut regressor);
    }
    regressor
}

/// ∂(M(q) x)/∂π, nv × 10·links; empty without inertial parameters.
pub(super) fn inertia_regressor(
    model: &Model,
    workspace: &mut Workspace,
    columns: &Columns,
    (q, x): (&[f64], &[f64]),
) -> Vec<f64> {
    let still = vec![0.0; x.len()];
    let mut moved = regressor(model, workspace, columns, [q, &still, x]);
    let held = regressor(model, workspace, columns, [q, &still, &still]);
    moved.iter_mut().zip(&held).for_each(|(moved, held)| *moved -= held);
    moved
}
