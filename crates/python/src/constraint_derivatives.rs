//! Derivatives and pullbacks of constrained motions.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::constraints::{ConstraintError, ConstraintOptions};
use robot_dynamics::derivatives::{
    ConstrainedPullbackInputs, ConstrainedTorquePullbackInputs, ImpulsePullbackInputs,
    constrained_forward_dynamics_derivatives, constrained_forward_dynamics_pullback,
    constrained_inverse_dynamics_derivatives, constrained_inverse_dynamics_pullback,
    contact_impulse_derivatives, contact_impulse_pullback,
};
use robot_dynamics::simulation::Integrator;

use crate::constraint_set::Constraints;
use crate::constraints::{check_actuated, options_of};
use crate::errors::exception_of;
use crate::numbers::{array, array_of, configuration, object, record, shaped, vector, vector_or_zeros};
use crate::robot::Robot;

/// The cotangent of the rows; zeros by default.
fn row_cotangent(
    py: Python<'_>,
    name: &str,
    rows: usize,
    given: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<f64>> {
    match given {
        Some(given) => Ok(shaped(py, name, given, &[rows])?.1),
        None => Ok(vec![0.0; rows]),
    }
}

#[pymethods]
impl Robot {
    /// See `constrained_forward_dynamics_derivatives`.
    fn _constrained_forward_dynamics_derivatives<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        stabilization: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let tau = vector_or_zeros(py, self, "tau", tau)?;
        let options = options_of(Integrator::RungeKutta4, stabilization);
        let by = self
            .with_workspace(|w| {
                constrained_forward_dynamics_derivatives(&self.model, w, set, &options, &q, &v, &tau)
            })
            .map_err(exception_of::<ConstraintError>)?;
        record(
            py,
            [
                ("acceleration", array(py, by.motion.acceleration.as_slice())?),
                ("multipliers", array(py, by.motion.multipliers.as_slice())?),
                ("acceleration_by_position", array_of(py, &by.acceleration_by_position)?),
                ("acceleration_by_velocity", array_of(py, &by.acceleration_by_velocity)?),
                ("acceleration_by_force", array_of(py, &by.acceleration_by_force)?),
                ("multipliers_by_position", array_of(py, &by.multipliers_by_position)?),
                ("multipliers_by_velocity", array_of(py, &by.multipliers_by_velocity)?),
                ("multipliers_by_force", array_of(py, &by.multipliers_by_force)?),
            ],
        )
    }

    /// See `constrained_forward_dynamics_pullback`.
    #[allow(clippy::too_many_arguments)] // those of the Python function
    fn _constrained_forward_dynamics_pullback<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        acceleration: Option<&Bound<'py, PyAny>>,
        multipliers: Option<&Bound<'py, PyAny>>,
        stabilization: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let tau = vector_or_zeros(py, self, "tau", tau)?;
        let acceleration = vector_or_zeros(py, self, "acceleration", acceleration)?;
        let multipliers = row_cotangent(py, "multipliers", set.len(), multipliers)?;
        let options = options_of(Integrator::RungeKutta4, stabilization);
        let inputs = ConstrainedPullbackInputs {
            q: &q,
            v: &v,
            tau: &tau,
            acceleration: &acceleration,
            multipliers: &multipliers,
        };
        let by = self
            .with_workspace(|w| constrained_forward_dynamics_pullback(&self.model, w, set, &options, inputs))
            .map_err(exception_of::<ConstraintError>)?;
        record(
            py,
            [
                ("acceleration", array(py, by.motion.acceleration.as_slice())?),
                ("multipliers", array(py, by.motion.multipliers.as_slice())?),
                ("by_position", array(py, by.by_position.as_slice())?),
                ("by_velocity", array(py, by.by_velocity.as_slice())?),
                ("by_force", array(py, by.by_force.as_slice())?),
                ("by_parameters", array(py, by.parameters.as_slice())?),
            ],
        )
    }

    /// See `constrained_inverse_dynamics_derivatives`.
    fn _constrained_inverse_dynamics_derivatives<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        actuated: Option<Vec<bool>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v, a) = (configuration(py, self, q)?, vector(py, self, "v", v)?, vector(py, self, "a", a)?);
        let actuated = actuated.unwrap_or_else(|| self.model.actuated_dofs().to_vec());
        check_actuated(py, self, &actuated)?;
        let by = self
            .with_workspace(|w| {
                constrained_inverse_dynamics_derivatives(&self.model, w, set, &q, &v, &a, &actuated)
            })
            .map_err(exception_of::<ConstraintError>)?;
        record(
            py,
            [
                ("tau", array(py, by.torque.tau.as_slice())?),
                ("multipliers", array(py, by.torque.multipliers.as_slice())?),
                ("tau_by_position", array_of(py, &by.tau_by_position)?),
                ("tau_by_velocity", array_of(py, &by.tau_by_velocity)?),
                ("tau_by_acceleration", array_of(py, &by.tau_by_acceleration)?),
                ("multipliers_by_position", array_of(py, &by.multipliers_by_position)?),
                ("multipliers_by_velocity", array_of(py, &by.multipliers_by_velocity)?),
                ("multipliers_by_acceleration", array_of(py, &by.multipliers_by_acceleration)?),
            ],
        )
    }

    /// See `constrained_inverse_dynamics_pullback`.
    #[allow(clippy::too_many_arguments)] // those of the Python function
    fn _constrained_inverse_dynamics_pullback<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        multipliers: Option<&Bound<'py, PyAny>>,
        actuated: Option<Vec<bool>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v, a) = (configuration(py, self, q)?, vector(py, self, "v", v)?, vector(py, self, "a", a)?);
        let tau = vector_or_zeros(py, self, "tau", tau)?;
        let multipliers = row_cotangent(py, "multipliers", set.len(), multipliers)?;
        let actuated = actuated.unwrap_or_else(|| self.model.actuated_dofs().to_vec());
        check_actuated(py, self, &actuated)?;
        let inputs = ConstrainedTorquePullbackInputs {
            q: &q,
            v: &v,
            a: &a,
            actuated: &actuated,
            tau: &tau,
            multipliers: &multipliers,
        };
        let by = self
            .with_workspace(|w| constrained_inverse_dynamics_pullback(&self.model, w, set, inputs))
            .map_err(exception_of::<ConstraintError>)?;
        record(
            py,
            [
                ("tau", array(py, by.torque.tau.as_slice())?),
                ("multipliers", array(py, by.torque.multipliers.as_slice())?),
                ("by_position", array(py, by.by_position.as_slice())?),
                ("by_velocity", array(py, by.by_velocity.as_slice())?),
                ("by_acceleration", array(py, by.by_acceleration.as_slice())?),
                ("by_parameters", array(py, by.parameters.as_slice())?),
            ],
        )
    }

    /// See `contact_impulse_derivatives`.
    fn _contact_impulse_derivatives<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        restitution: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let options = ConstraintOptions::default();
        let by = self
            .with_workspace(|w| {
                contact_impulse_derivatives(&self.model, w, set, &options, &q, &v, restitution)
            })
            .map_err(exception_of::<ConstraintError>)?;
        record(
            py,
            [
                ("velocity", array(py, by.impact.velocity.as_slice())?),
                ("impulse", array(py, by.impact.impulse.as_slice())?),
                ("velocity_by_position", array_of(py, &by.velocity_by_position)?),
                ("velocity_by_velocity", array_of(py, &by.velocity_by_velocity)?),
                ("velocity_by_restitution", array(py, by.velocity_by_restitution.as_slice())?),
                ("impulse_by_position", array_of(py, &by.impulse_by_position)?),
                ("impulse_by_velocity", array_of(py, &by.impulse_by_velocity)?),
                ("impulse_by_restitution", array(py, by.impulse_by_restitution.as_slice())?),
            ],
        )
    }

    /// See `contact_impulse_pullback`.
    #[allow(clippy::too_many_arguments)] // those of the Python function
    fn _contact_impulse_pullback<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        velocity: Option<&Bound<'py, PyAny>>,
        impulse: Option<&Bound<'py, PyAny>>,
        restitution: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let velocity = vector_or_zeros(py, self, "velocity", velocity)?;
        let impulse = row_cotangent(py, "impulse", set.len(), impulse)?;
        let options = ConstraintOptions::default();
        let inputs =
            ImpulsePullbackInputs { q: &q, v: &v, restitution, velocity: &velocity, impulse: &impulse };
        let by = self
            .with_workspace(|w| contact_impulse_pullback(&self.model, w, set, &options, inputs))
            .map_err(exception_of::<ConstraintError>)?;
        record(
            py,
            [
                ("velocity", array(py, by.impact.velocity.as_slice())?),
                ("impulse", array(py, by.impact.impulse.as_slice())?),
                ("by_position", array(py, by.by_position.as_slice())?),
                ("by_velocity", array(py, by.by_velocity.as_slice())?),
                ("by_restitution", object(py, by.by_restitution)?),
            ],
        )
    }
}
