//! Errors of quantities of motion.

use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

use crate::SingularMass;

/// An invalid state, or a robot that is singular in that state: the error of the methods of
/// [`Model`](crate::Model) that compute a quantity of motion.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MotionError {
    /// A vector has the wrong length or a number that is not finite, a quaternion in q does not have unit
    /// length, or a result overflows.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// No link has mass, so the centre of mass is undefined.
    #[error("robot `{robot}` has no mass, and so no centre of mass; give its links masses")]
    NoMass {
        /// The robot's name.
        robot: String,
    },
    /// The operation inverts the mass matrix, which is not positive definite in this configuration.
    #[error(transparent)]
    SingularMass(#[from] SingularMass),
}

impl Classified for MotionError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::NoMass { .. } => ErrorKind::Infeasible,
            Self::SingularMass(error) => error.kind(),
        }
    }
}
