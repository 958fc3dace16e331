//! The error of an online motion.

use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

/// The error of [`OnlineMotion`](super::OnlineMotion): an invalid argument, or a target that the limits do not
/// allow.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OnlineMotionError {
    /// A length is wrong, a number is not finite, or a limit is not positive.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// The target is beyond a limit, or every motion to it passes one.
    #[error(
        "the target is out of reach: the {quantity} of coordinate `{coordinate}` is {value} there or just before, \
         its limit is {limit}"
    )]
    TargetBeyondLimit {
        /// `position`, `velocity` or `acceleration`.
        quantity: &'static str,
        /// The name of the coordinate.
        coordinate: String,
        /// The value at the target, or of the velocity from which the target's acceleration is reached.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// No motion to the target stays within the limits of position.
    #[error("no motion from this state to the target stays within the limits of position")]
    PositionLimits,
    /// The solver found no motion.
    #[error("no motion to the target was found: {reason}")]
    NoMotion {
        /// The solver's reason.
        reason: String,
    },
}

impl Classified for OnlineMotionError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            _ => ErrorKind::Infeasible,
        }
    }
}
