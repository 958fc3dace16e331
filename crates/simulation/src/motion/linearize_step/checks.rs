//! The checks of the input of a linearized step.

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;
use robot_dynamics_number::check_finite;

use super::results::LinearizedStep;
use crate::motion::RobotState;
use crate::motion::integrate::check_step;
use crate::{StepError, StepForces};

/// Checks the arguments of a linearized step.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub(super) fn check_inputs(
    model: &Model,
    forces: &StepForces<'_>,
    h: f64,
    RobotState { q, v }: RobotState<'_>,
    LinearizedStep { by_state, by_force }: &LinearizedStep<'_>,
) -> Result<(), StepError> {
    let nv = model.nv();
    check_step(h)?;
    check_length("q", q.len(), model.nq());
    check_length("v", v.len(), nv);
    check_length("tau", forces.tau.len(), nv);
    check_length("A", by_state.len(), 4 * nv * nv);
    check_length("B", by_force.len(), 2 * nv * nv);
    for (quantity, values) in [("q", q), ("v", v), ("tau", forces.tau)] {
        check_finite(quantity, values)?;
    }
    Ok(())
}
