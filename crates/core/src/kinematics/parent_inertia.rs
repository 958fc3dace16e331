//! Inertias transformed from a body's frame to its parent's.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, Sym3, V3};

use crate::Model;
use crate::joint::Position;
use crate::model::Body;
use crate::spatial::inertia::SpatialInertia;
use crate::spatial::rotation::JointRotation;
use crate::spatial::transform::Transform;
use crate::workspace::tree::Angles;

/// The rotation of body i's joint. Call after [`evaluate_angles`](crate::kinematics::placement::evaluate_angles).
#[inline(always)]
pub(crate) fn turn_of<S: Scalar>(model: &Model, angles: &Angles<S>, q: &[S], i: usize) -> JointRotation<S> {
    let (angle, sine, cosine) = (angles.angle[i], angles.sine[i], angles.cosine[i]);
    let start = model.bodies[i].q_index;
    model.bodies[i].motion.turn(&Position { angle, sine, cosine, q, start })
}

/// A body's own inertia, in its own frame.
#[inline(always)]
pub(crate) fn own_inertia<S: Scalar>(body: &Body) -> SpatialInertia<S> {
    SpatialInertia {
        mass: S::from_f64(body.mass),
        first_moment: V3::constant(&body.first_moment),
        inertia: Sym3::constant(&body.inertia),
    }
}

/// R A Rᵀ along the parent's axes: first the joint's rotation, then the constant one.
#[inline(always)]
pub fn turned<S: Scalar>(body: &Body, turn: &JointRotation<S>, a: &M3<S>) -> M3<S> {
    let rest = M3::constant(&body.rotation);
    rest.times(&turn.rotated(a)).times_transpose(&rest)
}

/// An inertia in the parent's frame, by the parallel-axis theorem from the origin to the centre of mass and
/// on. **(RBDA §2.13)**
///
/// h′ = R h + m p, I′ = R I Rᵀ + 2(p·g)1 − (p gᵀ + g pᵀ) with g = R h + ½ m p.
#[inline(always)]
pub(crate) fn in_parent<S: Scalar>(
    body: &Body,
    turn: &JointRotation<S>,
    place: &Transform<S>,
    own: &SpatialInertia<S>,
) -> SpatialInertia<S> {
    let p = place.translation;
    let h = place.rotation * own.first_moment;
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = turned(body, turn, &own.inertia.full()).rows();
    let ([px, py, pz], [gx, gy, gz]) = (p.array(), h.add_scaled(own.mass.scale(0.5), p).array());
    let [x, y, z] = [(px + px) * gx, (py + py) * gy, (pz + pz) * gz];
    let xy = xy - px * gy - py * gx;
    let xz = xz - px * gz - pz * gx;
    let yz = yz - py * gz - pz * gy;
    let inertia = M3::from_rows([[xx + y + z, xy, xz], [xy, yy + x + z, yz], [xz, yz, zz + x + y]]);
    SpatialInertia {
        mass: own.mass,
        first_moment: h.add_scaled(own.mass, p),
        inertia: Sym3::from_columns(&inertia),
    }
}
