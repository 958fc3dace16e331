//! The arguments that `simulate` and `Simulation` share.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::simulation::{Effect, Method, SimulationBuilder};

use crate::constraint_set::Constraints;
use crate::errors::Class;

/// The ground, by the fields of the Python classes.
#[derive(Debug, PartialEq, FromPyObject)]
pub(crate) enum GroundFields {
    /// z \[m\], slope \[rad\], friction and restitution.
    Plane(f64, f64, Option<f64>, f64),
    /// Rows, columns, half lengths \[m\], heights \[m\], position \[m\]; friction and restitution.
    Hills(usize, usize, [f64; 2], Vec<f64>, [f64; 3], (Option<f64>, f64)),
    /// `file`: the height fields of the robot's file.
    Named(String),
}

/// The arguments that `simulate` and `Simulation` share.
#[derive(Debug)]
pub(crate) struct Setup {
    pub(super) dt: f64,
    pub(super) integrator: Option<String>,
    pub(super) without: Vec<String>,
    pub(super) conservative: bool,
    pub(super) ground: Option<GroundFields>,
    pub(super) constraints: Option<Py<Constraints>>,
    pub(super) stabilization: Option<f64>,
    pub(super) correction: String,
    pub(super) tolerance: Option<f64>,
    pub(super) control_period: Option<f64>,
    pub(super) interrupt: Option<Arc<AtomicBool>>,
    pub(super) ignored_pairs: Vec<(String, String)>,
    pub(super) only_pairs: Option<Vec<(String, String)>>,
}

impl PartialEq for Setup {
    fn eq(&self, other: &Self) -> bool {
        let own = |setup: &Self| setup.constraints.as_ref().map(Py::as_ptr);
        let Self { dt, integrator, without, conservative, ground, stabilization, correction, .. } = self;
        let Self { ignored_pairs, only_pairs, .. } = self;
        let steps = |setup: &Self| (setup.tolerance, setup.control_period);
        steps(self) == steps(other)
            && own(self) == own(other)
            && (*dt, *conservative, *stabilization) == (other.dt, other.conservative, other.stabilization)
            && (integrator, without, ground) == (&other.integrator, &other.without, &other.ground)
            && (correction, ignored_pairs, only_pairs)
                == (&other.correction, &other.ignored_pairs, &other.only_pairs)
    }
}

impl Setup {
    pub(crate) fn of(options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut setup = Self {
            dt: SimulationBuilder::DEFAULT_DT,
            integrator: None,
            without: Vec::new(),
            conservative: false,
            ground: None,
            constraints: None,
            stabilization: None,
            correction: "position".into(),
            tolerance: None,
            control_period: None,
            interrupt: None,
            ignored_pairs: Vec::new(),
            only_pairs: None,
        };
        for (name, value) in options.into_iter().flat_map(PyDictMethods::iter) {
            match name.extract::<String>()?.as_str() {
                "dt" => setup.dt = value.extract()?,
                "integrator" => setup.integrator = value.extract()?,
                "without" => setup.without = value.extract()?,
                "conservative" => setup.conservative = value.extract()?,
                "ground" => setup.ground = value.extract()?,
                "constraints" => setup.constraints = value.extract()?,
                "stabilization" => setup.stabilization = value.extract()?,
                "correction" => setup.correction = value.extract()?,
                "tolerance" => setup.tolerance = value.extract()?,
                "control_period" => setup.control_period = value.extract()?,
                "ignore_contacts" => setup.ignored_pairs = value.extract()?,
                "only_contacts" => setup.only_pairs = value.extract()?,
                other => return Err(PyValueError::new_err(format!("a simulation has no option {other:?}"))),
            }
        }
        Ok(setup)
    }

    /// The same without contacts. Explicit methods do not support them, so they need not be set up.
    pub(crate) fn without_contacts(mut self) -> Self {
        self.without.push(Effect::Contacts.name().into());
        self
    }

    pub(crate) fn dt(&self) -> f64 {
        self.dt
    }

    pub(crate) fn is_adaptive(&self) -> bool {
        self.integrator.as_deref() == Some(Method::Adaptive.name())
    }

    /// Whether the integrator takes steps with contact whose derivatives are known.
    pub(crate) fn has_linearized_steps(&self) -> bool {
        let names = [Method::Implicit.name(), Method::Mujoco.name()];
        self.integrator.as_deref().is_some_and(|integrator| names.contains(&integrator))
    }

    /// Refuses adaptive steps, where each step has the length `dt`.
    pub(crate) fn refuse_adaptive(self, py: Python<'_>) -> PyResult<Self> {
        if !self.is_adaptive() {
            return Ok(self);
        }
        let names: Vec<&str> = Method::names().filter(|name| *name != Method::Adaptive.name()).collect();
        Err(Class::SimulationInput.error(
            py,
            format!(
                "integrator='adaptive' has steps as long as its tolerance allows: `Robot.simulate` runs it; there are {}",
                names.join(", ")
            ),
        ))
    }

    /// With torques that are held for this time \[s\], unless the arguments state a time.
    pub(crate) fn holding(mut self, period: Option<f64>) -> Self {
        self.control_period = self.control_period.or(period);
        self
    }

    /// With a flag that ends adaptive steps.
    pub(crate) fn interrupted_by(mut self, flag: Arc<AtomicBool>) -> Self {
        self.interrupt = Some(flag);
        self
    }
}
