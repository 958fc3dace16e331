//! The contact points of two shapes.

use super::closest_points::{self, ClosestPoints, Line};

/// The most contact points of a pair: of many, the deepest, and the outermost in directions all around.
pub(super) const MOST_PAIR_POINTS: usize = 9;

/// Two shapes in their placements.
#[allow(clippy::large_enum_variant)] // one at a time, on the stack
pub(super) enum PlacedPair {
    /// Balls and capsules.
    Lines([Line; 2]),
    /// Other shapes: each point, and whether this is its first number.
    Points([Option<(ClosestPoints, bool)>; MOST_PAIR_POINTS]),
}

impl PlacedPair {
    /// The possible contact points, with their numbers.
    pub(super) fn each(&self, mut visit: impl FnMut(usize, ClosestPoints)) {
        match self {
            Self::Lines([one, two]) => {
                for k in
                    (0..closest_points::MOST_NEAREST).filter(|k| closest_points::takes_part(one, two, *k))
                {
                    visit(k, closest_points::nearest(one, two, k));
                }
            }
            Self::Points(points) => {
                for (k, point) in points.iter().enumerate() {
                    if let Some((point, true)) = point {
                        visit(k, *point);
                    }
                }
            }
        }
    }

    /// Point k, if there is one.
    pub(super) fn point(&self, k: usize) -> Option<ClosestPoints> {
        match self {
            Self::Lines([one, two]) => Some(closest_points::nearest(one, two, k)),
            Self::Points(points) => points[k].map(|(point, _)| point),
        }
    }
}
