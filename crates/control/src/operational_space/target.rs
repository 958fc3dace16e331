//! The target of a frame at a time: the position of its origin, or its pose.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use robot_dynamics_core::{SpatialAcceleration, Twist};
use robot_dynamics_description::{Pose, Quaternion};
use robot_dynamics_number::{InputProblem, InvalidInput, check_finite};
use robot_dynamics_simulation::{CallbackError, ControllerError, IntoCallbackResult, SpatialAxis};

use super::mobility::MOST_ROWS;

/// A target that [`TaskControl`](super::TaskControl) can follow, and the directions that it controls.
pub trait TaskTarget {
    /// The directions that are controlled.
    const ROWS: &'static [SpatialAxis];

    /// ẍ\* + kp e + kd (ẋ\* − ẋ) for each of [`ROWS`](Self::ROWS), at the frame's pose and world-aligned
    /// velocity; further entries are 0.
    ///
    /// # Errors
    /// [`ControllerError`] if the target is missing or invalid.
    fn acceleration(
        self,
        pose: &Pose,
        velocity: &Twist,
        stiffness: f64,
        damping: f64,
    ) -> Result<[f64; MOST_ROWS], ControllerError>;
}

/// The target position of a frame's origin at a time, in the world; its orientation is free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskReference {
    /// x\* \[m\].
    pub position: [f64; 3],
    /// ẋ\* \[m/s\].
    pub velocity: [f64; 3],
    /// ẍ\* \[m/s²\].
    pub acceleration: [f64; 3],
}

/// The target pose of a frame at a time, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseReference {
    /// `world_from_frame`\*.
    pub pose: Pose,
    /// The velocity of the frame's origin and ω\*, along the world's axes \[m/s, rad/s\].
    pub velocity: Twist,
    /// The acceleration of the frame's origin and ω̇\*, along the world's axes \[m/s², rad/s²\].
    pub acceleration: SpatialAcceleration,
}

impl PoseReference {
    /// A constant pose.
    pub fn at_rest(pose: Pose) -> Self {
        let zero = [0.0; 3];
        let velocity = Twist { linear: zero, angular: zero };
        Self { pose, velocity, acceleration: SpatialAcceleration { linear: zero, angular: zero } }
    }
}

impl TaskTarget for TaskReference {
    const ROWS: &'static [SpatialAxis] = &[SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z];

    /// e = x\* − x.
    fn acceleration(
        self,
        pose: &Pose,
        velocity: &Twist,
        stiffness: f64,
        damping: f64,
    ) -> Result<[f64; MOST_ROWS], ControllerError> {
        let Self { position, velocity: wanted, acceleration } = self;
        check_finite("the reference position", &position)?;
        check_finite("the reference velocity", &wanted)?;
        check_finite("the reference acceleration", &acceleration)?;
        let error = core::array::from_fn(|k| position[k] - pose.translation[k]);
        let mut command = [0.0; MOST_ROWS];
        spring(&mut command[..3], acceleration, stiffness, error, damping, (wanted, velocity.linear));
        Ok(command)
    }
}

impl TaskTarget for PoseReference {
    const ROWS: &'static [SpatialAxis] =
        &[SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z, SpatialAxis::Rx, SpatialAxis::Ry, SpatialAxis::Rz];

    /// e = (x\* − x, log(R\* Rᵀ)): the rotation vector, of length at most π and along the world's axes, that
    /// rotates the frame to its target. **(MLS eq. 2.14)**
    fn acceleration(
        self,
        pose: &Pose,
        velocity: &Twist,
        stiffness: f64,
        damping: f64,
    ) -> Result<[f64; MOST_ROWS], ControllerError> {
        let Self { pose: wanted, velocity: Twist { linear, angular }, acceleration } = self;
        check_finite("the reference rotation", wanted.rotation.as_flattened())?;
        check_finite("the reference angular velocity", &angular)?;
        check_finite("the reference angular acceleration", &acceleration.angular)?;
        let defect = wanted.rotation_defect();
        if defect.is_nan() || defect > 1e-6 {
            return Err(InvalidInput::new("the reference", InputProblem::NotARotation { defect }).into());
        }
        let position = TaskReference {
            position: wanted.translation,
            velocity: linear,
            acceleration: acceleration.linear,
        };
        let mut command = position.acceleration(pose, velocity, stiffness, damping)?;
        let turn = rotation_vector(&wanted.rotation, &pose.rotation);
        let rates = (angular, velocity.angular);
        spring(&mut command[3..], acceleration.angular, stiffness, turn, damping, rates);
        Ok(command)
    }
}

/// A reference that can fail.
impl<T: TaskTarget, E: Into<Box<dyn std::error::Error + Send + Sync>>> TaskTarget for Result<T, E> {
    const ROWS: &'static [SpatialAxis] = T::ROWS;

    fn acceleration(
        self,
        pose: &Pose,
        velocity: &Twist,
        stiffness: f64,
        damping: f64,
    ) -> Result<[f64; MOST_ROWS], ControllerError> {
        let target: Result<T, CallbackError> = self.outcome();
        target?.acceleration(pose, velocity, stiffness, damping)
    }
}

/// ẍ\* + kp e + kd (ẋ\* − ẋ).
fn spring(
    command: &mut [f64],
    acceleration: [f64; 3],
    stiffness: f64,
    error: [f64; 3],
    damping: f64,
    (wanted, found): ([f64; 3], [f64; 3]),
) {
    for k in 0..3 {
        command[k] = acceleration[k] + stiffness * error[k] + damping * (wanted[k] - found[k]);
    }
}

/// log(A Bᵀ), with A and B given by rows.
fn rotation_vector(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [f64; 3] {
    let turn = Matrix3::from_fn(|i, j| (0..3).map(|k| a[i][k] * b[j][k]).sum());
    let quaternion = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    Quaternion::from_xyzw([quaternion.i, quaternion.j, quaternion.k, quaternion.w]).log()
}
