//! Enclosures of the quantities at a state.

use pyo3::prelude::*;
use robot_dynamics_certified::{EnclosedState, enclose_state};

use super::bounds::ends;
use crate::errors::exception;
use crate::numbers::{configuration, vector_or_zeros};
use crate::outcome;
use crate::robot::Robot;

/// Name, lower and upper bounds, results in double precision, their relative error and digits.
type QuantityFields<'py> = (&'static str, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, f64, f64);

#[pymethods]
impl Robot {
    /// See `certify_digits`.
    fn _certify_digits<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
        a: Option<&Bound<'py, PyAny>>,
        tau: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Vec<QuantityFields<'py>>> {
        let q = configuration(py, self, q)?;
        let v = vector_or_zeros(py, self, "v", v)?;
        let a = vector_or_zeros(py, self, "a", a)?;
        let tau = vector_or_zeros(py, self, "tau", tau)?;
        let state = EnclosedState { q: &q, v: &v, a: &a, tau: &tau };
        let quantities = py.detach(|| enclose_state(&self.model, state)).map_err(exception)?;
        let nv = self.model.nv();
        let fields = quantities.iter().map(|quantity| {
            let shape: &[usize] = match quantity.name {
                "mass_matrix" | "coriolis_matrix" => &[nv, nv],
                "kinetic_energy" | "potential_energy" => &[],
                _ => &[nv],
            };
            let [lower, upper] = ends(py, shape, &quantity.enclosure)?;
            let computed = outcome::filled(py, shape, &quantity.computed)?;
            Ok((quantity.name, lower, upper, computed, quantity.relative_error(), quantity.digits()))
        });
        fields.collect()
    }
}
