//! Simulations of a batch whose robots or grounds differ.

use pyo3::prelude::*;
use robot_dynamics::simulation::Simulation as Single;

use crate::errors::Class;

/// Refuses simulations of which the states or controls differ in their meaning.
pub(super) fn check_alike(py: Python<'_>, kinds: &[Single]) -> PyResult<()> {
    let joints =
        |own: &Single| own.model().joints().iter().map(|j| (j.name.clone(), j.nq, j.nv)).collect::<Vec<_>>();
    let [first, others @ ..] = kinds else { return Ok(()) };
    for (k, other) in others.iter().enumerate() {
        if joints(first) != joints(other) || !first.control_names().eq(other.control_names()) {
            let names = (other.model().name(), k + 1, first.model().name());
            return Err(Class::SimulationInput.error(
                py,
                format!(
                    "robot `{}` of variant {} has other joints or actuators than robot `{}` of variant 0",
                    names.0, names.1, names.2
                ),
            ));
        }
    }
    Ok(())
}
