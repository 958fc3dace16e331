//! The reference acceleration of a constraint's rows, and the state at which rows are added.

use robot_dynamics_core::{Model, Workspace};

/// The reference of one constraint's rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowReference {
    pub(super) row: usize,
    pub(super) rows: usize,
    pub(super) damping: f64,
    /// B of the rows after the first.
    pub(super) side_damping: f64,
    /// K d r of the first row.
    pub(super) spring: f64,
    /// Ȧ v of its only row, if it is included.
    pub(super) drift: Option<f64>,
    pub(super) of: RowOrigin,
}

/// The origin of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum RowOrigin {
    Friction,
    /// A limit of a ball joint's angle, or an equality.
    Stop,
    /// A limit of this coordinate, with the sign of its force times the joint's ratio.
    Limit(usize, f64),
    /// A limit of the tendon with this number.
    TendonLimit(usize, f64),
    Contact,
}

impl RowReference {
    /// The reference of one row.
    pub(super) fn new(of: RowOrigin, row: usize, damping: f64, spring: f64) -> Self {
        Self { row, rows: 1, damping, side_damping: damping, spring, drift: None, of }
    }
}

/// The robot's state and the step h.
pub(super) struct StepState<'a> {
    pub(super) model: &'a Model,
    pub(super) workspace: &'a mut Workspace,
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
    pub(super) h: f64,
    pub(super) dissipates: bool,
}
