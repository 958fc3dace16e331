//! Vectors, rotations, placements, six-vectors and inertias, over any number.

pub(crate) mod algebra;
pub(crate) mod pose;
pub(crate) mod quaternion;
pub(crate) mod screw;
pub(crate) mod turn;
