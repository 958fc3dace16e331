//! Any motion; velocities are along and about axes fixed in the body.

use robot_dynamics_description::rotation_of;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use super::axis::{slide_along, turn_about};
use super::model::{Chart, JointModel, Position};
use crate::spatial::force::ForceVector;
use crate::spatial::motion::{AxisMotion, MotionVector};
use crate::spatial::rotation::JointRotation;
use crate::spatial::transform::Transform;

/// See [`PrimitiveJoint::Floating`](super::PrimitiveJoint::Floating).
#[derive(Clone, Copy)]
pub(super) struct Floating;

impl JointModel for Floating {
    #[inline(always)]
    fn chart(self) -> Chart {
        Chart::Placement
    }
    #[inline(always)]
    fn reach(self, k: usize) -> (f64, f64) {
        if k < 3 { (1.0, 0.0) } else { (0.0, 1.0) }
    }
    #[inline(always)]
    fn place<S: Scalar>(self, rest: &Transform<S>, at: &Position<'_, S>) -> Transform<S> {
        Transform {
            rotation: rest.rotation.times(&rotation_of(&at.numbers(3))),
            translation: rest.translation + rest.rotation * V3::new(at.numbers(0)),
        }
    }
    #[inline(always)]
    fn turn<S: Scalar>(self, at: &Position<'_, S>) -> JointRotation<S> {
        JointRotation::Any(rotation_of(&at.numbers(3)))
    }
    #[inline(always)]
    fn screw<S: Scalar>(self, k: usize, place: &Transform<S>) -> MotionVector<S> {
        if k < 3 { slide_along(place, k) } else { turn_about(place, k - 3) }
    }
    #[inline(always)]
    fn force_along<S: Scalar>(self, k: usize, force: &ForceVector<S>) -> S {
        if k < 3 { force.linear.get(k) } else { force.angular.get(k - 3) }
    }
    #[inline(always)]
    fn velocity<S: Scalar>(self, rate: &[S]) -> MotionVector<S> {
        MotionVector {
            linear: V3::new([rate[0], rate[1], rate[2]]),
            angular: V3::new([rate[3], rate[4], rate[5]]),
        }
    }
    /// The velocity u and w are expressed in this frame, which rotates with ω, so u̇ gains ω × u.
    #[inline(always)]
    fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        let before = motion.angular;
        let (u, w) = (V3::new([v[0], v[1], v[2]]), V3::new([v[3], v[4], v[5]]));
        motion.angular += w;
        motion.alpha += before.cross(w) + V3::new([a[3], a[4], a[5]]);
        motion.origin += (motion.angular + before).cross(u) + V3::new([a[0], a[1], a[2]]);
    }
    #[inline(always)]
    fn accelerate_in_world<S: Scalar>(self, turn: &M3<S>, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        let before = motion.angular;
        let (u, w) = (*turn * V3::new([v[0], v[1], v[2]]), *turn * V3::new([v[3], v[4], v[5]]));
        motion.angular += w;
        motion.alpha += before.cross(w) + *turn * V3::new([a[3], a[4], a[5]]);
        motion.origin += (motion.angular + before).cross(u) + *turn * V3::new([a[0], a[1], a[2]]);
    }
    #[inline(always)]
    fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &ForceVector<S>, tau: &mut [S]) {
        for k in 0..3 {
            tau[k] = turn.column(k).dot(force.linear);
            tau[3 + k] = turn.column(k).dot(force.angular);
        }
    }
}
