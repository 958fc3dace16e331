//! The lab's face: what a web page may ask of the library, checked at the boundary.
//!
//! Every call that can fail returns a [`LabError`], which JavaScript receives as an `Error` with the same
//! message; a panic would kill the module, so non-finite numbers and wrong lengths are refused here. Vectors
//! cross as plain lists of numbers, matrices row by row. Nothing is computed here that the library can
//! compute: these types hold a state, count steps, and keep samples for the plots.
//!
//! The same code runs natively, which is how it is tested; [`parity_values`] is the list of numbers that
//! both builds must agree on.

// The boundary: what is refused, and how the page is told.
mod error;
mod input;

// Samples in physics time.
mod samples;

// Any closed-form model.
mod closed_form;
mod without_coriolis;

// One simulation per widget.
mod brick;
mod drawn_body;
mod falling_arm;
mod knife_edge;
mod race;
mod replay;
mod robot;
mod workbench;

// What native and WebAssembly builds are compared on.
mod parity;

pub use brick::Brick;
pub use closed_form::ClosedForm;
pub use error::LabError;
pub use falling_arm::FallingArm;
pub use knife_edge::{Blade, knife_edge_defect};
pub use parity::parity_values;
pub use race::Race;
pub use replay::Replay;
pub use robot::Robot;
pub use workbench::Workbench;

use dynamics::Integrator;
use wasm_bindgen::prelude::wasm_bindgen;

/// The names of the integrators, in the order of the library's table.
#[wasm_bindgen(js_name = integratorNames)]
pub fn integrator_names() -> Vec<String> {
    Integrator::ALL.iter().map(|row| row.name().to_owned()).collect()
}
