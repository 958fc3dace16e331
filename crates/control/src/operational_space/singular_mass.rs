//! The error for an M that could not be factored.

use robot_dynamics_core::Model;
use robot_dynamics_number::{InputProblem, InvalidInput};
use robot_dynamics_simulation::ControllerError;

/// The error for an M that could not be factored.
pub(super) fn singular_mass(model: &Model, q: &[f64]) -> ControllerError {
    let overflow = || InvalidInput::new("M⁻¹", InputProblem::Overflow { value: f64::INFINITY }).into();
    model.inverse_mass_matrix(q).err().unwrap_or_else(overflow).into()
}
