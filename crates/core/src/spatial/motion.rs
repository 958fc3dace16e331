//! Motion vectors: velocities, accelerations and displacements of rigid bodies.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use crate::spatial::force::ForceVector;

/// A motion vector (u, ω): a velocity or a spatial acceleration, or the velocity per unit rate of a DoF. u is
/// that of the body's point at the reference point.
#[derive(Clone, Copy, Debug)]
pub struct MotionVector<S: Scalar> {
    pub linear: V3<S>,
    pub angular: V3<S>,
}

impl<S: Scalar> MotionVector<S> {
    #[inline(always)]
    pub fn zero() -> Self {
        Self { linear: V3::zero(), angular: V3::zero() }
    }

    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        self.linear += other.linear;
        self.angular += other.angular;
    }

    /// self ← self + k x.
    #[inline(always)]
    pub fn add_scaled(&mut self, k: S, x: &Self) {
        self.linear = self.linear.add_scaled(k, x.linear);
        self.angular = self.angular.add_scaled(k, x.angular);
    }

    /// The power of a force about the same reference point: u · f + ω · n.
    #[inline(always)]
    pub fn dot(&self, force: &ForceVector<S>) -> S {
        self.linear.dot(force.linear) + self.angular.dot(force.angular)
    }
}

impl<S: Scalar> ForceVector<S> {
    /// The power of the force on a motion about the same reference point: f · u + n · ω.
    #[inline(always)]
    pub fn dot(&self, motion: &MotionVector<S>) -> S {
        self.linear.dot(motion.linear) + self.angular.dot(motion.angular)
    }
}

/// Angular velocity, and the acceleration field a(x) = `origin` + `gradient` x, in the body frame.
#[derive(Clone, Copy, Debug)]
pub struct BodyMotion<S: Scalar> {
    pub angular: V3<S>,
    /// \[α\]× + \[ω\]×\[ω\]×.
    pub gradient: M3<S>,
    /// Classical acceleration of the frame's origin.
    pub origin: V3<S>,
    /// α, stored in addition to the gradient that contains it.
    pub alpha: V3<S>,
}

/// Angular velocity and acceleration, and the classical acceleration of the origin, along the axes that each
/// use states.
#[derive(Clone, Copy, Debug)]
pub struct AxisMotion<S: Scalar> {
    pub angular: V3<S>,
    pub alpha: V3<S>,
    pub origin: V3<S>,
}

impl<S: Scalar> AxisMotion<S> {
    /// Adds a rotation about an axis with velocity v and acceleration a: α gains ω × z v.
    #[inline(always)]
    pub fn turn(&mut self, axis: V3<S>, v: S, a: S) {
        self.alpha = self.alpha.add_scaled(v, self.angular.cross(axis)).add_scaled(a, axis);
        self.angular = self.angular.add_scaled(v, axis);
    }

    /// Adds a translation along an axis with velocity v and acceleration a, and the Coriolis acceleration
    /// 2 ω × z v.
    #[inline(always)]
    pub fn slide(&mut self, axis: V3<S>, v: S, a: S) {
        self.origin = self.origin.add_scaled(v + v, self.angular.cross(axis)).add_scaled(a, axis);
    }
}
