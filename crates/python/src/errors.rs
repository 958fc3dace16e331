//! Exceptions: the classes of `robot_dynamics.errors`, raised from here.

use std::any::TypeId;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use robot_dynamics::batch::RolloutError;
use robot_dynamics::constraints::ConstraintError;
use robot_dynamics::control::online_motion::OnlineMotionError;
use robot_dynamics::control::optimal::OptimalControlError;
use robot_dynamics::control::task_kinematics::TaskKinematicsError;
use robot_dynamics::control::whole_body::WholeBodyError;
use robot_dynamics::control::{
    DlqrError, IdentificationError, InverseKinematicsError, ParameterizationError,
};
use robot_dynamics::description::{InertiaError, ModelError};
use robot_dynamics::simulation::{ControllerError, RunError, SimulationError, StepError};
use robot_dynamics::text::lines;
use robot_dynamics::{Classified, ErrorKind, FileError};
use robot_dynamics_generate::GenerateError;
use robot_dynamics_gpu::DeviceError;

/// The exception of an error of the library, of the class that [`Class::of`] gives.
#[cold]
pub(crate) fn exception<E: Classified>(error: E) -> PyErr {
    Python::attach(|py| Class::of(&error).error(py, error))
}

/// The exception of an error that is one of a subject: `exception_of::<ControllerError>` for an invalid gain.
#[cold]
pub(crate) fn exception_of<E: Classified>(error: impl Into<E>) -> PyErr {
    exception(error.into())
}

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
    SimulationInput,
    Constraint,
    InverseKinematics,
    Control,
    Planning,
    Identification,
    Description,
    Generate,
    Device,
}

impl Class {
    /// The class of an error of the library: the class of its subject, if its type belongs to one, and
    /// otherwise the class of its kind.
    pub(crate) fn of<E: Classified>(error: &E) -> Self {
        let subjects = [
            (TypeId::of::<SimulationError>(), Self::SimulationInput),
            (TypeId::of::<RunError>(), Self::Simulation),
            (TypeId::of::<StepError>(), Self::Simulation),
            (TypeId::of::<RolloutError>(), Self::Simulation),
            (TypeId::of::<ConstraintError>(), Self::Constraint),
            (TypeId::of::<ControllerError>(), Self::Control),
            (TypeId::of::<DlqrError>(), Self::Control),
            (TypeId::of::<OptimalControlError>(), Self::Control),
            (TypeId::of::<WholeBodyError>(), Self::Control),
            (TypeId::of::<InverseKinematicsError>(), Self::InverseKinematics),
            (TypeId::of::<TaskKinematicsError>(), Self::InverseKinematics),
            (TypeId::of::<ParameterizationError>(), Self::Planning),
            (TypeId::of::<OnlineMotionError>(), Self::Planning),
            (TypeId::of::<IdentificationError>(), Self::Identification),
            (TypeId::of::<ModelError>(), Self::Description),
            (TypeId::of::<InertiaError>(), Self::Description),
            (TypeId::of::<FileError>(), Self::Load),
            (TypeId::of::<GenerateError>(), Self::Generate),
            (TypeId::of::<DeviceError>(), Self::Device),
        ];
        let subject = subjects.into_iter().find(|(own, _)| *own == TypeId::of::<E>()).map(|(_, class)| class);
        match (subject, error.kind()) {
            (
                Some(Self::Simulation),
                ErrorKind::InvalidInput | ErrorKind::UnknownName | ErrorKind::Unsupported,
            ) => Self::SimulationInput,
            (Some(Self::Device), ErrorKind::InvalidInput) => Self::Shape,
            (Some(class), _) => class,
            (None, ErrorKind::File) => Self::Load,
            (None, ErrorKind::Description | ErrorKind::Unsupported) => Self::Description,
            (None, ErrorKind::UnknownName) => Self::Frame,
            (None, ErrorKind::Singular) => Self::SingularMass,
            (None, ErrorKind::Constraint) => Self::Constraint,
            (None, _) => Self::State,
        }
    }

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
            Self::SimulationInput => "SimulationInputError",
            Self::Constraint => "ConstraintError",
            Self::InverseKinematics => "InverseKinematicsError",
            Self::Control => "ControlError",
            Self::Planning => "PlanningError",
            Self::Identification => "IdentificationError",
            Self::Description => "DescriptionError",
            Self::Generate => "GenerateError",
            Self::Device => "DeviceError",
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
