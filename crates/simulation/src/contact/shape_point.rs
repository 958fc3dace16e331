//! A contact point of a shape, and its contact partner.

use nalgebra::Vector3;

/// The contact partner of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ContactPartner {
    /// A ground, by its index in the set.
    Ground(usize),
    /// A height field, by its index in the set.
    Field(usize),
    /// The first shape of a pair, by the pair's index in the set; the shape is the second.
    Pair(usize),
}

/// A point of a shape relative to a ground or another shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShapePoint {
    /// Its number among all points on all grounds, and then of all pairs.
    pub(super) number: usize,
    pub(super) shape: usize,
    pub(super) against: ContactPartner,
    /// The distance; negative if it penetrates \[m\].
    pub(super) gap: f64,
    /// The position in the world \[m\].
    pub(super) at: Vector3<f64>,
    /// In the world: the normal, which points into the shape, and two tangential directions.
    pub(super) axes: [Vector3<f64>; 3],
}
