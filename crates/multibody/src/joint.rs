//! How joints move: one file for each way in which a body moves in its parent, and the kinds that robot files name.
//!
//! Compiling turns every body's frame so that an axis is z; what is said here is said in that frame.

mod floating;
mod helical;
pub(crate) mod kind;
mod prismatic;
mod revolute;
mod spherical;

use dynamics::Scalar;

use self::floating::Floating;
use self::helical::Helical;
use self::prismatic::Prismatic;
use self::revolute::Revolute;
use self::spherical::Spherical;
use crate::spatial::algebra::{M3, V3};
use crate::spatial::screw::{AxisMotion, Force, Place, Screw};
use crate::spatial::turn::Turn;

/// How a body moves in its parent, in its own turned frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// About z.
    Revolute,
    /// Along z.
    Prismatic,
    /// About z by q and along z by pitch·q.
    Helical(f64),
    /// Any turn; three axes fixed in the body.
    Spherical,
    /// Any motion; linear then angular axes fixed in the body.
    Floating,
}

/// How a stretch of q is to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Chart {
    /// One number, with q̇ = v.
    Line,
    /// A quaternion.
    Rotation,
    /// A position and a quaternion.
    Placement,
}

/// Where a joint stands.
#[derive(Clone, Copy)]
pub(crate) struct Position<'a, S> {
    /// The number of a one-freedom joint, with sine and cosine; of others harmless numbers.
    pub angle: S,
    pub sine: S,
    pub cosine: S,
    /// All of q, and where the joint's numbers start.
    pub q: &'a [S],
    pub start: usize,
}

impl<S: Scalar> Position<'_, S> {
    /// Some of the joint's numbers.
    #[inline(always)]
    fn numbers<const N: usize>(&self, from: usize) -> [S; N] {
        core::array::from_fn(|k| self.q[self.start + from + k])
    }
}

/// What each way of moving says of itself.
trait Moves: Copy {
    /// How its stretch of q is read.
    fn chart(self) -> Chart;

    /// By how much freedom k slides, and by how much it turns, per unit of velocity: sizes alone.
    fn reach(self, k: usize) -> (f64, f64);

    /// `parent_from_body`, `rest` being that at q = 0.
    fn place<S: Scalar>(self, rest: &Place<S>, position: &Position<'_, S>) -> Place<S>;

    /// How the body is turned from where it rests: the turn within `place`.
    fn turn<S: Scalar>(self, position: &Position<'_, S>) -> Turn<S>;

    /// The motion of freedom k: the velocity of the point at the frame's origin, and ω, along the axes that `place`
    /// turns to.
    fn screw<S: Scalar>(self, k: usize, place: &Place<S>) -> Screw<S>;

    /// sₖᵀ F for freedom k, F in the body's frame.
    fn force_along<S: Scalar>(self, k: usize, force: &Force<S>) -> S;

    /// The joint's own velocity in the body's frame.
    fn velocity<S: Scalar>(self, rate: &[S]) -> Force<S>;

    /// Adds the joint's own motion to the parent's, both along the body's own axes at its origin.
    fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>);

    /// The same along the world's axes, `turn` being `world_from_body`.
    fn accelerate_in_world<S: Scalar>(self, turn: &M3<S>, v: &[S], a: &[S], motion: &mut AxisMotion<S>);

    /// sᵀ F of all freedoms, F along the world's axes at the body's origin.
    fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &Force<S>, tau: &mut [S]);
}

/// The same expression for whichever way it is.
macro_rules! by_motion {
    ($motion:expr, $own:ident => $result:expr) => {
        match $motion {
            Motion::Revolute => {
                let $own = Revolute;
                $result
            }
            Motion::Prismatic => {
                let $own = Prismatic;
                $result
            }
            Motion::Helical(pitch) => {
                let $own = Helical(pitch);
                $result
            }
            Motion::Spherical => {
                let $own = Spherical;
                $result
            }
            Motion::Floating => {
                let $own = Floating;
                $result
            }
        }
    };
}

impl Motion {
    /// Freedoms.
    #[inline(always)]
    pub(crate) fn nv(self) -> usize {
        match self.chart() {
            Chart::Line => 1,
            Chart::Rotation => 3,
            Chart::Placement => 6,
        }
    }

    /// See [`Moves::chart`].
    #[inline(always)]
    pub(crate) fn chart(self) -> Chart {
        by_motion!(self, own => own.chart())
    }

    /// See [`Moves::reach`].
    #[inline(always)]
    pub(crate) fn reach(self, k: usize) -> (f64, f64) {
        by_motion!(self, own => own.reach(k))
    }

    /// Whether some freedom turns.
    pub(crate) fn turns(self) -> bool {
        (0..self.nv()).any(|k| self.reach(k).1 != 0.0)
    }

    /// Whether some freedom slides.
    pub(crate) fn slides(self) -> bool {
        (0..self.nv()).any(|k| self.reach(k).0 != 0.0)
    }

    /// See [`Moves::place`].
    #[inline(always)]
    pub(crate) fn place<S: Scalar>(self, rest: &Place<S>, position: &Position<'_, S>) -> Place<S> {
        by_motion!(self, own => own.place(rest, position))
    }

    /// See [`Moves::turn`].
    #[inline(always)]
    pub(crate) fn turn<S: Scalar>(self, position: &Position<'_, S>) -> Turn<S> {
        by_motion!(self, own => own.turn(position))
    }

    /// See [`Moves::screw`].
    #[inline(always)]
    pub(crate) fn screw<S: Scalar>(self, k: usize, place: &Place<S>) -> Screw<S> {
        by_motion!(self, own => own.screw(k, place))
    }

    /// See [`Moves::force_along`].
    #[inline(always)]
    pub(crate) fn force_along<S: Scalar>(self, k: usize, force: &Force<S>) -> S {
        by_motion!(self, own => own.force_along(k, force))
    }

    /// See [`Moves::velocity`].
    #[inline(always)]
    pub(crate) fn velocity<S: Scalar>(self, rate: &[S]) -> Force<S> {
        by_motion!(self, own => own.velocity(rate))
    }

    /// See [`Moves::accelerate`].
    #[inline(always)]
    pub(crate) fn accelerate<S: Scalar>(self, v: &[S], a: &[S], motion: &mut AxisMotion<S>) {
        by_motion!(self, own => own.accelerate(v, a, motion));
    }

    /// See [`Moves::accelerate_in_world`].
    #[inline(always)]
    pub(crate) fn accelerate_in_world<S: Scalar>(
        self,
        turn: &M3<S>,
        v: &[S],
        a: &[S],
        motion: &mut AxisMotion<S>,
    ) {
        by_motion!(self, own => own.accelerate_in_world(turn, v, a, motion));
    }

    /// See [`Moves::forces_in_world`].
    #[inline(always)]
    pub(crate) fn forces_in_world<S: Scalar>(self, turn: &M3<S>, force: &Force<S>, tau: &mut [S]) {
        by_motion!(self, own => own.forces_in_world(turn, force, tau));
    }
}

/// P Rz(q): only two columns change.
#[inline(always)]
fn turn_about_z<S: Scalar>(p: &M3<S>, sine: S, cosine: S) -> M3<S> {
    let (x, y) = (p.column(0), p.column(1));
    M3::from_columns([(x * cosine).add_scaled(sine, y), (y * cosine).sub_scaled(sine, x), p.column(2)])
}

/// A slide along an axis of a placed body.
#[inline(always)]
fn slide_along<S: Scalar>(place: &Place<S>, axis: usize) -> Screw<S> {
    Screw { linear: place.rotation.column(axis), angular: V3::zero() }
}

/// A turn about an axis of a placed body: ω × (0 − p) is the velocity at the origin.
#[inline(always)]
fn turn_about<S: Scalar>(place: &Place<S>, axis: usize) -> Screw<S> {
    let angular = place.rotation.column(axis);
    Screw { linear: place.translation.cross(angular), angular }
}
