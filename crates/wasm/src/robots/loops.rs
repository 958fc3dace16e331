//! Closed loops and joint couplings of a robot's file: projection of a start onto them.

use robot_dynamics::constraints::{ConstraintOptions, project_position, project_velocity};
use robot_dynamics::simulation::Effect;
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;
use super::text::shown;

/// Tolerance of |φ| at the start \[m or rad\].
const TOLERANCE: f64 = 1e-10;

#[wasm_bindgen]
impl Robot {
    /// The reason if no method can satisfy the file's loops; `undefined` otherwise.
    #[wasm_bindgen(getter)]
    pub fn loose(&self) -> Option<String> {
        self.loose.as_deref().map(shown)
    }
}

impl Robot {
    /// Projects q and v onto the loops. A pose without a projection is unchanged, and the implicit method
    /// then closes the loops over time.
    pub(crate) fn close(&mut self, q: &mut Vec<f64>, v: &mut Vec<f64>) {
        if self.loops.is_empty() || self.choice.off.contains(&Effect::Equalities) {
            return;
        }
        let (model, loops, options) = (&self.model, &self.loops, ConstraintOptions::of_files());
        let workspace = &mut self.workspace;
        let (mut closed, mut slid) = (q.clone(), v.clone());
        if project_position(model, workspace, loops, &options, TOLERANCE, &mut closed).is_ok()
            && project_velocity(model, workspace, loops, &options, &closed, &mut slid).is_ok()
        {
            (*q, *v) = (closed, slid);
        }
    }
}
