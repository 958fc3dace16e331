//! The memory of contacts between steps.

use nalgebra::Vector3;
use robot_dynamics_core::clone_in_place::clone_in_place;

use crate::contact::cone_problem::MOST_ROWS;
use crate::contact::shape_point::ShapePoint;
use crate::placement::Placement;
use crate::{ContactLaws, ContactSet};

clone_in_place! {
    /// The memory between steps.
    #[derive(Debug)]
    pub struct ContactMemory {
        pub(super) laws: ContactLaws,
        /// The contacts of the last step, in increasing order of their numbers.
        pub(super) carried: Vec<CarriedForce>,
        /// The impulse on each link in the whole step so far \[N·s\].
        pub(super) impulses: Vec<[f64; 3]>,
        /// The impulse of each contact in the whole step so far, in increasing order of their numbers.
        pub(super) totals: Vec<TotalImpulse>,
    }
}

/// A contact's impulse in all parts of a step, in world axes; after division by the step's length, its force.
#[derive(Clone, Copy, Debug)]
pub(super) struct TotalImpulse {
    pub(super) number: usize,
    /// One of the trees of the contact.
    pub(super) tree: usize,
    /// \[N·s\]
    pub(super) impulse: Vector3<f64>,
    /// About the moving contact point \[N·m·s\].
    pub(super) angular: Vector3<f64>,
    /// The point of the last part in which it acted, in the world.
    pub(super) point: ShapePoint,
    /// As in [`CarriedForce`].
    pub(super) seen: Option<ShapePoint>,
}

impl TotalImpulse {
    /// The contact point at the end of the step.
    pub(super) fn point(&self, set: &ContactSet, placement: &Placement) -> ShapePoint {
        let point = point_of(self.seen.as_ref(), self.number, set, placement);
        if point.gap.is_finite() { point } else { self.point }
    }
}

/// The point of this number, or the one fixed to the first shape's body.
fn point_of(seen: Option<&ShapePoint>, number: usize, set: &ContactSet, placement: &Placement) -> ShapePoint {
    let Some(mut seen) = seen.copied() else { return set.point(placement, number) };
    let (rotation, p) = placement.body(set.shapes[seen.shape].body);
    seen.at = p + rotation * seen.at;
    seen.axes = seen.axes.map(|axis| rotation * axis);
    seen
}

/// A contact's force in the last step: normal, two tangential, then the moments about the same axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct CarriedForce {
    pub(super) number: usize,
    /// The trees of the contact; [`NONE`](robot_dynamics_core::factorization::sparse::NONE) for the ground.
    pub(super) trees: [usize; 2],
    /// Whether it continues in this step: its component had no impact in the last one.
    pub(super) acts: bool,
    pub(super) force: [f64; MOST_ROWS],
    pub(super) shift: f64,
    /// For a pair's face: the point in the frame of the first shape's body.
    pub(super) seen: Option<ShapePoint>,
}

impl CarriedForce {
    /// One of its trees.
    pub(super) fn tree(&self) -> usize {
        self.trees[0].min(self.trees[1])
    }

    /// The contact point.
    pub(super) fn point(&self, set: &ContactSet, placement: &Placement) -> ShapePoint {
        point_of(self.seen.as_ref(), self.number, set, placement)
    }

    /// The point in the frame of the first shape's body.
    pub(super) fn seen(set: &ContactSet, placement: &Placement, point: &ShapePoint) -> ShapePoint {
        let (mut seen, (rotation, p)) = (*point, placement.body(set.shapes[point.shape].body));
        seen.at = rotation.tr_mul(&(seen.at - p));
        seen.axes = seen.axes.map(|axis| rotation.tr_mul(&axis));
        seen
    }
}

impl ContactMemory {
    /// An empty memory with space for this number of contacts and links.
    pub fn new(contacts: usize, links: usize) -> Self {
        Self {
            laws: ContactLaws::default(),
            carried: Vec::with_capacity(contacts),
            impulses: vec![[0.0; 3]; links],
            totals: Vec::with_capacity(contacts),
        }
    }

    /// An empty memory of the same size.
    pub(crate) fn anew(&self) -> Self {
        Self::new(self.carried.capacity(), self.impulses.len())
    }

    pub fn copy_from(&mut self, other: &Self) {
        let Self { laws, carried, impulses, totals } = self;
        *laws = other.laws;
        carried.clone_from(&other.carried);
        impulses.copy_from_slice(&other.impulses);
        totals.clone_from(&other.totals);
    }

    /// Starts the sums of a step.
    pub(crate) fn clear_impulses(&mut self) {
        self.impulses.fill([0.0; 3]);
        self.totals.clear();
    }

    /// Divides the sums by the step's length h to obtain mean forces.
    pub(crate) fn average_impulses(&mut self, h: f64) {
        for impulse in &mut self.impulses {
            *impulse = impulse.map(|impulse| impulse / h);
        }
        for total in &mut self.totals {
            total.impulse /= h;
            total.angular /= h;
        }
    }

    /// Adds to a contact's sum. The first `known` sums are in order; new ones follow them.
    pub(super) fn add_impulse(&mut self, known: usize, new: &TotalImpulse) {
        match self.totals[..known].binary_search_by_key(&new.number, |total| total.number) {
            Ok(at) => {
                let total = &mut self.totals[at];
                let (impulse, angular) = (total.impulse + new.impulse, total.angular + new.angular);
                *total = TotalImpulse { impulse, angular, ..*new };
            }
            Err(_) => self.totals.push(*new),
        }
    }
}
