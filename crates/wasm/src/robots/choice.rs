//! The options of a robot's motion.

use robot_dynamics::simulation::{Effect, Method, SimulationBuilder};

/// Options of the builder.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    /// `None` for the library's choice.
    pub(crate) method: Option<Method>,
    /// \[s\].
    pub(crate) step: f64,
    /// Effects that are switched off.
    pub(crate) off: Vec<Effect>,
    /// Whether to add level ground under a floating robot whose file has none.
    pub(crate) ground: bool,
}

impl Default for Choice {
    fn default() -> Self {
        Self { method: None, step: SimulationBuilder::DEFAULT_DT, off: Vec::new(), ground: false }
    }
}
