//! Exceptions: the classes of `robot_dynamics.errors`, raised from here.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use robot_dynamics::text::lines;

/// A class of `robot_dynamics.errors`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Class {
    Load,
    Shape,
    DType,
    State,
    BadStates,
    BadSimulations,
    SingularMass,
    Frame,
    Simulation,
    Constraint,
    InverseKinematics,
    Control,
    Planning,
    Identification,
    Description,
    Generate,
}

impl Class {
    fn name(self) -> &'static str {
        match self {
            Self::Load => "LoadError",
            Self::Shape => "ShapeError",
            Self::DType => "DTypeError",
            Self::State => "StateError",
            Self::BadStates => "BadStatesError",
            Self::BadSimulations => "BadSimulationsError",
            Self::SingularMass => "SingularMassError",
            Self::Frame => "FrameError",
            Self::Simulation => "SimulationError",
            Self::Constraint => "ConstraintError",
            Self::InverseKinematics => "InverseKinematicsError",
            Self::Control => "ControlError",
            Self::Planning => "PlanningError",
            Self::Identification => "IdentificationError",
            Self::Description => "DescriptionError",
            Self::Generate => "GenerateError",
        }
    }

    /// The class itself.
    fn class(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
        let module = MODULE.get_or_try_init(py, || py.import("robot_dynamics.errors").map(Bound::unbind))?;
        module.bind(py).getattr(self.name())
    }

    /// An exception of this class with that message.
    #[cold]
    pub(crate) fn error(self, py: Python<'_>, message: impl ToString) -> PyErr {
        self.error_with(py, message, &[])
    }

    /// The same, with attributes.
    #[cold]
    pub(crate) fn error_with(
        self,
        py: Python<'_>,
        message: impl ToString,
        attributes: &[(&str, Bound<'_, PyAny>)],
    ) -> PyErr {
        let made = || {
            let class = self.class(py)?;
            let arguments = PyDict::new(py);
            for (name, value) in attributes {
                arguments.set_item(name, value)?;
            }
            // The message may go to a terminal, and it contains names from a robot's file.
            let message = lines(&message.to_string()).into_owned();
            let exception = class.call((message,), Some(&arguments))?;
            PyResult::Ok(PyErr::from_value(exception))
        };
        made().unwrap_or_else(|error| error)
    }
}
