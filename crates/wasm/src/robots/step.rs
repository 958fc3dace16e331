//! The inputs of the last step.

/// A completed step.
#[derive(Clone, Debug)]
pub(crate) struct CompletedStep {
    /// q and v before the step.
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// The torque of motors and hand, constant over the step.
    pub(crate) tau: Vec<f64>,
    /// Its length \[s\].
    pub(crate) h: f64,
}
