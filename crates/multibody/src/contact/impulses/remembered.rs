//! What contacts remember from step to step.

use crate::contact::cone_problem::MOST_ROWS;
use crate::contact::placement::Placement;
use crate::contact::touch::TouchingPoint;
use crate::{ContactLaws, ContactSet};

/// What goes on from step to step.
#[derive(Clone, Debug)]
pub(crate) struct Remembered {
    pub(super) laws: ContactLaws,
    /// Of the last step, in rising order of their numbers.
    pub(super) carried: Vec<Carried>,
    /// Whether something was hit in the last step, here or on a joint's stop: then its forces do not go on.
    pub(super) was_impact: bool,
    /// Of each link, the impulse of the whole step so far \[N·s\].
    pub(super) impulses: Vec<[f64; 3]>,
}

/// A contact's force in the last step: normal, two tangential, then the moments about the same axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    pub(super) number: usize,
    pub(super) force: [f64; MOST_ROWS],
    pub(super) shift: f64,
    /// Of a pair's face: the point, as the first shape's body sees it.
    pub(super) seen: Option<TouchingPoint>,
}

impl Carried {
    /// The point on which it acts.
    pub(super) fn point(&self, set: &ContactSet, placement: &Placement) -> TouchingPoint {
        let Some(mut seen) = self.seen else { return set.point(placement, self.number) };
        let (rotation, p) = placement.body(set.shapes[seen.shape].body);
        seen.at = p + rotation * seen.at;
        seen.axes = seen.axes.map(|axis| rotation * axis);
        seen
    }

    /// The point as the first shape's body sees it.
    pub(super) fn seen(set: &ContactSet, placement: &Placement, point: &TouchingPoint) -> TouchingPoint {
        let (mut seen, (rotation, p)) = (*point, placement.body(set.shapes[point.shape].body));
        seen.at = rotation.tr_mul(&(seen.at - p));
        seen.axes = seen.axes.map(|axis| rotation.tr_mul(&axis));
        seen
    }
}

impl Remembered {
    /// Of nothing, with room for so many contacts and links.
    pub(crate) fn new(contacts: usize, links: usize) -> Self {
        Self {
            laws: ContactLaws::default(),
            carried: Vec::with_capacity(contacts),
            was_impact: false,
            impulses: vec![[0.0; 3]; links],
        }
    }

    /// An empty one of the same size.
    pub(crate) fn anew(&self) -> Self {
        Self::new(self.carried.capacity(), self.impulses.len())
    }

    pub(crate) fn copy_from(&mut self, other: &Self) {
        let Self { laws, carried, was_impact, impulses } = self;
        (*laws, *was_impact) = (other.laws, other.was_impact);
        carried.clone_from(&other.carried);
        impulses.copy_from_slice(&other.impulses);
    }
}
