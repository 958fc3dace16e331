//! The origin of a row of a position correction.

/// The origin of a row of a position correction.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CorrectedRow {
    /// Whether it leaves a part of a violation at the start of the step.
    pub is_from_start: bool,
    /// Whether it is an equality, which always acts.
    pub is_equality: bool,
    /// The number of a row of stops or equalities whose factors depend on q, and its sign.
    pub moving: Option<(usize, f64)>,
}
