//! Two shapes of links that may touch.

use std::collections::BTreeSet;

use robot_dynamics_core::Model;
use robot_dynamics_core::model::WORLD;
use robot_dynamics_description::Surface;

use super::meeting::Meeting;
use super::placed_shape::Placed;
use super::placement::coordinates_of;

/// Two shapes of links that may touch.
#[derive(Clone, Debug)]
pub(super) struct Pair {
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

impl Pair {
    pub(super) fn new(model: &Model, [(one, a), (two, b)]: [(usize, usize); 2], surface: Surface) -> Self {
        let path = |body: usize| {
            let parent = |&at: &usize| (model.bodies[at].parent != WORLD).then(|| model.bodies[at].parent);
            core::iter::successors((body != WORLD).then_some(body), parent)
        };
        let common = path(a).find(|body| path(b).any(|other| other == *body)).unwrap_or(WORLD);
        let own = |body: usize| {
            path(body).take_while(move |at| *at != common).flat_map(|at| {
                let dofs = model.bodies[at].dof..model.bodies[at].dof + model.bodies[at].motion.nv();
                dofs.map(|dof| model.dofs[dof].coordinate)
            })
        };
        let coordinates: BTreeSet<usize> = own(a).chain(own(b)).collect();
        let last = |body: usize| {
            let all = if body == WORLD { Vec::new() } else { coordinates_of(model, body) };
            all.last().copied()
        };
        let has_both = own(a).next().is_some() && own(b).next().is_some();
        let ends = match (last(a), last(b)) {
            (Some(a), Some(b)) if has_both => Some([a, b]),
            _ => None,
        };
        Self {
            number: 0,
            shapes: [one, two],
            common,
            coordinates: coordinates.into_iter().collect(),
            ends,
            surface,
        }
    }
}

/// The contact points of the pair with this number.
pub(super) struct Met {
    pub(super) number: usize,
    pub(super) placed: [Placed; 2],
    pub(super) meeting: Meeting,
}
