//! The files that a person handed over.

use robot_dynamics::FileSet;
use wasm_bindgen::prelude::wasm_bindgen;

/// Files by their paths: a robot's, those that it includes, meshes that inertia comes from.
#[wasm_bindgen]
#[derive(Clone, Debug, Default)]
pub struct RobotFiles(pub(crate) FileSet);

#[wasm_bindgen]
impl RobotFiles {
    /// None.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// One more.
    pub fn add(&mut self, path: &str, content: Vec<u8>) {
        self.0.insert(path, content);
    }
}
