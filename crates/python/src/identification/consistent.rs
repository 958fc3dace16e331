//! Estimates of parameters that belong to bodies.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::IdentificationError;
use robot_dynamics::control::identification::{
    ConsistentEstimate, ConsistentOptions, JointTerm, JointTermKind, MotionRecord, MotionSample,
    NonlinearOptions, identify_consistent, identify_nonlinear,
};
use robot_dynamics::description::RobotDescription;

use super::motion::{Motion, MotionArrays, RecordSetup, kind_of, motion_record, terms_of};
use crate::errors::{exception, exception_of};
use crate::numbers::{array, array_of, object, record, shaped};
use crate::robot::Robot;

/// γ, the deviation of offsets, and the least radius.
type Weights = (f64, f64, f64);

/// The held links, the nominal parameters, and those of joint terms.
type Nominal<'py> = (Vec<String>, Option<Bound<'py, PyAny>>, Vec<(String, f64)>);

/// The Stribeck velocities at the start, whether the direction of gravity is identified, and the most steps.
type Search<'py> = (Option<Bound<'py, PyAny>>, bool, usize);

fn options_of(
    py: Python<'_>,
    columns: usize,
    (regularization, offset_deviation, least_radius): Weights,
    (held, nominal, joint_nominals): Nominal<'_>,
) -> PyResult<ConsistentOptions> {
    let mut options = ConsistentOptions::new(regularization)
        .with_offset_deviation(offset_deviation)
        .with_least_radius(least_radius);
    options.held_links = held;
    if let Some(nominal) = nominal {
        options.nominal = Some(shaped(py, "nominal", &nominal, &[columns])?.1);
    }
    for (name, value) in joint_nominals {
        let kind = match name.as_str() {
            "stribeck" => JointTermKind::Stribeck { velocity: 1.0 },
            _ => kind_of(&name).map_err(exception_of::<IdentificationError>)?,
        };
        options = options.with_joint_nominal(kind, value);
    }
    Ok(options)
}

impl Robot {
    fn consistent_estimate<'py>(
        &self,
        py: Python<'py>,
        found: &ConsistentEstimate,
        names: Vec<String>,
        described: &RobotDescription,
    ) -> PyResult<Bound<'py, PyDict>> {
        record(
            py,
            [
                ("parameters", array(py, &found.parameters)?),
                ("names", object(py, names)?),
                ("standard_deviations", array(py, &found.standard_deviations)?),
                ("covariance", array_of(py, &found.covariance)?),
                ("residual", object(py, found.residual)?),
                ("residuals", array(py, &found.residuals)?),
                ("divergences", array(py, &found.divergences)?),
                ("effective_parameters", object(py, found.effective_parameters)?),
                ("robot", object(py, self.state_of(described)?)?),
            ],
        )
    }
}

#[pymethods]
impl Robot {
    /// See `identify_consistent`.
    fn _identify_consistent<'py>(
        &self,
        py: Python<'py>,
        arrays: MotionArrays<'py>,
        setup: RecordSetup<'py>,
        weights: Weights,
        nominal: Nominal<'py>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let motion = motion_record(py, self, &arrays, &setup)?;
        let options = options_of(py, motion.nominal().len(), weights, nominal)?;
        let found = py.detach(|| identify_consistent(&motion, &options)).map_err(exception)?;
        let described = found.description(&self.model).map_err(exception)?;
        self.consistent_estimate(py, &found, motion.parameter_names(), &described)
    }

    /// See `identify_nonlinear`.
    fn _identify_nonlinear<'py>(
        &self,
        py: Python<'py>,
        arrays: MotionArrays<'py>,
        setup: RecordSetup<'py>,
        weights: Weights,
        nominal: Nominal<'py>,
        search: Search<'py>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (dissipation, names, noise, wrenches) = setup;
        let model = &self.model;
        let motion = Motion::read(py, self, &arrays, &wrenches)?;
        let samples: Vec<MotionSample<'_>> = motion.samples().collect();
        let invalid = exception_of::<IdentificationError>;
        let mut terms = terms_of(model, &names).map_err(invalid)?;
        let (velocities, gravity_direction, steps) = search;
        if let Some(velocities) = velocities {
            let (_, velocities) = shaped(py, "stribeck_velocities", &velocities, &[model.nv()])?;
            let joints = model.joints().iter().filter(|joint| joint.nv == 1);
            terms.extend(joints.map(|joint| {
                let kind = JointTermKind::Stribeck { velocity: velocities[joint.v_index] };
                JointTerm { joint: joint.index, kind }
            }));
        }
        let record_of_terms = MotionRecord::new(model, dissipation).with_terms(&terms).map_err(invalid)?;
        let consistent = options_of(py, record_of_terms.nominal().len(), weights, nominal)?;
        let mut options = NonlinearOptions::new(consistent, &terms).with_gravity_direction(gravity_direction);
        (options.with_dissipation, options.steps) = (dissipation, steps);
        if let Some(noise) = noise {
            options.noise = shaped(py, "noise", &noise, &[model.nv()])?.1;
        }
        let found = py.detach(|| identify_nonlinear(model, &samples, &options)).map_err(exception)?;
        let mut described = found.linear.description(model).map_err(exception)?;
        described.gravity = found.gravity;
        let names = record_of_terms.parameter_names();
        let velocities: Vec<f64> = found
            .terms
            .iter()
            .filter_map(|term| match term.kind {
                JointTermKind::Stribeck { velocity } => Some(velocity),
                _ => None,
            })
            .collect();
        record(
            py,
            [
                ("linear", self.consistent_estimate(py, &found.linear, names, &described)?.into_any()),
                ("stribeck_velocities", array(py, &velocities)?),
                ("gravity", array(py, &found.gravity)?),
                ("standard_deviations", array(py, &found.standard_deviations)?),
                ("steps", object(py, found.steps)?),
            ],
        )
    }
}
