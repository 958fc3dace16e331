//! Closed loops and couplings of a robot's file: each step of the implicit method holds them, and a robot is placed on them.

use multibody::{ConstraintOptions, project_position, project_velocity};
use wasm_bindgen::prelude::wasm_bindgen;

use super::method::Method;
use super::robot::Robot;

/// |φ| of a start \[m or rad\].
const TOLERANCE: f64 = 1e-10;

#[wasm_bindgen]
impl Robot {
    /// Whether the file has closed loops or couplings that the method of now does not hold: the implicit one alone does.
    #[wasm_bindgen(getter)]
    pub fn opened(&self) -> bool {
        !self.loops.is_empty() && !matches!(self.method, Method::Implicit(_))
    }

    /// Why no method holds the file's loops; `undefined` where they can be held.
    #[wasm_bindgen(getter)]
    pub fn loose(&self) -> Option<String> {
        self.loose.clone()
    }
}

impl Robot {
    /// Moves q and v onto the loops, by the shortest way; a pose from which none is found is left as it is, and the implicit method then
    /// closes it over time.
    pub(crate) fn close(&mut self) {
        if self.loops.is_empty() {
            return;
        }
        let (model, loops, options) = (&self.model, &self.loops, ConstraintOptions::of_files());
        let workspace = &mut self.workspace;
        let (mut q, mut v) = (self.q.clone(), self.v.clone());
        if project_position(model, workspace, loops, &options, TOLERANCE, &mut q).is_ok()
            && project_velocity(model, workspace, loops, &options, &q, &mut v).is_ok()
        {
            (self.q, self.v) = (q, v);
        }
    }
}
