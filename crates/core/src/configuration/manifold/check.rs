//! Rejects an invalid configuration q.

use thiserror::Error;

use super::{Chart, CoordinateRange, coordinate_ranges, quaternion_at};
use crate::Model;

/// The reason why a configuration is invalid.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ConfigurationError {
    /// Too many or too few numbers.
    #[error("q has {found} numbers, robot `{robot}` needs {expected}{hint}")]
    WrongLength {
        /// The robot's name.
        robot: String,
        /// Numbers given.
        found: usize,
        /// Numbers needed.
        expected: usize,
        /// A hint at a common mistake, or an empty text.
        hint: &'static str,
    },
    /// A number is NaN or infinite.
    #[error("q[{index}] (joint `{joint}`) is {value}; every number must be finite")]
    NotFinite {
        /// Its index in q.
        index: usize,
        /// Its joint.
        joint: String,
        /// Its value.
        value: f64,
    },
    /// A quaternion does not have unit length.
    #[error(
        "q[{first}..{}] (joint `{joint}`) is a quaternion x y z w of length {norm}, not 1; \
         normalise it, and check its order",
        .first + 4
    )]
    NotAUnitQuaternion {
        /// The first of its four numbers.
        first: usize,
        /// Its joint.
        joint: String,
        /// Its length.
        norm: f64,
    },
}

/// Checks that q has nq finite numbers and that its quaternions have unit length to within 1e-6.
///
/// Limits are not checked: a robot may violate them.
///
/// ```
/// use robot_dynamics::model::{ConfigurationError, check_configuration};
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::Model;
/// # let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// assert_eq!(check_configuration(&model, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.8]), Ok(()));
/// let refused = check_configuration(&model, &[0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 4.0]); // of length 5
/// assert!(matches!(refused, Err(ConfigurationError::NotAUnitQuaternion { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConfigurationError`] names the number and the joint.
pub fn check_configuration(model: &Model, q: &[f64]) -> Result<(), ConfigurationError> {
    if q.len() != model.nq {
        let hint = if model.nq > model.nv {
            "; a quaternion (x y z w) takes four, a floating base seven"
        } else {
            ""
        };
        let robot = model.name().to_owned();
        return Err(ConfigurationError::WrongLength { robot, found: q.len(), expected: model.nq, hint });
    }
    if let Some(index) = q.iter().position(|x| !x.is_finite()) {
        return Err(ConfigurationError::NotFinite { index, joint: joint_of(model, index), value: q[index] });
    }
    for CoordinateRange { chart, q: i, .. } in coordinate_ranges(model) {
        let first = match chart {
            Chart::Line => continue,
            Chart::Rotation => i,
            Chart::Placement => i + 3,
        };
        let norm = quaternion_at(q, first).norm();
        if (norm - 1.0).abs() > 1e-6 {
            return Err(ConfigurationError::NotAUnitQuaternion {
                first,
                joint: joint_of(model, first),
                norm,
            });
        }
    }
    Ok(())
}

/// The name of the joint of this entry of q.
fn joint_of(model: &Model, index: usize) -> String {
    let owner = model.joints.iter().find(|joint| (joint.q_index..joint.q_index + joint.nq).contains(&index));
    owner.map_or_else(String::new, |joint| joint.name.clone())
}
