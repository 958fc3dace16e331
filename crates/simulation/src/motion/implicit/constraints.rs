//! Equalities of a step, and the forces of its constraints.

use robot_dynamics_core::Model;

use super::ImplicitIntegrator;
use super::equalities::Equalities;
use crate::equality::rows::EqualityRows;

impl ImplicitIntegrator {
    /// Adds these rows, each with its name.
    pub(crate) fn with_equalities(mut self, model: &Model, rows: EqualityRows, names: Vec<String>) -> Self {
        self.impulses.make_room(rows.rows());
        self.components.unite(rows.rows().iter().map(|row| &row.terms[..]));
        self.resize_trees();
        let mut equalities = Equalities::new(model, rows, names);
        for kept in [&mut self.kept, &mut self.start] {
            kept.equalities = Some(equalities.memory().clone());
        }
        self.equalities = Some(equalities);
        self
    }

    /// The multiplier of each constraint's row by name, as the mean over the last step \[N, or N·m for a
    /// rotation\]. Row k exerts the force Aₖᵀλₖ. Dependent rows share their forces: λ has the least norm
    /// ([`Pivots::share`](super::pivots::Pivots::share)). Empty without [`with_constraints`](Self::with_constraints).
    pub(crate) fn constraint_forces(&self) -> impl Iterator<Item = (&str, f64)> {
        let (names, impulses) = match &self.equalities {
            Some(equalities) => (equalities.names(), equalities.shared_impulses()),
            None => (&[][..], Vec::new()),
        };
        names.iter().map(String::as_str).zip(impulses)
    }

    /// Adds the generalized forces of position limits in the last step, and the force of each tendon's limits
    /// along its length. They are means over the step, or over the last part of a divided step \[N·m or N\].
    /// Stops of ball joints' angles are not included.
    pub(crate) fn add_limit_forces(&self, coordinates: &mut [f64], tendons: &mut [f64]) {
        let forces = self.impulses.stop_forces();
        coordinates.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        for (row, number) in self.joints.tendon_rows() {
            tendons[number] += forces[row];
        }
        // Spatial tendons follow those over joints.
        let first = self.tendons_over_joints;
        for (row, number) in self.joints.path_rows() {
            tendons[first + number] += forces[row];
        }
    }
}
