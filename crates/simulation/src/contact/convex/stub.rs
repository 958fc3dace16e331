//! Without the feature `convex`, only balls and capsules can touch each other.

use super::closest_points::ClosestPoints;
use super::contact_geometry::ContactGeometry;
use super::placed_shape::PlacedShape;

/// A type without values.
#[derive(Clone, Debug)]
pub(super) enum Convex {}

/// The reason why other pairs are left out.
pub(super) const KNOWN: &str = "only balls and capsules are known to touch each other; the feature `convex` adds boxes, \
                                cylinders and convex meshes";

impl Convex {
    pub(super) fn new(_: &ContactGeometry) -> Option<Self> {
        None
    }

    /// The contact points or nearest points of two shapes.
    pub(super) fn meet(&self, _: &Self, _: &[PlacedShape; 2], _: f64, _: impl FnMut(ClosestPoints)) {
        match *self {}
    }
}
