//! Bodies and degrees of freedom of a compiled robot: the arrays of the recursions.

use robot_dynamics_description::{PassiveForces, Pose};
use robot_dynamics_number::algebra::{Padded, PaddedColumns};

use crate::joint::PrimitiveJoint;

/// The parent index of bodies attached to the world.
pub const WORLD: usize = usize::MAX;

/// One moving body with its joint. Constants are in the rotated body frame.
#[derive(Clone, Debug)]
pub struct Body {
    /// Index of the parent body, smaller than the body's own, or [`WORLD`].
    pub parent: usize,
    pub motion: PrimitiveJoint,
    /// The reference point of its placement (module `reference_point`).
    pub point: usize,
    /// The reference point of its tree's root.
    pub tree: usize,
    /// Whether `point` is this body's own origin.
    pub is_point: bool,
    /// Whether that point differs from the parent's and the parent can rotate, so that quantities passing the
    /// joint are shifted.
    pub shifts_reference_point: bool,
    /// First entry of this body in q; that of the leader for a mimic joint.
    pub q_index: usize,
    /// First entry of this body among the tree's degrees of freedom (`Model::dofs`).
    pub dof: usize,
    /// `parent_from_body` at q = 0.
    pub rotation: PaddedColumns,
    pub translation: Padded,
    pub mass: f64,
    /// h = m c \[kg·m\].
    pub first_moment: Padded,
    /// Rotational inertia about the body frame's origin \[kg·m²\].
    pub inertia: PaddedColumns,
    /// ∫ r rᵀ dm = ½ tr(I) 1 − I about the body frame's origin \[kg·m²\].
    pub second_moment: PaddedColumns,
    /// The link in whose frame the public functions report this body's quantities.
    pub link: usize,
    /// `body_from_link`: from the link's frame to the rotated body frame.
    pub body_from_link: Pose,
}

/// One degree of freedom of the tree: tree value = ratio · v\[coordinate\] (+ offset, for positions).
#[derive(Clone, Copy, Debug)]
pub struct Dof {
    /// Entry in v.
    pub coordinate: usize,
    /// The ratio of a mimic joint, else 1.
    pub ratio: f64,
    /// The offset of a mimic joint, added to q; else 0.
    pub offset: f64,
    /// The body this degree of freedom moves.
    pub body: usize,
    /// Its joint, in `Model::joints`.
    pub joint: usize,
    /// One past the last DoF in the subtree of `body`, whose DoFs are contiguous.
    pub end: usize,
    pub passive: PassiveForces,
}
