//! The target of a frame at a time: the position of its origin, or its pose.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use robot_dynamics_core::{SpatialAcceleration, Twist};
use robot_dynamics_description::{Pose, Quaternion};
use robot_dynamics_number::{InputProblem, InvalidInput, check_finite};
use robot_dynamics_simulation::{CallbackError, ControllerError, IntoCallbackResult, SpatialAxis};

use super::mobility::MOST_ROWS;

/// A target that [`TaskControl`](super::TaskControl) and [`ImpedanceControl`](super::ImpedanceControl) can
/// follow, and the directions that it controls.
pub trait TaskTarget {
    /// The directions that are controlled.
    const ROWS: &'static [SpatialAxis];

    /// The deviation of the frame, at its pose and world-aligned velocity, from the target.
    ///
    /// # Errors
    /// [`ControllerError`] if the target is missing or invalid.
    fn deviation(self, pose: &Pose, velocity: &Twist) -> Result<TaskDeviation, ControllerError>;
}

/// The deviation of a frame from its target, along the world's axes. Entry k belongs to row k of the target;
/// further entries are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TaskDeviation {
    /// e = x\* − x \[m\], then the rotation vector log(R\* Rᵀ) \[rad\].
    pub position: [f64; MOST_ROWS],
    /// ẋ\* − ẋ \[m/s, rad/s\].
    pub velocity: [f64; MOST_ROWS],
    /// ẍ\* \[m/s², rad/s²\].
    pub acceleration: [f64; MOST_ROWS],
}

impl TaskDeviation {
    /// ẍ\* + kp e + kd (ẋ\* − ẋ), with kp \[1/s²\] and kd \[1/s\].
    pub fn acceleration(&self, stiffness: f64, damping: f64) -> [f64; MOST_ROWS] {
        let Self { position, velocity, acceleration } = self;
        core::array::from_fn(|k| acceleration[k] + stiffness * position[k] + damping * velocity[k])
    }
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
    fn deviation(self, pose: &Pose, velocity: &Twist) -> Result<TaskDeviation, ControllerError> {
        let Self { position, velocity: wanted, acceleration } = self;
        check_finite("the reference position", &position)?;
        check_finite("the reference velocity", &wanted)?;
        check_finite("the reference acceleration", &acceleration)?;
        let mut deviation = TaskDeviation::default();
        for k in 0..3 {
            deviation.position[k] = position[k] - pose.translation[k];
            deviation.velocity[k] = wanted[k] - velocity.linear[k];
            deviation.acceleration[k] = acceleration[k];
        }
        Ok(deviation)
    }
}

impl TaskTarget for PoseReference {
    const ROWS: &'static [SpatialAxis] =
        &[SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z, SpatialAxis::Rx, SpatialAxis::Ry, SpatialAxis::Rz];

    /// e = (x\* − x, log(R\* Rᵀ)): the rotation vector, of length at most π and along the world's axes, that
    /// rotates the frame to its target. **(MLS eq. 2.14)**
    fn deviation(self, pose: &Pose, velocity: &Twist) -> Result<TaskDeviation, ControllerError> {
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
        let mut deviation = position.deviation(pose, velocity)?;
        let turn = rotation_vector(&wanted.rotation, &pose.rotation);
        for k in 0..3 {
            deviation.position[k + 3] = turn[k];
            deviation.velocity[k + 3] = angular[k] - velocity.angular[k];
            deviation.acceleration[k + 3] = acceleration.angular[k];
        }
        Ok(deviation)
    }
}

/// A reference that can fail.
impl<T: TaskTarget, E: Into<Box<dyn std::error::Error + Send + Sync>>> TaskTarget for Result<T, E> {
    const ROWS: &'static [SpatialAxis] = T::ROWS;

    fn deviation(self, pose: &Pose, velocity: &Twist) -> Result<TaskDeviation, ControllerError> {
        let target: Result<T, CallbackError> = self.outcome();
        target?.deviation(pose, velocity)
    }
}

/// log(A Bᵀ), with A and B given by rows.
fn rotation_vector(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [f64; 3] {
    let turn = Matrix3::from_fn(|i, j| (0..3).map(|k| a[i][k] * b[j][k]).sum());
    let quaternion = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    Quaternion::from_xyzw([quaternion.i, quaternion.j, quaternion.k, quaternion.w]).log()
}
