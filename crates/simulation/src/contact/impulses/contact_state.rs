//! Contacts that act, that a step starts with, and that are near.

use super::MOST_ROWS;
use crate::contact::shape_point::ShapePoint;

/// A contact of this step.
#[derive(Clone, Copy, Debug)]
pub(super) struct ActiveContact {
    pub(super) point: ShapePoint,
    /// One of the trees of the contact.
    pub(super) tree: usize,
    /// The index of its first row, and the number of rows.
    pub(super) row: usize,
    pub(super) rows: usize,
    /// The factors of its rows, and the velocity added to its normal speed.
    pub(super) scale: [f64; MOST_ROWS],
    pub(super) bias: f64,
    /// The motion of the surfaces in addition to that of their bodies, along the axes of the contact.
    pub(super) surface_motion: [f64; MOST_ROWS],
    /// The index of the same contact in the last step, if any.
    pub(super) known: Option<usize>,
    /// Its velocity at the start of the step, as [`ContactImpulses::velocity`].
    pub(super) before: [f64; MOST_ROWS],
}

impl ActiveContact {
    pub(super) fn new(point: ShapePoint, tree: usize, known: Option<usize>) -> Self {
        let (scale, zero) = ([1.0; MOST_ROWS], [0.0; MOST_ROWS]);
        Self { point, tree, row: 0, rows: 1, scale, bias: 0.0, surface_motion: zero, known, before: zero }
    }
}

/// A contact of the last step at the start of a step: its gap and velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct InitialContact {
    pub(super) number: usize,
    pub(super) gap: f64,
    pub(super) velocity: [f64; MOST_ROWS],
}

/// Two shapes near each other at the end of a step: their trees, the gap, and the largest displacement of
/// each.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearbyPair {
    pub(super) trees: [usize; 2],
    pub(super) gap: f64,
    pub(super) ways: [f64; 2],
}
