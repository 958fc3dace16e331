//! Constraints in implicit steps.

use robot_dynamics_core::Model;

use super::ConstraintSet;
use crate::ImplicitIntegrator;

impl ImplicitIntegrator {
    /// Adds these constraints to those of friction, stops and contacts. They become rows of the step's convex
    /// problem, with multipliers of either sign ([`constraint_forces`](Self::constraint_forces)).
    /// [`ConstraintSet::from_equalities`] returns a robot's own.
    ///
    /// At the end of a step A v = 0, and φ = 0 to 1e-12 m or rad; the constraints do no work. Rows that
    /// depend on others to 1e-5 of their length are left out. A [`Simulation`](crate::simulator::Simulation)
    /// rejects a start with a larger error. Single steps accept it, and their φ decays with a time constant
    /// of 0.1 s.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub(crate) fn with_constraints(self, model: &Model, constraints: &ConstraintSet) -> Self {
        constraints.check_robot(model);
        if constraints.is_empty() {
            return self;
        }
        let Some(rows) = constraints.equalities() else { return self };
        self.with_equalities(model, rows.clone(), constraints.row_names().to_vec())
    }
}
