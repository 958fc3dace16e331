//! Closed loops and couplings of a robot's file: a robot is placed on them.

use multibody::simulator::Effect;
use multibody::{ConstraintOptions, project_position, project_velocity};
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::{Robot, shown};

/// |φ| of a start \[m or rad\].
const TOLERANCE: f64 = 1e-10;

#[wasm_bindgen]
impl Robot {
    /// Why no method holds the file's loops; `undefined` where they can be held.
    #[wasm_bindgen(getter)]
    pub fn loose(&self) -> Option<String> {
        self.loose.as_deref().map(shown)
    }
}

impl Robot {
    /// Moves q and v onto the loops, by the shortest way; a pose from which none is found is left as it is, and the implicit method then
    /// closes it over time.
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
