//! The distances between the shapes of links, and their rates.

use nalgebra::Vector3;
use robot_dynamics_core::{Model, Workspace};

use super::ContactSet;
use super::shape_point::ContactPartner;
use crate::placement::Placement;

/// The distance of two shapes.
#[derive(Clone, Copy, Debug)]
pub struct LinkDistance {
    /// The index of the pair of shapes in its set.
    pair: usize,
    /// The distance; negative if the shapes penetrate each other \[m\].
    pub gap: f64,
    /// The middle of the nearest points, in the world \[m\].
    at: Vector3<f64>,
    /// The unit vector from the second shape to the first, in the world.
    normal: Vector3<f64>,
}

/// The distances of the pairs of shapes that may touch.
#[derive(Clone, Debug)]
pub struct LinkDistances {
    contacts: ContactSet,
    placement: Placement,
    near: Vec<LinkDistance>,
}

impl LinkDistances {
    /// The pairs of a set.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn new(model: &Model, mut contacts: ContactSet) -> Self {
        model.check_identity(&contacts.robot, "the contact set");
        contacts.make_few_pairs(model);
        let near = Vec::with_capacity(contacts.pairs.len());
        Self { contacts, placement: Placement::new(model), near }
    }

    /// The number of pairs that exist.
    pub fn pair_count(&self) -> usize {
        self.contacts.pairs.len()
    }

    /// Finds the pairs within a distance at q: for each, its nearest points. Balls and capsules do not
    /// allocate.
    pub fn place(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64], within: f64) {
        let Self { contacts, placement, near } = self;
        placement.set(model, workspace, q);
        contacts.find_near(model, placement, within);
        near.clear();
        contacts.for_each_pair_contact(placement, within, |point| {
            let ContactPartner::Pair(pair) = point.against else { return };
            let found = LinkDistance { pair, gap: point.gap, at: point.at, normal: point.axes[0] };
            // Points of one pair are adjacent.
            match near.last_mut().filter(|last| last.pair == pair) {
                Some(last) if found.gap < last.gap => *last = found,
                Some(_) => {}
                None => near.push(found),
            }
        });
    }

    /// The pairs that were found.
    pub fn near(&self) -> &[LinkDistance] {
        &self.near
    }

    /// The links of a pair that was found.
    pub fn links(&self, distance: &LinkDistance) -> [&str; 2] {
        self.contacts.pairs[distance.pair].shapes.map(|shape| self.contacts.shapes[shape].link.as_str())
    }

    /// Writes a with ḋ = aᵀv for the distance d of a pair that was found.
    pub fn write_row(&self, model: &Model, distance: &LinkDistance, row: &mut [f64]) {
        row.fill(0.0);
        let pair = &self.contacts.pairs[distance.pair];
        for (shape, sign) in pair.shapes.into_iter().zip([1.0, -1.0]) {
            let ends = [self.contacts.shapes[shape].body, pair.common];
            // The nearest points are on one line along the normal, so ω does not change their velocity there.
            self.placement.each_motion_on(model, ends, distance.at, |dof, velocity, _| {
                row[dof.coordinate] += sign * dof.ratio * distance.normal.dot(&velocity);
            });
        }
    }
}
