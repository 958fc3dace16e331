//! Prismatic joint: translation along z.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;

use super::axis::slide_along;
use super::model::{Chart, JointModel, Position};
use crate::spatial::force::ForceVector;
use crate::spatial::motion::{AxisMotion, MotionVector};
use crate::spatial::rotation::JointRotation;
use crate::spatial::transform::Transform;

/// Translation along z.
#[derive(Clone, Copy)]
pub(super) struct Prismatic;

impl JointModel for Prismatic {
    #[inline(always)]
    fn chart(self) -> Chart {
        Chart::Line
    }
    #[inline(always)]
    fn reach(self, _: usize) -> (f64, f64) {
        (1.0, 0.0)
    }
    #[inline(always)]
    fn place<S: Scalar>(self, rest: &Transform<S>, at: &Position<'_, S>) -> Transform<S> {
        let translation = rest.translation.add_scaled(at.angle, rest.rotation.column(2));
        Transform { rotation: rest.rotation, translation }
    }
    #[inline(always)]
    fn turn<S: Scalar>(self, _: &Position<'_, S>) -> JointRotation<S> {
        JointRotation::None
    }
    #[inline(always)]
    fn screw<S: Scalar>(self, _: usize, place: &Transform<S>) -> MotionVector<S> {
        slide_along(place, 2)
    }
    #[inline(always)]
    fn force_along<S: Scalar>(self, _: usize, force: &ForceVector<S>) -> S {
        force.linear.get(2)
    }
    #[inline(always)]
    fn velocity<S: Scalar>(self, rate: &[S]) -> MotionVector<S> {
        let mut own = MotionVector::zero();
        own.linear.bump_z(rate[0]);
        own
    }
    /// Coriolis: 2 ω × e_z v.
    #[inline(always)]
    fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        motion.origin += motion.angular.cross_z(v[0] + v[0]);
        motion.origin.bump_z(a[0]);
    }
    #[inline(always)]
    fn accelerate_in_world<S: Scalar>(self, turn: &M3<S>, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        motion.slide(turn.column(2), v[0], a[0]);
    }
    #[inline(always)]
    fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &ForceVector<S>, tau: &mut [S]) {
        tau[0] = turn.column(2).dot(force.linear);
    }
}
