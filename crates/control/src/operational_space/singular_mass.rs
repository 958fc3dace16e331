//! The error for an M that could not be factored.

use robot_dynamics_core::{Model, MotionError};

/// The error for an M that could not be factored.
pub(super) fn singular_mass(model: &Model, q: &[f64]) -> MotionError {
    let overflow = MotionError::Overflow { quantity: "M⁻¹", value: f64::INFINITY };
    model.inverse_mass_matrix(q).err().unwrap_or(overflow)
}
