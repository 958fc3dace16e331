//! Contact points of a robot, and a start pose above the ground.

use robot_dynamics::description::JointKind;
use robot_dynamics::model::Workspace;
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;

/// Height above the ground of a robot that would otherwise start in it \[m\].
const DROP: f64 = 0.1;

#[wasm_bindgen]
impl Robot {
    /// Contact points and forces in the world, six numbers each: the point \[m\], then the force on the link
    /// \[N\]. In a contact of two links the opposite force acts on the other.
    #[wasm_bindgen(js_name = contactForces)]
    pub fn contact_forces(&self) -> Vec<f64> {
        self.simulation.contacts().iter().flat_map(|one| one.point.into_iter().chain(one.force)).collect()
    }
}

impl Robot {
    /// Lifts a pose that penetrates the ground above it.
    pub(crate) fn lift(&self, q: &mut [f64]) {
        let Some(contacts) = self.simulation.contact_set() else { return };
        let base = self.model.joints().iter().find(|joint| joint.kind == JointKind::Floating);
        let gap = contacts.clearance(&self.model, &mut Workspace::new(&self.model), q);
        if let (Some(base), Some(gap)) = (base, gap.filter(|gap| *gap < 0.0)) {
            q[base.q_index + 2] += DROP - gap;
        }
    }
}
