//! Poses of frames.

pub(crate) mod exponential;
mod log_derivative;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// A rigid placement `parent_from_child`: x_parent = R x_child + p. **(MR §3.3)**
///
/// `rotation` is R by rows (its columns are the child's axes in the parent). `translation` is the child's
/// origin in the parent \[m\]. No constructor takes four bare numbers: constructors from a quaternion name
/// its order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[doc(alias = "FramePose")]
pub struct Pose<S = f64> {
    /// R, by rows.
    pub rotation: [[S; 3]; 3],
    /// p \[m\].
    pub translation: [S; 3],
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Pose {
    /// The child frame is the parent frame.
    pub const IDENTITY: Self =
        Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };

    /// A translation without rotation.
    ///
    /// ```
    /// let pose = robot_dynamics::description::Pose::from_translation([1.0, 2.0, 3.0]);
    /// assert_eq!(pose.apply([0.1, 0.0, 0.0]), [1.1, 2.0, 3.0]);
    /// ```
    pub fn from_translation(translation: [f64; 3]) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    /// URDF's origin: R = Rz(yaw) Ry(pitch) Rx(roll), angles in rad about the parent's fixed axes.
    ///
    /// ```
    /// use std::f64::consts::FRAC_PI_2;
    /// // A quarter turn to the left: the child's x points along the parent's y.
    /// let pose = robot_dynamics::description::Pose::from_xyz_rpy([1.0, 0.0, 0.0], [0.0, 0.0, FRAC_PI_2]);
    /// let [x, y, _] = pose.apply([2.0, 0.0, 0.0]);
    /// assert!((x - 1.0).abs() < 1e-15 && (y - 2.0).abs() < 1e-15);
    /// ```
    pub fn from_xyz_rpy(translation: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Self {
        let (sr, cr) = roll.sin_cos();
        let (sp, cp) = pitch.sin_cos();
        let (sy, cy) = yaw.sin_cos();
        let rotation = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ];
        Self { rotation, translation }
    }

    /// From a quaternion x i + y j + z k + w, in the order x, y, z, w; it is normalized.
    ///
    /// ```
    /// // Half a turn about z, by a quaternion of any length.
    /// let pose = robot_dynamics::description::Pose::from_translation_quaternion_xyzw([1.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]);
    /// assert_eq!(pose.apply([0.5, 0.0, 7.0]), [0.5, 0.0, 7.0]);
    /// ```
    ///
    /// # Panics
    /// If the quaternion is zero or not finite.
    #[track_caller]
    pub fn from_translation_quaternion_xyzw(translation: [f64; 3], xyzw: [f64; 4]) -> Self {
        let norm = xyzw.iter().map(|c| c * c).sum::<f64>().sqrt();
        assert!(norm > 0.0 && norm.is_finite(), "a quaternion (x y z w) must not be zero, got {xyzw:?}");
        let [x, y, z, w] = xyzw.map(|c| c / norm);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Self { rotation, translation }
    }

    /// From a quaternion w + x i + y j + z k, in the order w, x, y, z; it is normalized.
    ///
    /// ```
    /// use robot_dynamics::description::Pose;
    /// let (shift, [w, x, y, z]) = ([1.0, 0.0, 0.0], [0.8, 0.0, 0.6, 0.0]);
    /// let pose = Pose::from_translation_quaternion_wxyz(shift, [w, x, y, z]);
    /// assert_eq!(pose, Pose::from_translation_quaternion_xyzw(shift, [x, y, z, w]));
    /// ```
    ///
    /// # Panics
    /// If the quaternion is zero or not finite.
    #[track_caller]
    pub fn from_translation_quaternion_wxyz(translation: [f64; 3], [w, x, y, z]: [f64; 4]) -> Self {
        Self::from_translation_quaternion_xyzw(translation, [x, y, z, w])
    }

    /// `parent_from_child · child_from_grandchild`.
    ///
    /// ```
    /// use robot_dynamics::description::Pose;
    /// let world_from_arm = Pose::from_xyz_rpy([1.0, 0.0, 0.5], [0.1, 0.2, 0.3]);
    /// let arm_from_hand = Pose::from_xyz_rpy([0.4, 0.1, 0.0], [0.3, -0.1, 0.0]);
    /// let (point, world_from_hand) = ([0.1, 0.2, 0.3], world_from_arm.compose(&arm_from_hand));
    /// let by_steps = world_from_arm.apply(arm_from_hand.apply(point));
    /// assert!((0..3).all(|i| (world_from_hand.apply(point)[i] - by_steps[i]).abs() < 1e-15));
    /// ```
    #[must_use]
    pub fn compose(&self, child: &Self) -> Self {
        let a = &self.rotation;
        let b = &child.rotation;
        let rotation = core::array::from_fn(|i| {
            core::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j])
        });
        Self { rotation, translation: self.apply(child.translation) }
    }

    /// `child_from_parent`.
    ///
    /// ```
    /// let world_from_arm = robot_dynamics::description::Pose::from_xyz_rpy([1.0, 0.0, 0.5], [0.1, 0.2, 0.3]);
    /// let back = world_from_arm.inverse().apply(world_from_arm.apply([0.1, 0.2, 0.3]));
    /// assert!(back.iter().zip([0.1, 0.2, 0.3]).all(|(back, x)| (back - x).abs() < 1e-15));
    /// ```
    #[must_use]
    pub fn inverse(&self) -> Self {
        let r = &self.rotation;
        let rotation: [[f64; 3]; 3] = core::array::from_fn(|i| core::array::from_fn(|j| r[j][i]));
        let back = Self { rotation, translation: [0.0; 3] }.apply(self.translation);
        Self { rotation, translation: back.map(|x| -x) }
    }

    /// max |RᵀR − 1| and |det R − 1|: 0 for a rotation, NaN if a number is NaN.
    pub fn rotation_defect(&self) -> f64 {
        let [a, b, c] = self.rotation.map(nalgebra::Vector3::from);
        [a.dot(&a) - 1.0, b.dot(&b) - 1.0, c.dot(&c) - 1.0, a.dot(&b), b.dot(&c), c.dot(&a)]
            .into_iter()
            .chain([a.cross(&b).dot(&c) - 1.0])
            .map(f64::abs)
            .fold(0.0, |worst: f64, x| if x.is_nan() { f64::NAN } else { worst.max(x) })
    }

    /// The point x_child, in the parent frame \[m\].
    ///
    /// ```
    /// use std::f64::consts::FRAC_PI_2;
    /// let pose = robot_dynamics::description::Pose::from_xyz_rpy([1.0, 0.0, 0.0], [FRAC_PI_2, 0.0, 0.0]);
    /// let [x, _, z] = pose.apply([0.0, 2.0, 0.0]); // rotated about x, then translated
    /// assert!((x - 1.0).abs() < 1e-15 && (z - 2.0).abs() < 1e-15);
    /// ```
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.rotate(point);
        core::array::from_fn(|i| turned[i] + self.translation[i])
    }

    /// R v: a free vector's components in the parent frame.
    ///
    /// ```
    /// use std::f64::consts::FRAC_PI_2;
    /// let pose = robot_dynamics::description::Pose::from_xyz_rpy([1.0, 0.0, 0.0], [FRAC_PI_2, 0.0, 0.0]);
    /// let [x, _, z] = pose.rotate([0.0, 2.0, 0.0]); // a direction is rotated, not translated
    /// assert!(x.abs() < 1e-15 && (z - 2.0).abs() < 1e-15);
    /// ```
    pub fn rotate(&self, v: [f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }
}
