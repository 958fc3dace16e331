//! The contact points of two shapes.

use super::closest::{self, Line, Nearest};

/// The most contact points of a pair: of many, the deepest, and the outermost in directions all around.
pub(super) const MOST_MEETING: usize = 9;

/// Two shapes in their placements.
#[allow(clippy::large_enum_variant)] // one at a time, on the stack
pub(super) enum Meeting {
    /// Balls and capsules.
    Lines([Line; 2]),
    /// Other shapes: each point, and whether this is its first number.
    Points([Option<(Nearest, bool)>; MOST_MEETING]),
}

impl Meeting {
    /// The possible contact points, with their numbers.
    pub(super) fn each(&self, mut look: impl FnMut(usize, Nearest)) {
        match self {
            Self::Lines([one, two]) => {
                for k in (0..closest::MOST_NEAREST).filter(|k| closest::takes_part(one, two, *k)) {
                    look(k, closest::nearest(one, two, k));
                }
            }
            Self::Points(points) => {
                for (k, point) in points.iter().enumerate() {
                    if let Some((point, true)) = point {
                        look(k, *point);
                    }
                }
            }
        }
    }

    /// Point k, if there is one.
    pub(super) fn point(&self, k: usize) -> Option<Nearest> {
        match self {
            Self::Lines([one, two]) => Some(closest::nearest(one, two, k)),
            Self::Points(points) => points[k].map(|(point, _)| point),
        }
    }
}
