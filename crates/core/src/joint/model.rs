//! The operations of a primitive joint.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;

use crate::spatial::force::ForceVector;
use crate::spatial::motion::{AxisMotion, MotionVector};
use crate::spatial::rotation::JointRotation;
use crate::spatial::transform::Transform;

/// The meaning of a joint's segment of q.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chart {
    /// One number, with q̇ = v.
    Line,
    /// A quaternion.
    Rotation,
    /// A position and a quaternion.
    Placement,
}

/// The position of a joint.
#[derive(Clone, Copy)]
pub struct Position<'a, S> {
    /// The coordinate of a one-DoF joint, with sine and cosine; other joints ignore these numbers.
    pub angle: S,
    pub sine: S,
    pub cosine: S,
    /// All of q, and the index of the joint's first number.
    pub q: &'a [S],
    pub start: usize,
}

impl<S: Scalar> Position<'_, S> {
    /// Consecutive numbers of the joint.
    #[inline(always)]
    pub(super) fn numbers<const N: usize>(&self, from: usize) -> [S; N] {
        core::array::from_fn(|k| self.q[self.start + from + k])
    }
}

/// The operations of a primitive joint.
pub(super) trait JointModel: Copy {
    /// The meaning of its segment of q.
    fn chart(self) -> Chart;

    /// The magnitudes of the linear and of the angular part of DoF k, per unit of velocity.
    fn reach(self, k: usize) -> (f64, f64);

    /// `parent_from_body`; `rest` is its value at q = 0.
    fn place<S: Scalar>(self, rest: &Transform<S>, position: &Position<'_, S>) -> Transform<S>;

    /// The rotation of the body relative to `rest`, as in `place`.
    fn turn<S: Scalar>(self, position: &Position<'_, S>) -> JointRotation<S>;

    /// The motion of DoF k along the axes of `place`: the velocity of the point at the frame's origin, and ω.
    fn screw<S: Scalar>(self, k: usize, place: &Transform<S>) -> MotionVector<S>;

    /// sₖᵀ F for DoF k, F in the body's frame.
    fn force_along<S: Scalar>(self, k: usize, force: &ForceVector<S>) -> S;

    /// The joint's own velocity in the body's frame.
    fn velocity<S: Scalar>(self, rate: &[S]) -> MotionVector<S>;

    /// Adds the joint's own motion to the parent's; both are along the body's own axes at its origin.
    fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>);

    /// The same along the world's axes; `turn` is `world_from_body`.
    fn accelerate_in_world<S: Scalar>(self, turn: &M3<S>, v: &[S], a: &[S], motion: &mut AxisMotion<S>);

    /// sᵀ F for all DoFs, with F along the world's axes at the body's origin.
    fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &ForceVector<S>, tau: &mut [S]);
}
