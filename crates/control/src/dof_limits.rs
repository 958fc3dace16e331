//! The checks of limits by degree of freedom.

use robot_dynamics_core::{Model, check_vector};
use robot_dynamics_number::InvalidInput;

/// Checks named limits of magnitudes, nv entries each, and limits of positions: lengths, signs and order.
pub(crate) fn check_dof_limits(
    model: &Model,
    magnitudes: &[(&str, &[f64])],
    position: &[[f64; 2]],
) -> Result<(), InvalidInput> {
    for &(name, limits) in magnitudes {
        if let Some(bad) = limits.iter().find(|limit| limit.is_nan() || **limit < 0.0) {
            return Err(InvalidInput::out_of_range(name, *bad, "", "zero or positive"));
        }
        if limits.len() != model.nv() {
            return check_vector(model, name, limits);
        }
    }
    if position.len() != model.nv() {
        return Err(InvalidInput::unmet("the position limits", "must have nv entries"));
    }
    let is_ordered = position.iter().all(|[lower, upper]| lower <= upper);
    if is_ordered { Ok(()) } else { Err(InvalidInput::unmet("the position limits", "must be ordered")) }
}
