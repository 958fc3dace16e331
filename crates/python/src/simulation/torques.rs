//! The sources of a run's torques.

use pyo3::prelude::*;
use robot_dynamics::simulation::{Controller, ControllerError};

use crate::controllers::{self, Law};
use crate::numbers::{self, shaped};
use crate::robot::Robot;

/// The source of torques.
pub(crate) enum Torques<'a> {
    Held(Vec<f64>),
    /// A row for each step.
    EachStep {
        rows: Vec<f64>,
        nv: usize,
        step: f64,
    },
    /// A law of the library's, or a Python function f(t, q, v).
    Law(Law<'a>),
}

impl<'a> Torques<'a> {
    pub(super) fn of(
        py: Python<'_>,
        robot: &'a Robot,
        tau: Option<&Bound<'_, PyAny>>,
        steps: usize,
        step: f64,
    ) -> PyResult<Self> {
        let nv = robot.model.nv();
        let Some(tau) = tau else { return Ok(Self::Held(vec![0.0; nv])) };
        if let Some(law) = controllers::law_of(py, robot, tau)? {
            return Ok(Self::Law(law));
        }
        if tau.is_callable() {
            return Ok(Self::Law(controllers::called_law(tau, robot)));
        }
        let (shape, rows) = numbers::numbers(py, "tau", tau)?;
        if shape == [nv] {
            return Ok(Self::Held(rows));
        }
        shaped(py, "tau", tau, &[steps, nv])?;
        Ok(Self::EachStep { rows, nv, step })
    }

    /// Whether the source calls Python.
    pub(super) fn is_called(&self) -> bool {
        matches!(self, Self::Law(Law { is_called: true, .. }))
    }

    /// How long each torque is held, if the torques themselves define it.
    pub(super) fn period(&self) -> Option<f64> {
        match self {
            Self::EachStep { step, .. } => Some(*step),
            _ => None,
        }
    }
}

impl Controller for Torques<'_> {
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        match self {
            Self::Held(held) => tau.copy_from_slice(held),
            Self::Law(law) => law.controller.torque(t, q, v, tau)?,
            Self::EachStep { rows, nv, step } => {
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                // the time of a step of the run
                let k = (t / *step).round() as usize;
                // A run without steps has no row; its torque is zero.
                let last = (rows.len() / (*nv).max(1)).saturating_sub(1);
                let row = rows.get(k.min(last) * *nv..).and_then(|rows| rows.get(..*nv));
                match row {
                    Some(row) => tau.copy_from_slice(row),
                    None => tau.fill(0.0),
                }
            }
        }
        Ok(())
    }
}
