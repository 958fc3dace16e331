//! The results of a step: penetrations, laws, forces and contacts.

use nalgebra::Vector3;

use super::ContactImpulses;
use crate::contact::shape_point::ShapePoint;
use crate::contact::{ContactLaws, ContactProblem, ContactSet};

impl ContactImpulses {
    /// Records the penetration of the last search as that of the step's end.
    pub(crate) fn note_depth(&mut self) {
        let deepest = &mut self.memory.laws.deepest;
        *deepest = deepest.max(self.depth);
    }

    /// The number of contacts.
    pub fn count(&self) -> usize {
        self.active.len()
    }

    /// The accuracy of the laws so far.
    pub fn laws(&self) -> ContactLaws {
        self.memory.laws
    }

    /// The problem of the last step's velocities; `None` without contacts.
    pub(crate) fn last_problem(&self) -> Option<ContactProblem> {
        self.problem.sets().next()?;
        Some(self.problem.dense())
    }

    /// Each link's mean force in the last step \[N\].
    pub(crate) fn link_forces(&self) -> &[[f64; 3]] {
        &self.memory.impulses
    }

    /// The contacts of the last step, each with its mean force and moment in world axes.
    pub(in crate::contact) fn points(
        &self,
    ) -> impl Iterator<Item = (ShapePoint, (Vector3<f64>, Vector3<f64>))> + '_ {
        let totals = self.memory.totals.iter();
        totals.map(|total| (total.point(&self.set, &self.placement), (total.impulse, total.angular)))
    }

    pub(crate) fn ground_links(&self) -> &[String] {
        self.set.links()
    }

    pub(in crate::contact) fn set(&self) -> &ContactSet {
        &self.set
    }
}
