//! The recursive estimate of a payload.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::IdentificationError;
use robot_dynamics::control::identification::PayloadEstimator;
use robot_dynamics::model::Model;
use robot_dynamics::nalgebra::DMatrix;

use crate::errors::exception_of;
use crate::exclusive::Exclusive;
use crate::numbers::{array, array_of, object, record, several, shaped};
use crate::robot::Robot;

/// The native half of `robot_dynamics.PayloadEstimator`.
#[pyclass(subclass, frozen, module = "robot_dynamics._native")]
pub(crate) struct PayloadFilter {
    robot: Py<Robot>,
    own: Exclusive<PayloadEstimator<Arc<Model>>>,
}

#[pymethods]
impl PayloadFilter {
    #[new]
    fn new<'py>(
        robot: &Bound<'py, Robot>,
        frame: &Bound<'py, PyAny>,
        noise: &Bound<'py, PyAny>,
        forgetting: f64,
        prior: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
        offsets: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let (py, model) = (robot.py(), Arc::new(robot.get().model.clone()));
        let nv = model.nv();
        let invalid = exception_of::<IdentificationError>;
        let (_, noise) = shaped(py, "noise", noise, &[nv])?;
        let mut own = PayloadEstimator::owning(model, robot.get().frame_of(frame)?, &noise)
            .and_then(|own| own.with_forgetting(forgetting))
            .map_err(invalid)?;
        if let Some((parameters, deviations)) = prior {
            let (parameters, deviations) =
                (several("prior", &parameters)?, several("prior_deviations", &deviations)?);
            own = own.with_prior(parameters, deviations).map_err(invalid)?;
        }
        if let Some(offsets) = offsets {
            let (_, offsets) = shaped(py, "offsets", offsets, &[nv])?;
            own = own.with_dissipation_and_offsets(&offsets).map_err(invalid)?;
        }
        Ok(Self { robot: robot.clone().unbind(), own: Exclusive::new(own) })
    }

    /// See `push`.
    fn _push<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
    ) -> PyResult<()> {
        let model = &self.robot.get().model;
        let (_, q) = shaped(py, "q", q, &[model.nq()])?;
        let read = |name: &str, given| shaped(py, name, given, &[model.nv()]).map(|(_, numbers)| numbers);
        let (v, a, tau) = (read("v", v)?, read("a", a)?, read("tau", tau)?);
        self.own.lock(py).push(&q, &v, &a, &tau).map_err(exception_of::<IdentificationError>)
    }

    /// See `reset`.
    fn _reset(&self, py: Python<'_>) {
        self.own.lock(py).reset();
    }

    /// The ten parameters about the frame's origin and along its axes: m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz
    /// [kg, kg·m, kg·m²].
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.own.lock(py).parameters())
    }

    /// The covariance of the parameters (10, 10).
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let covariance = self.own.lock(py).covariance();
        array_of(py, &DMatrix::from_iterator(10, 10, covariance.iter().copied()))
    }

    /// See `payload`.
    fn _payload<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = self.own.lock(py).payload();
        record(
            py,
            [
                ("mass", object(py, found.mass)?),
                ("center_of_mass", array(py, &found.center_of_mass)?),
                ("inertia", array_of(py, &DMatrix::from_iterator(3, 3, found.inertia.iter().copied()))?),
                ("mass_deviation", object(py, found.mass_deviation)?),
                ("center_of_mass_deviation", array(py, &found.center_of_mass_deviation)?),
            ],
        )
    }

    fn __len__(&self) -> usize {
        self.own.lock_detached().len()
    }
}
