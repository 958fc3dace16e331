//! Exciting motions.

use std::ops::ControlFlow;
use std::sync::atomic::Ordering;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::control::IdentificationError;
use robot_dynamics::control::identification::{
    ExcitationCriterion, ExcitationLimits, ExcitationOptions, design_excitation_observed,
};
use robot_dynamics::nalgebra::DMatrix;

use super::motion::terms_of;
use crate::errors::{Class, exception, exception_of};
use crate::interrupts::interruptible;
use crate::numbers::{array, array_of, object, record, shaped};
use crate::robot::Robot;

/// The bounds of the position, and the limits of velocity, acceleration and torque.
type Limits<'py> = (
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
);

/// Period, harmonics, whether the motion starts at rest, samples, the criterion, steps, and the seed.
type Design = (f64, usize, bool, Option<usize>, String, usize, u64);

#[pymethods]
impl Robot {
    /// See `design_excitation`.
    fn _design_excitation<'py>(
        &self,
        py: Python<'py>,
        limits: Limits<'py>,
        design: Design,
        terms: Vec<String>,
        noise: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let nv = self.model.nv();
        let mut own = ExcitationLimits::of(&self.model);
        let (position, velocity, acceleration, torque) = limits;
        if let Some(position) = position {
            let (_, numbers) = shaped(py, "position", &position, &[nv, 2])?;
            own.position = numbers.chunks_exact(2).map(|ends| [ends[0], ends[1]]).collect();
        }
        for (name, given, own) in [
            ("velocity", velocity, &mut own.velocity),
            ("acceleration", acceleration, &mut own.acceleration),
            ("torque", torque, &mut own.torque),
        ] {
            if let Some(given) = given {
                *own = shaped(py, name, &given, &[nv])?.1;
            }
        }
        let (period, harmonics, from_rest, samples, criterion, steps, seed) = design;
        let terms = terms_of(&self.model, &terms).map_err(exception_of::<IdentificationError>)?;
        let criterion = match criterion.as_str() {
            "determinant" => ExcitationCriterion::Determinant,
            "condition" => ExcitationCriterion::Condition,
            other => {
                let text = format!("criterion is `{other}`; it must be `determinant` or `condition`");
                return Err(Class::Identification.error(py, text));
            }
        };
        let mut options = ExcitationOptions::new(period, harmonics)
            .with_rest(from_rest)
            .with_terms(&terms)
            .with_criterion(criterion)
            .with_steps(steps)
            .with_seed(seed);
        options.samples = samples.unwrap_or(options.samples);
        if let Some(noise) = noise {
            options.noise = shaped(py, "noise", noise, &[nv])?.1;
        }
        let found = interruptible(py, false, |cancelled| {
            design_excitation_observed(&self.model, &own, &options, |_, _| {
                if cancelled.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
        })?;
        let found = found.map_err(exception)?;
        let rows = |lists: &[Vec<f64>]| DMatrix::from_fn(nv, harmonics, |i, k| lists[i][k]);
        record(
            py,
            [
                ("period", object(py, found.series.period)?),
                ("offsets", array(py, &found.series.offsets)?),
                ("sines", array_of(py, &rows(&found.series.sines))?),
                ("cosines", array_of(py, &rows(&found.series.cosines))?),
                ("condition", object(py, found.condition)?),
                ("start_condition", object(py, found.start_condition)?),
                ("log_information", object(py, found.log_information)?),
                ("usage", object(py, found.usage)?),
                ("steps", object(py, found.steps)?),
            ],
        )
    }
}
