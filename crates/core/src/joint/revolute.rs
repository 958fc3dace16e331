//! Revolute joint: rotation about z.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;

use super::axis::{turn_about, turn_about_z};
use super::model::{Chart, JointModel, Position};
use crate::spatial::force::ForceVector;
use crate::spatial::motion::{AxisMotion, MotionVector};
use crate::spatial::rotation::JointRotation;
use crate::spatial::transform::Transform;

/// Rotation about z.
#[derive(Clone, Copy)]
pub(super) struct Revolute;

impl JointModel for Revolute {
    #[inline(always)]
    fn chart(self) -> Chart {
        Chart::Line
    }
    #[inline(always)]
    fn reach(self, _: usize) -> (f64, f64) {
        (0.0, 1.0)
    }
    #[inline(always)]
    fn place<S: Scalar>(self, rest: &Transform<S>, at: &Position<'_, S>) -> Transform<S> {
        Transform {
            rotation: turn_about_z(&rest.rotation, at.sine, at.cosine),
            translation: rest.translation,
        }
    }
    #[inline(always)]
    fn turn<S: Scalar>(self, at: &Position<'_, S>) -> JointRotation<S> {
        JointRotation::about_z(at.sine, at.cosine)
    }
    #[inline(always)]
    fn screw<S: Scalar>(self, _: usize, place: &Transform<S>) -> MotionVector<S> {
        turn_about(place, 2)
    }
    #[inline(always)]
    fn force_along<S: Scalar>(self, _: usize, force: &ForceVector<S>) -> S {
        force.angular.get(2)
    }
    #[inline(always)]
    fn velocity<S: Scalar>(self, rate: &[S]) -> MotionVector<S> {
        let mut own = MotionVector::zero();
        own.angular.bump_z(rate[0]);
        own
    }
    /// ω + e_z v, α + ω × e_z v + e_z a.
    #[inline(always)]
    fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        motion.alpha += motion.angular.cross_z(v[0]);
        motion.alpha.bump_z(a[0]);
        motion.angular.bump_z(v[0]);
    }
    #[inline(always)]
    fn accelerate_in_world<S: Scalar>(self, turn: &M3<S>, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        motion.turn(turn.column(2), v[0], a[0]);
    }
    #[inline(always)]
    fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &ForceVector<S>, tau: &mut [S]) {
        tau[0] = turn.column(2).dot(force.angular);
    }
}
