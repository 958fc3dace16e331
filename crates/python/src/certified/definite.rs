//! Proofs that M(q) is positive definite in a box.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics_certified::{Definiteness, mass_matrix_definiteness};

use super::bounds::{ends, region, search};
use crate::errors::{Class, exception};
use crate::numbers::array;
use crate::robot::Robot;

#[pymethods]
impl Robot {
    /// See `certify_mass_matrix`.
    fn _certify_mass_matrix<'py>(
        &self,
        py: Python<'py>,
        lower: &Bound<'py, PyAny>,
        upper: &Bound<'py, PyAny>,
        max_boxes: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let q = region(py, self, lower, upper)?;
        // The options' tolerance has no meaning here.
        let found =
            search(py, (0.0, max_boxes), None, |options| mass_matrix_definiteness(&self.model, &q, options))?;
        let record = PyDict::new(py);
        let verdict = match found.map_err(exception)? {
            Definiteness::ByOwnInertias => "proven by own inertias",
            Definiteness::ByDivision { boxes, tree } => {
                record.set_item("boxes", boxes)?;
                record.set_item("divisions", tree.preorder())?;
                "proven by division"
            }
            Definiteness::Disproven { q } => {
                record.set_item("q", array(py, &q)?)?;
                "counterexample"
            }
            Definiteness::Open { region } => {
                let [lower, upper] = ends(py, &[region.len()], &region)?;
                record.set_item("open_lower", lower)?;
                record.set_item("open_upper", upper)?;
                "open"
            }
            other => return Err(Class::State.error(py, format!("the result {other:?} is unknown"))),
        };
        record.set_item("verdict", verdict)?;
        Ok(record)
    }
}
