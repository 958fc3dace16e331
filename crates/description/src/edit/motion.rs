//! The motion of a joint's child for a position and a velocity.

use crate::joint_kind::JointKind;
use crate::{Pose, Quaternion};

/// The placement of the child in the joint's frame at position q. `None` if an axis or a quaternion is zero.
#[doc(hidden)]
pub fn moved_by(kind: &JointKind, q: &[f64]) -> Option<Pose> {
    let along = |axis: [f64; 3], distance: f64| {
        Some(Pose::from_translation(unit(axis)?.map(|component| component * distance)))
    };
    match *kind {
        JointKind::Fixed => Some(Pose::IDENTITY),
        JointKind::Revolute { axis } | JointKind::Continuous { axis } => about(axis, q[0]),
        JointKind::Prismatic { axis } => along(axis, q[0]),
        JointKind::Helical { axis, pitch } => Some(along(axis, pitch * q[0])?.compose(&about(axis, q[0])?)),
        JointKind::Universal { first, second } => Some(about(first, q[0])?.compose(&about(second, q[1])?)),
        JointKind::Planar { normal } => {
            let triad = crate::joint_kind::z_onto(normal);
            let shift = Pose::from_translation(triad.rotate([q[0], q[1], 0.0]));
            Some(shift.compose(&about(normal, q[2])?))
        }
        JointKind::Spherical => turned([0.0; 3], q),
        JointKind::Floating => turned([q[0], q[1], q[2]], &q[3..]),
    }
}

/// The velocity of the child's frame in the joint's frame, linear and angular along the child's axes, at
/// position q and velocity v. `None` if an axis or a quaternion is zero.
pub(super) fn velocity_of(kind: &JointKind, q: &[f64], v: &[f64]) -> Option<[[f64; 3]; 2]> {
    let times = |axis: [f64; 3], rate: f64| Some(unit(axis)?.map(|component| component * rate));
    let none = [0.0; 3];
    Some(match *kind {
        JointKind::Fixed => [none, none],
        JointKind::Revolute { axis } | JointKind::Continuous { axis } => [none, times(axis, v[0])?],
        JointKind::Prismatic { axis } => [times(axis, v[0])?, none],
        JointKind::Helical { axis, pitch } => [times(axis, pitch * v[0])?, times(axis, v[0])?],
        JointKind::Universal { first, second } => {
            let first = about(second, q[1])?.inverse().rotate(times(first, v[0])?);
            let second = times(second, v[1])?;
            [none, core::array::from_fn(|i| first[i] + second[i])]
        }
        JointKind::Planar { normal } => {
            let shift = crate::joint_kind::z_onto(normal).rotate([v[0], v[1], 0.0]);
            [about(normal, q[2])?.inverse().rotate(shift), times(normal, v[2])?]
        }
        JointKind::Spherical => [none, [v[0], v[1], v[2]]],
        JointKind::Floating => [[v[0], v[1], v[2]], [v[3], v[4], v[5]]],
    })
}

fn turned(translation: [f64; 3], xyzw: &[f64]) -> Option<Pose> {
    let xyzw = [xyzw[0], xyzw[1], xyzw[2], xyzw[3]];
    let norm = xyzw.iter().map(|c| c * c).sum::<f64>();
    (norm > 0.0 && norm.is_finite()).then(|| Pose::from_translation_quaternion_xyzw(translation, xyzw))
}

fn about(axis: [f64; 3], angle: f64) -> Option<Pose> {
    let turn = Quaternion::exp(unit(axis)?.map(|component| component * angle));
    // The square of an angle beyond 1e154 overflows; the quaternion is then not finite, and the result
    // `None`.
    turned([0.0; 3], &turn.to_xyzw())
}

fn unit(axis: [f64; 3]) -> Option<[f64; 3]> {
    let norm = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
    (norm > 0.0 && norm.is_finite()).then(|| axis.map(|component| component / norm))
}
