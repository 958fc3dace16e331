//! Errors of building a simulation.

use robot_dynamics_description::ModelError;
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

use crate::constraints::ConstraintError;

/// The error of [`SimulationBuilder::build`](super::SimulationBuilder::build).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// The step, or the tolerance or the control period of adaptive steps, is out of its range. A ground, a
    /// surface, a height field or a pair of links is invalid.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// The equalities do not fit the robot.
    #[error(transparent)]
    Equalities(#[from] ConstraintError),
    /// The links with gravity compensation do not form a valid model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The method does not support a request.
    #[error("method `{method}` {problem}")]
    Method {
        /// The name of the method.
        method: &'static str,
        /// The unsupported request, and the methods that support it.
        problem: String,
    },
    /// A ground was given, but the robot has no shape that can touch it.
    #[error("robot `{robot}` has no collision shape that can touch the ground{}", because(.left_out))]
    NothingTouches {
        /// The name of the robot.
        robot: String,
        /// The shapes that are left out, each with the reason.
        left_out: Vec<String>,
    },
    /// The dynamics of the method could not be set up.
    #[error(transparent)]
    Dynamics(#[from] IntegratorError),
    /// A ground was combined with [`conservative`](super::SimulationBuilder::conservative) or with contacts
    /// switched off.
    #[error("a ground was given, but contacts are switched off; leave one of the two out")]
    GroundWithoutContacts,
}

impl Classified for SimulationError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::Equalities(error) => error.kind(),
            Self::Model(error) => error.kind(),
            Self::Dynamics(error) => error.kind(),
            Self::Method { .. } | Self::GroundWithoutContacts => ErrorKind::Unsupported,
            Self::NothingTouches { .. } => ErrorKind::Description,
        }
    }
}

fn because(left_out: &[String]) -> String {
    match left_out {
        [] => "; give its links <collision> shapes".into(),
        reasons => format!(": {}", reasons.join("; ")),
    }
}
