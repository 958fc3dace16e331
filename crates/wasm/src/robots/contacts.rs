//! Where a robot touches, and a pose that does not begin in the ground.

use multibody::{JointKind, Workspace};
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;

/// How far above the ground a robot starts that would else start in it \[m\].
const DROP: f64 = 0.1;

#[wasm_bindgen]
impl Robot {
    /// The points where the robot touches and the forces there, six numbers a contact, in the world: the point \[m\], the force on the link \[N\].
    /// If two links touch, the opposite force acts on the other.
    #[wasm_bindgen(js_name = contactForces)]
    pub fn contact_forces(&self) -> Vec<f64> {
        self.simulation.contacts().iter().flat_map(|one| one.point.into_iter().chain(one.force)).collect()
    }
}

impl Robot {
    /// Lifts a pose that is in the ground until its lowest point is above it.
    pub(crate) fn lift(&self, q: &mut [f64]) {
        let Some(contacts) = self.simulation.contact_set() else { return };
        let base = self.model.joints().iter().find(|joint| joint.kind == JointKind::Floating);
        let gap = contacts.clearance(&self.model, &mut Workspace::new(&self.model), q);
        if let (Some(base), Some(gap)) = (base, gap.filter(|gap| *gap < 0.0)) {
            q[base.q_index + 2] += DROP - gap;
        }
    }
}
