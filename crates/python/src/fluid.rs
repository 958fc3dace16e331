//! The forces of the fluid around a robot.

use pyo3::prelude::*;
use robot_dynamics::description::Medium;
use robot_dynamics::simulation::FluidForces;

use crate::numbers::{array, configuration, vector};
use crate::outcome;
use crate::robot::Robot;

#[pymethods]
impl Robot {
    /// See `with_fluid`.
    fn _with_fluid(&self, density: f64, viscosity: f64, wind: [f64; 3]) -> PyResult<String> {
        self.edited(|description| {
            description.immerse(Medium { density, viscosity, wind });
            Ok(())
        })
    }

    /// See `fluid_forces`.
    fn _fluid_forces<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let (model, mut tau) = (&self.model, vec![0.0; v.len()]);
        let fluid = FluidForces::new(model);
        fluid.forces(model, &mut fluid.workspace(model), &q, &v, &mut tau);
        array(py, &tau)
    }

    /// See `fluid_force_derivatives`.
    fn _fluid_force_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let (model, nv) = (&self.model, v.len());
        let (mut by_q, mut by_v) = (vec![0.0; nv * nv], vec![0.0; nv * nv]);
        let fluid = FluidForces::new(model);
        fluid.derivatives(model, &mut fluid.workspace(model), &q, &v, &mut by_q, &mut by_v);
        Ok((outcome::filled(py, &[nv, nv], &by_q)?, outcome::filled(py, &[nv, nv], &by_v)?))
    }
}
