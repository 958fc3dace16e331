//! The two Euler steps.

use dynamics::{DynamicsError, check_finite};

use super::{StepForces, StepWorkspace, accelerate};
use crate::{Model, integrate};

/// q₁ = q₀ ⊕ h v₀, v₁ = v₀ + h a(q₀, v₀). **(HLW §I.1.2)**
pub(super) fn explicit_euler(
    model: &Model,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<(), DynamicsError> {
    accelerate(model, workspace, forces, q, v)?;
    move_along(model, workspace, h, q, v);
    accelerated(workspace, h, v);
    arrive(workspace, q, v)
}

/// v₁ = v₀ + h a(q₀, v₀), q₁ = q₀ ⊕ h v₁. **(HLW §I.1.2)**
pub(super) fn semi_implicit_euler(
    model: &Model,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<(), DynamicsError> {
    accelerate(model, workspace, forces, q, v)?;
    accelerated(workspace, h, v);
    let v_end = core::mem::take(&mut workspace.v);
    move_along(model, workspace, h, q, &v_end);
    workspace.v = v_end;
    arrive(workspace, q, v)
}

/// `workspace.q` = q ⊕ h v.
fn move_along(model: &Model, workspace: &mut StepWorkspace, h: f64, q: &[f64], v: &[f64]) {
    let StepWorkspace { displacement, q: moved, .. } = workspace;
    displacement.iter_mut().zip(v).for_each(|(d, v)| *d = h * v);
    integrate(model, q, displacement, moved);
}

/// `workspace.v` = v + h a.
fn accelerated(workspace: &mut StepWorkspace, h: f64, v: &[f64]) {
    workspace.v.copy_from_slice(v);
    add_scaled(&mut workspace.v, h, &workspace.acceleration);
}

/// Writes the end of a step, if it is finite, over its start.
pub(super) fn arrive(workspace: &StepWorkspace, q: &mut [f64], v: &mut [f64]) -> Result<(), DynamicsError> {
    check_finite("v after the step", &workspace.v)?;
    check_finite("q after the step", &workspace.q)?;
    q.copy_from_slice(&workspace.q);
    v.copy_from_slice(&workspace.v);
    Ok(())
}

/// x ← x + k y.
pub(super) fn add_scaled(x: &mut [f64], k: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += k * y);
}
