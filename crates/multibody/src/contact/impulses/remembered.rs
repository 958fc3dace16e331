//! What contacts remember from step to step.

use crate::ContactLaws;
use crate::contact::cone_problem::MOST_ROWS;

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
