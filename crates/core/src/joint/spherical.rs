//! Spherical joint: any rotation, with velocities about axes fixed in the body.

use robot_dynamics_description::rotation_of;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use super::axis::turn_about;
use super::model::{Chart, JointModel, Position};
use crate::spatial::force::ForceVector;
use crate::spatial::motion::{AxisMotion, MotionVector};
use crate::spatial::rotation::JointRotation;
use crate::spatial::transform::Transform;

/// See [`PrimitiveJoint::Spherical`](super::PrimitiveJoint::Spherical).
#[derive(Clone, Copy)]
pub(super) struct Spherical;

impl JointModel for Spherical {
    #[inline(always)]
    fn chart(self) -> Chart {
        Chart::Rotation
    }
    #[inline(always)]
    fn reach(self, _: usize) -> (f64, f64) {
        (0.0, 1.0)
    }
    #[inline(always)]
    fn place<S: Scalar>(self, rest: &Transform<S>, at: &Position<'_, S>) -> Transform<S> {
        let rotation = rest.rotation.times(&rotation_of(&at.numbers(0)));
        Transform { rotation, translation: rest.translation }
    }
    #[inline(always)]
    fn turn<S: Scalar>(self, at: &Position<'_, S>) -> JointRotation<S> {
        JointRotation::Any(rotation_of(&at.numbers(0)))
    }
    #[inline(always)]
    fn screw<S: Scalar>(self, k: usize, place: &Transform<S>) -> MotionVector<S> {
        turn_about(place, k)
    }
    #[inline(always)]
    fn force_along<S: Scalar>(self, k: usize, force: &ForceVector<S>) -> S {
        force.angular.get(k)
    }
    #[inline(always)]
    fn velocity<S: Scalar>(self, rate: &[S]) -> MotionVector<S> {
        MotionVector { linear: V3::zero(), angular: V3::new([rate[0], rate[1], rate[2]]) }
    }
    #[inline(always)]
    fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        let w = V3::new([v[0], v[1], v[2]]);
        motion.alpha += motion.angular.cross(w) + V3::new([a[0], a[1], a[2]]);
        motion.angular += w;
    }
    #[inline(always)]
    fn accelerate_in_world<S: Scalar>(self, turn: &M3<S>, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        let w = *turn * V3::new([v[0], v[1], v[2]]);
        motion.alpha += motion.angular.cross(w) + *turn * V3::new([a[0], a[1], a[2]]);
        motion.angular += w;
    }
    #[inline(always)]
    fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &ForceVector<S>, tau: &mut [S]) {
        for k in 0..3 {
            tau[k] = turn.column(k).dot(force.angular);
        }
    }
}
