//! Motions of joints: one file for each primitive joint.
//!
//! Compilation rotates every body's frame so that the joint's axis is z. All motions are expressed in that
//! frame.

mod axis;
mod floating;
mod helical;
mod model;
mod prismatic;
mod revolute;
mod spherical;

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;

use self::floating::Floating;
use self::helical::Helical;
use self::model::JointModel;
use self::prismatic::Prismatic;
use self::revolute::Revolute;
use self::spherical::Spherical;
use crate::spatial::force::ForceVector;
use crate::spatial::motion::{AxisMotion, MotionVector};
use crate::spatial::rotation::JointRotation;
use crate::spatial::transform::Transform;

pub use self::model::{Chart, Position};

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
    pub fn screw<S: Scalar>(self, k: usize, place: &Transform<S>) -> MotionVector<S> {
        by_motion!(self, own => own.screw(k, place))
    }

    /// See [`JointModel::force_along`].
    #[inline(always)]
    pub fn force_along<S: Scalar>(self, k: usize, force: &ForceVector<S>) -> S {
        by_motion!(self, own => own.force_along(k, force))
    }

    /// See [`JointModel::velocity`].
    #[inline(always)]
    pub fn velocity<S: Scalar>(self, rate: &[S]) -> MotionVector<S> {
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
    pub fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &ForceVector<S>, tau: &mut [S]) {
        by_motion!(self, own => own.forces_in_world(turn, force, tau));
    }
}
