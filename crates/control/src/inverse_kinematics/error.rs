//! Errors of inverse kinematics.

use robot_dynamics_core::MotionError;
use thiserror::Error;

use super::{FrameTarget, InverseKinematicsOptions, InverseKinematicsSolution};

/// An error of [`inverse_kinematics`](crate::inverse_kinematics).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum InverseKinematicsError {
    /// The start is an invalid configuration.
    #[error("the start: {0}")]
    Start(#[from] MotionError),
    /// A number of the target is NaN or infinite.
    #[error("the target's {quantity}[{index}] is {value}; every number must be finite")]
    NotFinite {
        /// `position` or `rotation`, by rows.
        quantity: &'static str,
        /// The index of the entry.
        index: usize,
        /// The value of the entry.
        value: f64,
    },
    /// The target's matrix is not a rotation.
    #[error("the target's rotation matrix is not orthonormal with determinant 1 (off by {defect:e})")]
    NotARotation {
        /// The larger of max |RᵀR − 1| and |det R − 1|.
        defect: f64,
    },
    /// A tolerance is negative, too small, or not finite.
    #[error("the {option} is {value}; it must be positive and finite")]
    BadTolerance {
        /// `position tolerance` or `angle tolerance`.
        option: &'static str,
        /// Its value.
        value: f64,
    },
    /// No start led to a configuration within the tolerances.
    #[error(
        "frame `{frame}` of robot `{robot}` came no nearer than {:e} m and {:e} rad, in {} steps from the start and \
         {} random ones: the target is out of reach within the joint limits, or needs larger tolerances or more restarts",
        .best.position_error, .best.angle_error, .best.iterations, .best.restarts
    )]
    NoSolution {
        /// The name of the frame.
        frame: String,
        /// The name of the robot.
        robot: String,
        /// The nearest configuration found, within the limits.
        best: Box<InverseKinematicsSolution>,
    },
}

/// Checks that the tolerances are in their range.
pub(super) fn check_options(options: &InverseKinematicsOptions) -> Result<(), InverseKinematicsError> {
    let tolerances =
        [("position tolerance", options.position_tolerance), ("angle tolerance", options.angle_tolerance)];
    match tolerances.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
        Some((option, value)) => Err(InverseKinematicsError::BadTolerance { option, value }),
        None => Ok(()),
    }
}

/// Checks that the target is valid.
pub(super) fn check_target(target: &FrameTarget) -> Result<(), InverseKinematicsError> {
    let finite = |quantity, x: &[f64]| match x.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(InverseKinematicsError::NotFinite { quantity, index, value: x[index] }),
        None => Ok(()),
    };
    match target {
        FrameTarget::Position(position) => finite("position", position),
        FrameTarget::Pose(pose) => {
            finite("position", &pose.translation)?;
            finite("rotation", pose.rotation.as_flattened())?;
            let defect = pose.rotation_defect();
            if defect > 1e-6 { Err(InverseKinematicsError::NotARotation { defect }) } else { Ok(()) }
        }
    }
}
