//! Rotations about an axis and translations along one.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use crate::spatial::motion::MotionVector;
use crate::spatial::transform::Transform;

/// P Rz(q); only two columns change.
#[inline(always)]
pub(super) fn turn_about_z<S: Scalar>(p: &M3<S>, sine: S, cosine: S) -> M3<S> {
    let (x, y) = (p.column(0), p.column(1));
    M3::from_columns([(x * cosine).add_scaled(sine, y), (y * cosine).sub_scaled(sine, x), p.column(2)])
}

/// A translation along an axis of a placed body.
#[inline(always)]
pub(super) fn slide_along<S: Scalar>(place: &Transform<S>, axis: usize) -> MotionVector<S> {
    MotionVector { linear: place.rotation.column(axis), angular: V3::zero() }
}

/// A rotation about an axis of a placed body: ω × (0 − p) is the velocity at the origin.
#[inline(always)]
pub(super) fn turn_about<S: Scalar>(place: &Transform<S>, axis: usize) -> MotionVector<S> {
    let angular = place.rotation.column(axis);
    MotionVector { linear: place.translation.cross(angular), angular }
}
