//! Helical joint: rotation about z with translation along z.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;

use super::axis::{turn_about, turn_about_z};
use super::model::{Chart, JointModel, Position};
use crate::spatial::force::ForceVector;
use crate::spatial::motion::{AxisMotion, MotionVector};
use crate::spatial::rotation::JointRotation;
use crate::spatial::transform::Transform;

/// Rotation about z by q and translation along z by pitch·q; the pitch in m/rad.
#[derive(Clone, Copy)]
pub(super) struct Helical(pub f64);

impl JointModel for Helical {
    #[inline(always)]
    fn chart(self) -> Chart {
        Chart::Line
    }
    #[inline(always)]
    fn reach(self, _: usize) -> (f64, f64) {
        (self.0.abs(), 1.0)
    }
    #[inline(always)]
    fn place<S: Scalar>(self, rest: &Transform<S>, at: &Position<'_, S>) -> Transform<S> {
        Transform {
            rotation: turn_about_z(&rest.rotation, at.sine, at.cosine),
            translation: rest.translation.add_scaled(at.angle.scale(self.0), rest.rotation.column(2)),
        }
    }
    #[inline(always)]
    fn turn<S: Scalar>(self, at: &Position<'_, S>) -> JointRotation<S> {
        JointRotation::about_z(at.sine, at.cosine)
    }
    #[inline(always)]
    fn screw<S: Scalar>(self, _: usize, place: &Transform<S>) -> MotionVector<S> {
        let turn = turn_about(place, 2);
        let linear = turn.linear.add_scaled(S::from_f64(self.0), turn.angular);
        MotionVector { linear, ..turn }
    }
    #[inline(always)]
    fn force_along<S: Scalar>(self, _: usize, force: &ForceVector<S>) -> S {
        force.linear.get(2).scale(self.0) + force.angular.get(2)
    }
    #[inline(always)]
    fn velocity<S: Scalar>(self, rate: &[S]) -> MotionVector<S> {
        let mut own = MotionVector::zero();
        own.angular.bump_z(rate[0]);
        own.linear.bump_z(rate[0].scale(self.0));
        own
    }
    #[inline(always)]
    fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        motion.origin += motion.angular.cross_z((v[0] + v[0]).scale(self.0));
        motion.origin.bump_z(a[0].scale(self.0));
        motion.alpha += motion.angular.cross_z(v[0]);
        motion.alpha.bump_z(a[0]);
        motion.angular.bump_z(v[0]);
    }
    #[inline(always)]
    fn accelerate_in_world<S: Scalar>(self, turn: &M3<S>, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        let axis = turn.column(2);
        motion.slide(axis, v[0].scale(self.0), a[0].scale(self.0));
        motion.turn(axis, v[0], a[0]);
    }
    #[inline(always)]
    fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &ForceVector<S>, tau: &mut [S]) {
        let axis = turn.column(2);
        tau[0] = axis.dot(force.angular) + axis.dot(force.linear).scale(self.0);
    }
}
