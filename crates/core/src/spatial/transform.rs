//! Placements.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use crate::spatial::force::ForceVector;

/// `parent_from_body` in the current state.
#[derive(Clone, Copy, Debug)]
pub struct Transform<S: Scalar> {
    pub rotation: M3<S>,
    pub translation: V3<S>,
}

impl<S: Scalar> Transform<S> {
    /// `a_from_b` · `b_from_c`.
    #[inline(always)]
    pub fn compose(&self, next: &Self) -> Self {
        Self {
            rotation: self.rotation.times(&next.rotation),
            translation: self.rotation.times_plus(next.translation, self.translation),
        }
    }

    /// A force of the body's frame, along the parent's axes and about its origin.
    #[inline(always)]
    pub fn force_in_parent(&self, force: &ForceVector<S>) -> ForceVector<S> {
        let linear = self.rotation * force.linear;
        ForceVector { linear, angular: self.rotation * force.angular + self.translation.cross(linear) }
    }
}
