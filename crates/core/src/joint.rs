//! Motions of joints: one file for each primitive joint.
//!
//! Compilation rotates every body's frame so that the joint's axis is z. All motions are expressed in that
//! frame.

mod floating;
mod helical;
mod prismatic;
mod revolute;
mod spherical;

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use self::floating::Floating;
use self::helical::Helical;
use self::prismatic::Prismatic;
use self::revolute::Revolute;
use self::spherical::Spherical;
use crate::spatial::screw::{AxisMotion, Force, Screw, Transform};
use crate::spatial::turn::JointRotation;

/// The motion of a body in its parent, in the body's own rotated frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrimitiveJoint {
    /// Rotation about z.
    Revolute,
    /// Translation along z.
    Prismatic,
    /// Rotation about z by q and translation along z by pitch·q.
    Helical(f64),
    /// Any rotation; velocities are about three axes fixed in the body.
    Spherical,
    /// Any motion; velocities are along, then about, axes fixed in the body.
    Floating,
}

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
    fn numbers<const N: usize>(&self, from: usize) -> [S; N] {
        core::array::from_fn(|k| self.q[self.start + from + k])
    }
}

/// The operations of a primitive joint.
trait JointModel: Copy {
    /// The meaning of its segment of q.
    fn chart(self) -> Chart;

    /// The magnitudes of the linear and of the angular part of DoF k, per unit of velocity.
    fn reach(self, k: usize) -> (f64, f64);

    /// `parent_from_body`; `rest` is its value at q = 0.
    fn place<S: Scalar>(self, rest: &Transform<S>, position: &Position<'_, S>) -> Transform<S>;

    /// The rotation of the body relative to `rest`, as in `place`.
    fn turn<S: Scalar>(self, position: &Position<'_, S>) -> JointRotation<S>;

    /// The motion of DoF k along the axes of `place`: the velocity of the point at the frame's origin, and ω.
    fn screw<S: Scalar>(self, k: usize, place: &Transform<S>) -> Screw<S>;

    /// sₖᵀ F for DoF k, F in the body's frame.
    fn force_along<S: Scalar>(self, k: usize, force: &Force<S>) -> S;

    /// The joint's own velocity in the body's frame.
    fn velocity<S: Scalar>(self, rate: &[S]) -> Force<S>;

    /// Adds the joint's own motion to the parent's; both are along the body's own axes at its origin.
    fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>);

    /// The same along the world's axes; `turn` is `world_from_body`.
    fn accelerate_in_world<S: Scalar>(self, turn: &M3<S>, v: &[S], a: &[S], motion: &mut AxisMotion<S>);

    /// sᵀ F for all DoFs, with F along the world's axes at the body's origin.
    fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &Force<S>, tau: &mut [S]);
}

/// Evaluates an expression for the variant of a motion.
macro_rules! by_motion {
    ($motion:expr, $own:ident => $result:expr) => {
        match $motion {
            PrimitiveJoint::Revolute => {
                let $own = Revolute;
                $result
            }
            PrimitiveJoint::Prismatic => {
                let $own = Prismatic;
                $result
            }
            PrimitiveJoint::Helical(pitch) => {
                let $own = Helical(pitch);
                $result
            }
            PrimitiveJoint::Spherical => {
                let $own = Spherical;
                $result
            }
            PrimitiveJoint::Floating => {
                let $own = Floating;
                $result
            }
        }
    };
}

impl PrimitiveJoint {
    /// The number of DoFs.
    #[inline(always)]
    pub fn nv(self) -> usize {
        match self.chart() {
            Chart::Line => 1,
            Chart::Rotation => 3,
            Chart::Placement => 6,
        }
    }

    /// See [`JointModel::chart`].
    #[inline(always)]
    pub fn chart(self) -> Chart {
        by_motion!(self, own => own.chart())
    }

    /// See [`JointModel::reach`].
    #[inline(always)]
    pub fn reach(self, k: usize) -> (f64, f64) {
        by_motion!(self, own => own.reach(k))
    }

    /// Whether some DoF rotates.
    pub fn turns(self) -> bool {
        (0..self.nv()).any(|k| self.reach(k).1 != 0.0)
    }

    /// Whether some DoF translates.
    pub fn slides(self) -> bool {
        (0..self.nv()).any(|k| self.reach(k).0 != 0.0)
    }

    /// See [`JointModel::place`].
    #[inline(always)]
    pub fn place<S: Scalar>(self, rest: &Transform<S>, position: &Position<'_, S>) -> Transform<S> {
        by_motion!(self, own => own.place(rest, position))
    }

    /// See [`JointModel::turn`].
    #[inline(always)]
    pub fn turn<S: Scalar>(self, position: &Position<'_, S>) -> JointRotation<S> {
        by_motion!(self, own => own.turn(position))
    }

    /// See [`JointModel::screw`].
    #[inline(always)]
    pub fn screw<S: Scalar>(self, k: usize, place: &Transform<S>) -> Screw<S> {
        by_motion!(self, own => own.screw(k, place))
    }

    /// See [`JointModel::force_along`].
    #[inline(always)]
    pub fn force_along<S: Scalar>(self, k: usize, force: &Force<S>) -> S {
        by_motion!(self, own => own.force_along(k, force))
    }

    /// See [`JointModel::velocity`].
    #[inline(always)]
    pub fn velocity<S: Scalar>(self, rate: &[S]) -> Force<S> {
        by_motion!(self, own => own.velocity(rate))
    }

    /// See [`JointModel::accelerate`].
    #[inline(always)]
    pub fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        by_motion!(self, own => own.accelerate(v, a, motion));
    }

    /// See [`JointModel::accelerate_in_world`].
    #[inline(always)]
    pub fn accelerate_in_world<S: Scalar>(self, turn: &M3<S>, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        by_motion!(self, own => own.accelerate_in_world(turn, v, a, motion));
    }

    /// See [`JointModel::forces_in_world`].
    #[inline(always)]
    pub fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &Force<S>, tau: &mut [S]) {
        by_motion!(self, own => own.forces_in_world(turn, force, tau));
    }
}

/// P Rz(q); only two columns change.
#[inline(always)]
fn turn_about_z<S: Scalar>(p: &M3<S>, sine: S, cosine: S) -> M3<S> {
    let (x, y) = (p.column(0), p.column(1));
    M3::from_columns([(x * cosine).add_scaled(sine, y), (y * cosine).sub_scaled(sine, x), p.column(2)])
}

/// A translation along an axis of a placed body.
#[inline(always)]
fn slide_along<S: Scalar>(place: &Transform<S>, axis: usize) -> Screw<S> {
    Screw { linear: place.rotation.column(axis), angular: V3::zero() }
}

/// A rotation about an axis of a placed body: ω × (0 − p) is the velocity at the origin.
#[inline(always)]
fn turn_about<S: Scalar>(place: &Transform<S>, axis: usize) -> Screw<S> {
    let angular = place.rotation.column(axis);
    Screw { linear: place.translation.cross(angular), angular }
}
