//! Inertial parameters from recorded motion.

mod consistent;
mod excitation;
mod motion;
pub(crate) mod payload;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::{IdentificationError, physical_consistency};
use robot_dynamics::nalgebra::DVector;

use crate::errors::{Class, exception, exception_of};
use crate::numbers::{array, array_of, object, record, shaped};
use crate::robot::Robot;
use motion::{MotionArrays, RecordSetup, motion_record, terms_of};

/// The combinations β of inertial parameters that torques determine; `robot_dynamics.Robot.base_parameters`
/// finds them.
#[pyclass(frozen, module = "robot_dynamics._native")]
#[derive(Debug)]
pub(crate) struct BaseParameters {
    parameters: robot_dynamics::control::BaseParameters,
    fingerprint: u64,
}

#[pymethods]
impl BaseParameters {
    /// Each combination in words, for example `upper.Iyy + fore.m`.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.parameters.parameters.iter().map(ToString::to_string).collect()
    }

    /// The parameters that affect no torque.
    #[getter]
    fn invisible(&self) -> Vec<String> {
        self.parameters.invisible.clone()
    }

    /// The changes of the parameters that change no torque, in words.
    #[getter]
    fn hidden(&self) -> Vec<String> {
        self.parameters.hidden().iter().map(ToString::to_string).collect()
    }

    /// The matrix of β = combinations · π.
    #[getter]
    fn combinations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array_of(py, &self.parameters.combinations)
    }

    /// Computes β = combinations · π.
    ///
    /// Parameters
    /// ----------
    /// parameters : array_like, shape (10·moving links,)
    ///     π, in the order of `Robot.inertial_parameter_names` [kg, kg·m, kg·m²], and then the joint terms.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (combinations,)
    ///     β, in the order of `names`.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     The array has the wrong shape.
    /// IdentificationError
    ///     A number is not finite.
    fn values<'py>(&self, py: Python<'py>, parameters: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (_, parameters) = shaped(py, "parameters", parameters, &[self.parameters.combinations.ncols()])?;
        let values = self.parameters.values(&parameters);
        array(py, values.map_err(exception_of::<IdentificationError>)?.as_slice())
    }

    /// Finds the π nearest to a given one that has these β.
    ///
    /// Parameters
    /// ----------
    /// values : array_like, shape (combinations,)
    ///     β, in the order of `names`.
    /// nominal : array_like, shape (10·moving links,)
    ///     The given π, in the order of `Robot.inertial_parameter_names` [kg, kg·m, kg·m²].
    ///
    /// Returns
    /// -------
    /// ndarray, shape (10·moving links,)
    ///     π with these β.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     An array has the wrong shape.
    /// IdentificationError
    ///     A number is not finite.
    fn nearest_parameters<'py>(
        &self,
        py: Python<'py>,
        values: &Bound<'py, PyAny>,
        nominal: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (_, values) = shaped(py, "values", values, &[self.parameters.len()])?;
        let (_, nominal) = shaped(py, "nominal", nominal, &[self.parameters.combinations.ncols()])?;
        let nearest = self.parameters.nearest_parameters(&DVector::from_vec(values), &nominal);
        array(py, nearest.map_err(exception_of::<IdentificationError>)?.as_slice())
    }

    fn __len__(&self) -> usize {
        self.parameters.len()
    }
}

/// Name, mass, least and largest eigenvalue, whether it could be a body.
type LinkFields = (String, f64, f64, f64, bool);

#[pymethods]
impl Robot {
    /// See `base_parameters`.
    fn _base_parameters(
        &self,
        py: Python<'_>,
        states: usize,
        seed: u64,
        terms: Vec<String>,
    ) -> PyResult<BaseParameters> {
        let model = &self.model;
        let terms = terms_of(model, &terms).map_err(exception_of::<IdentificationError>)?;
        let base = robot_dynamics::control::BaseParameters::of_with_terms;
        let parameters = py.detach(|| base(model, &terms, states, seed)).map_err(exception)?;
        Ok(BaseParameters { parameters, fingerprint: model.fingerprint() })
    }

    /// See `identify`.
    fn _identify<'py>(
        &self,
        py: Python<'py>,
        arrays: MotionArrays<'py>,
        setup: RecordSetup<'py>,
        base: Option<&Bound<'py, BaseParameters>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let motion = motion_record(py, self, &arrays, &setup)?;
        let own;
        let base = match base {
            Some(base) if base.get().fingerprint != self.model.fingerprint() => {
                return Err(Class::Identification
                    .error(py, "the base parameters are of another robot: find this one's"));
            }
            Some(base) => &base.get().parameters,
            None => {
                own = robot_dynamics::control::BaseParameters::of_record(&motion);
                &own
            }
        };
        let found = py.detach(|| base.identify(&motion)).map_err(exception)?;
        let base = BaseParameters { parameters: base.clone(), fingerprint: self.model.fingerprint() };
        record(
            py,
            [
                ("values", array(py, found.values.as_slice())?),
                ("standard_deviations", array(py, found.standard_deviations.as_slice())?),
                ("covariance", array_of(py, &found.covariance)?),
                ("residual", object(py, found.residual)?),
                ("residuals", array(py, &found.residuals)?),
                ("condition", object(py, found.condition)?),
                ("weakest", object(py, found.weakest)?),
                ("base", object(py, base)?),
            ],
        )
    }

    /// See `physical_consistency`.
    fn _physical_consistency(
        &self,
        py: Python<'_>,
        parameters: &Bound<'_, PyAny>,
    ) -> PyResult<Vec<LinkFields>> {
        let own = robot_dynamics::algorithms::inertial_parameters(&self.model).len();
        let (_, parameters) = shaped(py, "parameters", parameters, &[own])?;
        let links = physical_consistency(&self.model, &parameters);
        let links = links.map_err(exception_of::<IdentificationError>)?;
        let row = |link: &robot_dynamics::control::LinkConsistency| {
            (link.link.clone(), link.mass, link.smallest, link.largest, link.is_consistent())
        };
        Ok(links.iter().map(row).collect())
    }
}
