//! The chapter's closed-form models, and one simulation per widget.

#[macro_use]
mod getters;

mod arm_drawing;
mod brick;
mod closed_form;
mod falling_arm;
mod knife_edge;
mod lab_arm;
mod parity;
mod race;
mod replay;
mod thrown_arm;
mod workbench;

pub use brick::{Brick, BrickDrift};
pub use closed_form::ClosedForm;
pub use falling_arm::{ArmEnergies, FallingArm};
pub use knife_edge::{Blade, BladeEnergyAccount, knife_edge_defect};
pub use parity::parity_values;
pub use race::Race;
pub use replay::Replay;
pub use thrown_arm::{ThrownArm, ThrownArmEnergyAccount};
pub use workbench::{HoldForecast, HoldTorques, Workbench};

/// The names of the integrators, in the order of the library's table.
#[wasm_bindgen::prelude::wasm_bindgen(js_name = integratorNames)]
pub fn integrator_names() -> Vec<String> {
    dynamics::Integrator::ALL.iter().map(|row| row.name().to_owned()).collect()
}
