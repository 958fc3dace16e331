//! Two shapes of links that may touch.

use robot_dynamics_core::Model;
use robot_dynamics_core::model::WORLD;
use robot_dynamics_description::Surface;

use super::placed_pair::PlacedPair;
use super::placed_shape::PlacedShape;

/// Two shapes of links that may touch.
#[derive(Clone, Debug)]
pub(super) struct ShapePair {
    /// Its number, which is independent of its index among the set's pairs.
    pub(super) number: usize,
    /// The indices of the shapes in the set.
    pub(super) shapes: [usize; 2],
    /// The body that carries both, or [`WORLD`].
    pub(super) common: usize,
    /// The coordinates that move one shape relative to the other, in increasing order.
    pub(super) coordinates: Vec<usize>,
    /// The last coordinate of each shape's path, if each moves on a path of its own.
    pub(super) ends: Option<[usize; 2]>,
    /// The surface of their contact.
    pub(super) surface: Surface,
}

impl ShapePair {
    pub(super) fn new(model: &Model, [(one, a), (two, b)]: [(usize, usize); 2], surface: Surface) -> Self {
        let common = model.common_ancestor([a, b]);
        let [own_a, own_b] = [a, b].map(|body| model.coordinates_between(common, body));
        let last = |body: usize| model.coordinates_between(WORLD, body).last().copied();
        let has_both = !own_a.is_empty() && !own_b.is_empty();
        let ends = match (last(a), last(b)) {
            (Some(a), Some(b)) if has_both => Some([a, b]),
            _ => None,
        };
        Self {
            number: 0,
            shapes: [one, two],
            common,
            coordinates: own_a.union(&own_b).copied().collect(),
            ends,
            surface,
        }
    }
}

/// The contact points of the pair with this number.
pub(super) struct PairContacts {
    pub(super) number: usize,
    pub(super) placed: [PlacedShape; 2],
    pub(super) meeting: PlacedPair,
}
