//! The sets of the multipliers.

/// The set K of a block's multipliers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Set {
    /// One row, whose multiplier is between these bounds.
    Interval(f64, f64),
    /// The cone |p_t| ≤ slope·p_n.
    Cone(f64),
}

/// The most rows of a block: normal, two tangential, torsional and two rolling directions.
pub const MOST_ROWS: usize = 6;
