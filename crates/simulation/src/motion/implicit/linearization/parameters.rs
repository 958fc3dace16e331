//! The derivatives of forces by controls and by inertial parameters.
//!
//! Inverse dynamics is linear in the inertial parameters π: M a + C v + g = Y(q, v, a) π. So
//! ∂(M a + C v + g)/∂π = Y(q, v, a), and ∂(M x)/∂π = Y(q, 0, x) − Y(q, 0, 0).

use robot_dynamics_core::{Model, Workspace, joint_torque_regressor};

use super::super::ImplicitIntegrator;
use super::columns::Columns;

impl ImplicitIntegrator {
    /// ∂f/∂u of the forces of actuators at (q, v), nv×nu. At a bound it is that of larger controls, and the
    /// result says so.
    pub(super) fn forces_by_controls(
        &mut self,
        model: &Model,
        columns: &Columns,
        (q, v): (&[f64], &[f64]),
    ) -> (Vec<f64>, bool) {
        let mut by = vec![0.0; v.len() * columns.controls];
        let Some(drive) = self.drive.as_mut().filter(|_| columns.controls > 0) else { return (by, false) };
        let is_at_bound = drive.derivatives_by_control(model, (q, v), &mut by);
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
