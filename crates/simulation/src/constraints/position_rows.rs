//! φ(q) and A(q) of a constraint set, in memory that is used again at every configuration.

use robot_dynamics_core::{Model, Workspace};

use super::ConstraintSet;
use crate::equality::rows::EqualityRows;

/// The rows of a set that have φ, with φ̇ = A v.
#[derive(Clone, Debug)]
pub struct PositionRows {
    equalities: Option<EqualityRows>,
    count: usize,
}

impl PositionRows {
    /// The rows of a set; they are read after [`place`](Self::place).
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn new(model: &Model, set: &ConstraintSet) -> Self {
        set.check_robot(model);
        Self { equalities: set.equalities().cloned(), count: set.len() }
    }

    /// The number of rows, of which some may have no φ.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Computes the rows at q. Relations between coordinates and closed loops do not allocate.
    pub fn place(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        if let Some(equalities) = &mut self.equalities {
            equalities.place(model, workspace, q);
        }
    }

    /// Calls `visit` with φ of each row, and the coordinates of v with their factors.
    pub fn each(&self, mut visit: impl FnMut(f64, &[(usize, f64)])) {
        let rows = self.equalities.iter().flat_map(EqualityRows::rows);
        rows.for_each(|row| {
            if let Some(error) = row.error {
                visit(error, &row.terms);
            }
        });
    }
}
