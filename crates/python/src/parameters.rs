//! The parameters of a robot that gradients are taken by, their names, and a robot with other parameters.

use pyo3::prelude::*;
use robot_dynamics::algorithms::PARAMETERS_PER_LINK;
use robot_dynamics::control::physical_consistency;
use robot_dynamics::derivatives::{parameter_values, with_parameters};
use robot_dynamics::description::RobotDescription;

use crate::errors::{Class, exception};
use crate::numbers::{array, shaped};
use crate::robot::Robot;

#[pymethods]
impl Robot {
    /// The parameters of the dynamics; `with_parameters` makes a robot with others.
    ///
    /// For each moving link, with the links fixed to it: m, m c (3) and Ixx, Ixy, Iyy, Ixz, Iyz, Izz about
    /// its origin [kg, kg·m, kg·m²]. For each joint that is not fixed: armature, damping, friction, stiffness
    /// and rest, all 0 for a floating base. Then gravity (3) [m/s²].
    ///
    /// Returns
    /// -------
    /// ndarray, shape (parameters,)
    ///     The parameters, named by `parameter_names`.
    ///
    /// Examples
    /// --------
    ///
    /// >>> robot = rd.example("two_r")
    /// >>> len(robot.parameters()), len(robot.parameter_names)
    /// (33, 33)
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
        let joints = self.model.moving_joints().flat_map(|joint| of(&joint.name, &PASSIVE));
        links.chain(joints).chain(of("gravity", &["x", "y", "z"])).collect()
    }

    /// See `with_parameters`.
    fn _with_parameters(
        &self,
        py: Python<'_>,
        parameters: &Bound<'_, PyAny>,
        as_written: bool,
    ) -> PyResult<String> {
        let (_, values) = shaped(py, "parameters", parameters, &[usize::MAX])?;
        let description = with_parameters(&self.model, &values).map_err(exception)?;
        if !as_written {
            self.check_bodies(&values, &description).map_err(|text| Class::Description.error(py, text))?;
        }
        self.state_of(&description)
    }
}

impl Robot {
    /// Refuses a link with parameters that no body has, by the rule of `physical_consistency`. Links whose
    /// parameters do not change are not refused.
    fn check_bodies(&self, values: &[f64], described: &RobotDescription) -> Result<(), String> {
        let inertial = PARAMETERS_PER_LINK * self.model.moving_links().count();
        let verdicts =
            physical_consistency(&self.model, &values[..inertial]).map_err(|error| error.to_string())?;
        let own = parameter_values(&self.model);
        let rows = values.chunks_exact(PARAMETERS_PER_LINK).zip(own.chunks_exact(PARAMETERS_PER_LINK));
        for (verdict, (given, own)) in verdicts.iter().zip(rows) {
            if verdict.is_consistent() || given == own {
                continue;
            }
            let link = described.links.iter().find(|link| link.name == verdict.link);
            let flaw = link.and_then(|link| link.mass_properties.as_ref()?.flaw());
            let reason = flaw.map_or_else(
                || {
                    let (smallest, largest) = (verdict.smallest, verdict.largest);
                    format!("its pseudo-inertia has the eigenvalues {smallest:.3e} to {largest:.3e}, none may be negative")
                },
                |flaw| flaw.to_string(),
            );
            return Err(format!(
                "link `{}`: no body has these parameters: {reason}; see `physical_consistency`, or give as_written=True to \
                 take them as from a file",
                verdict.link
            ));
        }
        Ok(())
    }
}
