//! Force vectors: forces, moments and momenta of rigid bodies.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

/// A force vector (f, n): a force and its moment about the reference point, or a momentum and its moment.
#[derive(Clone, Copy, Debug)]
pub struct ForceVector<S: Scalar> {
    pub linear: V3<S>,
    pub angular: V3<S>,
}

impl<S: Scalar> ForceVector<S> {
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
}
