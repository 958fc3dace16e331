//! The two Euler steps.

use dynamics::DynamicsError;

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
    add_scaled(v, h, &workspace.acceleration);
    Ok(())
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
    add_scaled(v, h, &workspace.acceleration);
    move_along(model, workspace, h, q, v);
    Ok(())
}

/// q ← q ⊕ h v.
fn move_along(model: &Model, workspace: &mut StepWorkspace, h: f64, q: &mut [f64], v: &[f64]) {
    let StepWorkspace { displacement, q: moved, .. } = workspace;
    displacement.iter_mut().zip(v).for_each(|(d, v)| *d = h * v);
    integrate(model, q, displacement, moved);
    q.copy_from_slice(moved);
}

/// x ← x + k y.
pub(super) fn add_scaled(x: &mut [f64], k: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += k * y);
}
