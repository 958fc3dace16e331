//! The lab's face: what a web page may ask of the library, checked at the boundary.
//!
//! Every call that can fail returns a [`LabError`], which JavaScript receives as an `Error` with the same
//! message; a panic would kill the module, so non-finite numbers and wrong lengths are refused here. Vectors
//! cross as plain lists of numbers, matrices row by row. Nothing is computed here that the library can
//! compute: these types hold a state, count steps, and keep samples for the plots.
//!
//! The feature `chapter` holds the experiments of the chapter, `robots` the robots from files: two modules, so that the
//! page opens with the small one and fetches the other when someone comes to a robot.
//!
//! The same code runs natively, which is how it is tested; [`parity_values`] and [`robot_parity_values`] list the
//! numbers that both builds must agree on.

// The boundary: what is refused, and how the page is told.
mod error;
mod input;

// Samples in physics time.
mod samples;

// The chapter: any closed-form model, and one simulation per widget.
#[cfg(feature = "chapter")]
mod brick;
#[cfg(feature = "chapter")]
mod closed_form;
#[cfg(feature = "chapter")]
mod falling_arm;
#[cfg(feature = "chapter")]
mod knife_edge;
#[cfg(feature = "chapter")]
mod race;
#[cfg(feature = "chapter")]
mod replay;
#[cfg(feature = "chapter")]
mod without_coriolis;
#[cfg(feature = "chapter")]
mod workbench;

// Robots from files.
#[cfg(feature = "robots")]
mod drawn_body;
#[cfg(feature = "robots")]
mod robot;

// What native and WebAssembly builds are compared on.
mod parity;

pub use error::LabError;
#[cfg(feature = "chapter")]
pub use {
    brick::Brick,
    closed_form::ClosedForm,
    falling_arm::FallingArm,
    knife_edge::{Blade, knife_edge_defect},
    parity::parity_values,
    race::Race,
    replay::Replay,
    workbench::Workbench,
};
#[cfg(feature = "robots")]
pub use {parity::robot_parity_values, robot::Robot};

/// The names of the integrators, in the order of the library's table.
#[cfg(feature = "chapter")]
#[wasm_bindgen::prelude::wasm_bindgen(js_name = integratorNames)]
pub fn integrator_names() -> Vec<String> {
    dynamics::Integrator::ALL.iter().map(|row| row.name().to_owned()).collect()
}
