//! The files that the user opened.

use robot_dynamics::FileSet;
use wasm_bindgen::prelude::wasm_bindgen;

/// Files by path: a robot's, those that it includes, and meshes that determine inertia.
#[wasm_bindgen]
#[derive(Clone, Debug, Default)]
pub struct RobotFiles(pub(crate) FileSet);

#[wasm_bindgen]
impl RobotFiles {
    /// An empty set.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file.
    pub fn add(&mut self, path: &str, content: Vec<u8>) {
        self.0.insert(path, content);
    }
}
