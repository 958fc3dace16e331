//! Errors of inverse kinematics.

use robot_dynamics_number::{
    Classified, ErrorKind, InputProblem, InvalidInput, check_finite, check_positive,
};
use thiserror::Error;

use super::{FrameTarget, InverseKinematicsOptions, InverseKinematicsSolution};

/// The error of [`inverse_kinematics`](crate::inverse_kinematics).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum InverseKinematicsError {
    /// The start is an invalid configuration, a number of the target is not finite, its matrix is not a
    /// rotation, or a tolerance is not positive and finite.
    #[error(transparent)]
    Input(#[from] InvalidInput),
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

impl Classified for InverseKinematicsError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::NoSolution { .. } => ErrorKind::NotConverged,
        }
    }
}

/// Checks that the tolerances are in their range.
pub(crate) fn check_options(options: &InverseKinematicsOptions) -> Result<(), InvalidInput> {
    check_positive("the position tolerance", options.position_tolerance, "m")?;
    check_positive("the angle tolerance", options.angle_tolerance, "rad")
}

/// Checks that the target is valid.
pub(crate) fn check_target(target: &FrameTarget) -> Result<(), InvalidInput> {
    match target {
        FrameTarget::Position(position) => check_finite("the target's position", position),
        FrameTarget::Pose(pose) => {
            check_finite("the target's position", &pose.translation)?;
            check_finite("the target's rotation", pose.rotation.as_flattened())?;
            let defect = pose.rotation_defect();
            if defect > 1e-6 {
                return Err(InvalidInput::new("the target", InputProblem::NotARotation { defect }));
            }
            Ok(())
        }
    }
}
