//! The manifold of configurations: displacements, differences, interpolation.
//!
//! In q a spherical joint has a unit quaternion, and a floating joint \[x y z, qx qy qz qw\]. All other
//! coordinates are plain numbers. Quaternions cannot be added, so a displacement δ is in the space of v (nv
//! numbers, body frame), and q ⊕ δ moves q by it. q ⊕ δ is the exponential of SO(3) or SE(3) for those
//! joints, and the sum for the rest. δ = v·t is the displacement at constant body velocity v in t seconds.
//! Cost: O(n). q₁ ⊖ q₀ is not unique at half a turn.

mod check;
mod random;

pub use check::{check_configuration, check_vector};
pub use random::random_within_limits;

use robot_dynamics_description::{Quaternion, check_length, exp_motion, log_motion};
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::Model;
use crate::joint::Chart;

/// A segment of q and the corresponding segment of v.
#[derive(Clone, Copy, Debug)]
pub struct CoordinateRange {
    pub chart: Chart,
    /// First entry in q.
    pub q: usize,
    /// First entry in v.
    pub v: usize,
}

/// The segments of q, one for each body. A mimic joint repeats its leader's segment, so an operation on all
/// segments must be idempotent.
pub fn coordinate_ranges(model: &Model) -> impl Iterator<Item = CoordinateRange> + '_ {
    model.bodies.iter().map(|body| CoordinateRange {
        chart: body.motion.chart(),
        q: body.q_index,
        v: model.dofs[body.dof].coordinate,
    })
}

/// The quaternion that starts at entry `i` of q.
pub fn quaternion_at(q: &[f64], i: usize) -> Quaternion {
    Quaternion::from_xyzw([q[i], q[i + 1], q[i + 2], q[i + 3]])
}

/// The three numbers that start at entry `i`.
#[inline(always)]
pub fn vector_at<S: Scalar>(x: &[S], i: usize) -> V3<S> {
    V3::new([x[i], x[i + 1], x[i + 2]])
}

/// The configuration of all zeros, each quaternion the identity. It may lie outside joint limits.
///
/// ```
/// use robot_dynamics::model::neutral;
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::Model;
/// # let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// // A free body at the origin, not rotated.
/// assert_eq!(neutral(&model), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn neutral(model: &Model) -> Vec<f64> {
    let mut q = vec![0.0; model.nq()];
    for stretch in coordinate_ranges(model) {
        match stretch.chart {
            Chart::Line => {}
            Chart::Rotation => q[stretch.q + 3] = 1.0,
            Chart::Placement => q[stretch.q + 6] = 1.0,
        }
    }
    q
}

/// `moved` = q ⊕ δ: from q at the constant body velocity δ for unit time. **(MR §3.3.3)**
///
/// q and `moved` have nq entries, δ has nv. The quaternions of `moved` have unit length up to rounding.
///
/// # Panics
/// If a slice has the wrong length.
///
/// ```
/// use nalgebra::Vector3;
/// use robot_dynamics::description::{Base, LinkDescription, MassProperties, RobotDescription};
/// use robot_dynamics::model::{Model, integrate, neutral};
/// let mut robot = RobotDescription::new("brick");
/// robot.base = Base::Floating;
/// let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?;
/// robot.links.push(LinkDescription::new("brick", brick));
/// let model = Model::new(robot)?;
/// // Forward at 1 m/s while turning left by half a turn: a half circle of radius 1/π.
/// let mut q = neutral(&model);
/// integrate(&model, &neutral(&model), &[1.0, 0.0, 0.0, 0.0, 0.0, std::f64::consts::PI], &mut q);
/// assert!(q[0].abs() < 1e-15 && (q[1] - 2.0 / std::f64::consts::PI).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "exponential map")]
#[track_caller]
pub fn integrate(model: &Model, q: &[f64], displacement: &[f64], moved: &mut [f64]) {
    check_length("q", q.len(), model.nq);
    check_length("the displacement", displacement.len(), model.nv);
    check_length("the moved q", moved.len(), model.nq);
    for CoordinateRange { chart, q: i, v: k } in coordinate_ranges(model) {
        match chart {
            Chart::Line => moved[i] = q[i] + displacement[k],
            Chart::Rotation => {
                let turned = quaternion_at(q, i).times(Quaternion::exp(vector_at(displacement, k).array()));
                moved[i..i + 4].copy_from_slice(&turned.normalized().to_xyzw());
            }
            Chart::Placement => {
                let (turn, shift) = exp_motion(vector_at(displacement, k), vector_at(displacement, k + 3));
                let start = quaternion_at(q, i + 3);
                let position = vector_at(q, i) + V3::new(start.rotate(shift.array()));
                moved[i..i + 3].copy_from_slice(&position.array());
                moved[i + 3..i + 7].copy_from_slice(&start.times(turn).normalized().to_xyzw());
            }
        }
    }
}

/// δ = q₁ ⊖ q₀: the displacement with q₀ ⊕ δ = q₁, in body frames. Rotations are at most π. **(MR §3.3.3)**
///
/// Angles of one coordinate are not wrapped: their difference is the plain one.
///
/// ```
/// use robot_dynamics::model::{difference, integrate};
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let mut random = robot_dynamics::number::SplitMix64::new(1);
/// # let (one, two) = (random_state(&model, &mut random), random_state(&model, &mut random));
/// let (mut displacement, mut back) = (vec![0.0; model.nv()], vec![0.0; model.nq()]);
/// difference(&model, &one.q, &two.q, &mut displacement);
/// integrate(&model, &one.q, &displacement, &mut back); // q₀ ⊕ (q₁ ⊖ q₀) = q₁
/// let mut left = vec![0.0; model.nv()];
/// difference(&model, &two.q, &back, &mut left);
/// assert!(left.iter().all(|left| left.abs() < 1e-13));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "logarithm")]
#[track_caller]
pub fn difference(model: &Model, q0: &[f64], q1: &[f64], displacement: &mut [f64]) {
    check_length("q0", q0.len(), model.nq);
    check_length("q1", q1.len(), model.nq);
    check_length("the displacement", displacement.len(), model.nv);
    for CoordinateRange { chart, q: i, v: k } in coordinate_ranges(model) {
        match chart {
            Chart::Line => displacement[k] = q1[i] - q0[i],
            Chart::Rotation => {
                let turn = quaternion_at(q0, i).conjugate().times(quaternion_at(q1, i));
                displacement[k..k + 3].copy_from_slice(&turn.log());
            }
            Chart::Placement => {
                let start = quaternion_at(q0, i + 3);
                let turn = start.conjugate().times(quaternion_at(q1, i + 3));
                let shift = V3::new(start.rotate_back((vector_at(q1, i) - vector_at(q0, i)).array()));
                let (linear, angular) = log_motion(turn, shift);
                displacement[k..k + 3].copy_from_slice(&linear.array());
                displacement[k + 3..k + 6].copy_from_slice(&angular.array());
            }
        }
    }
}

/// `between` = q₀ ⊕ s (q₁ ⊖ q₀): q₀ at s = 0 and q₁ at s = 1, with a constant body velocity in between.
///
/// ```
/// use robot_dynamics::model::{interpolate, neutral};
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::Model;
/// # let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// // Half of a half turn about z is a quarter turn.
/// let (mut q1, mut between) = (neutral(&model), neutral(&model));
/// q1[3..].copy_from_slice(&[0.0, 0.0, 1.0, 0.0]);
/// interpolate(&model, &neutral(&model), &q1, 0.5, &mut between);
/// let half = std::f64::consts::FRAC_1_SQRT_2;
/// assert!((between[5] - half).abs() < 1e-15 && (between[6] - half).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "slerp")]
#[track_caller]
pub fn interpolate(model: &Model, q0: &[f64], q1: &[f64], s: f64, between: &mut [f64]) {
    let mut displacement = vec![0.0; model.nv];
    difference(model, q0, q1, &mut displacement);
    for x in &mut displacement {
        *x *= s;
    }
    integrate(model, q0, &displacement, between);
}

/// Scales every quaternion in q to unit length; a zero quaternion becomes NaN, which
/// [`check_configuration`] reports.
///
/// ```
/// use robot_dynamics::model::normalize_quaternions;
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::Model;
/// # let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// let mut q = [1.0, 2.0, 3.0, 0.0, 0.0, 3.0, 4.0];
/// normalize_quaternions(&model, &mut q);
/// assert!(q.iter().zip([1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8]).all(|(q, expected)| (q - expected).abs() < 1e-15));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If q has the wrong length.
#[track_caller]
pub fn normalize_quaternions(model: &Model, q: &mut [f64]) {
    check_length("q", q.len(), model.nq);
    for CoordinateRange { chart, q: i, .. } in coordinate_ranges(model) {
        let i = match chart {
            Chart::Line => continue,
            Chart::Rotation => i,
            Chart::Placement => i + 3,
        };
        let unit = quaternion_at(q, i).normalized();
        q[i..i + 4].copy_from_slice(&unit.to_xyzw());
    }
}
