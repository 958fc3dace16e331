//! Without the feature `convex` only balls and capsules are known to touch each other.

use super::closest::Nearest;
use super::form::Form;
use super::touch::Placed;

/// No shape.
#[derive(Clone, Debug)]
pub(super) enum Convex {}

/// What is said of other pairs.
pub(super) const KNOWN: &str = "only balls and capsules are known to touch each other; the feature `convex` adds boxes, \
                                cylinders and convex meshes";

impl Convex {
    pub(super) fn new(_: &Form) -> Option<Self> {
        None
    }

    /// Points where two of them touch or are nearest.
    pub(super) fn meet(&self, _: &Self, _: &[Placed; 2], _: f64, _: impl FnMut(Nearest)) {
        match *self {}
    }
}
