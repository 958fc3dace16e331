//! What gradients by parameters are of: the parameters of a robot, their names, and a robot with others.

use pyo3::prelude::*;
use robot_dynamics::{parameter_values, with_parameters};

use crate::errors::Class;
use crate::numbers::{array, shaped};
use crate::robot::Robot;

#[pymethods]
impl Robot {
    /// The parameters of the dynamics: for each moving link m, m c (3) and Ixx, Ixy, Iyy, Ixz, Iyz, Izz about its origin,
    /// what is fixed to it included; for each joint armature, damping, friction, stiffness and rest; gravity (3).
    ///
    /// → (parameters,), named by `parameter_names`; `with_parameters` makes a robot with others.
    ///
    /// >>> robot = rd.example("two_r")
    /// >>> len(robot.parameters()), len(robot.parameter_names)
    /// (38, 38)
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &parameter_values(&self.model))
    }

    /// The names of the parameters, for example `upper.m`, `shoulder.damping` or `gravity.z`.
    #[getter]
    fn parameter_names(&self) -> Vec<String> {
        const INERTIAL: [&str; 10] = ["m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"];
        const PASSIVE: [&str; 5] = ["armature", "damping", "friction", "stiffness", "rest"];
        let of = |owner: &str, names: &[&str]| {
            names.iter().map(|name| format!("{owner}.{name}")).collect::<Vec<_>>()
        };
        let links = self.model.moving_links().flat_map(|link| of(link, &INERTIAL));
        let joints = self.model.joints().iter().flat_map(|joint| of(&joint.name, &PASSIVE));
        links.chain(joints).chain(of("gravity", &["x", "y", "z"])).collect()
    }

    /// See `with_parameters`.
    fn _with_parameters(&self, py: Python<'_>, parameters: &Bound<'_, PyAny>) -> PyResult<String> {
        let (_, values) = shaped(py, "parameters", parameters, &[usize::MAX])?;
        let description =
            with_parameters(&self.model, &values).map_err(|error| Class::Description.error(py, error))?;
        self.state_of(&description)
    }
}
