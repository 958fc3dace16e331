//! The derivatives of rows whose factors depend on q: equalities, and limits of paths and of ball joints.
//!
//! The rows are geometry of the bodies, without inertia or forces. Their derivatives by q are central
//! differences, for every kind of row.

use robot_dynamics_core::{Model, Workspace, integrate};

use super::super::ImplicitIntegrator;
use super::super::equalities::EqualityMemory;

/// The displacement of a coordinate to either side \[rad, m\]. A row has an error of half its square times
/// the third derivative, and rounding of 1e-10.
const MOVE: f64 = 1e-6;

impl ImplicitIntegrator {
    /// Evaluates all such rows at q. A ball joint without rotation has the axis of v.
    pub(super) fn turn_rows(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64], v: &[f64]) {
        let Self { joints, impulses, equalities, paths, .. } = self;
        impulses.turn(&joints.stops, q, v);
        paths.turn(model, workspace, q, impulses);
        if let Some(equalities) = equalities {
            equalities.place(model, workspace, q);
            impulses.copy_all_equality_rows(equalities);
        }
    }

    /// Adds Σ pᵢ ∂aᵢ/∂q for the rows aᵢ and multipliers pᵢ to an nv×nv matrix, and returns ∂(aᵢ·x)/∂q of each
    /// row. The rows are then those at q.
    pub(super) fn vary_moving_rows(
        &mut self,
        (model, workspace): (&Model, &mut Workspace),
        q: &[f64],
        rows: &[(usize, f64)],
        x: &[f64],
        force: &mut [f64],
    ) -> Vec<f64> {
        let nv = model.nv;
        let mut velocity = vec![0.0; rows.len() * nv];
        if rows.is_empty() {
            return velocity;
        }
        let (mut way, mut moved) = (vec![0.0; nv], q.to_vec());
        for j in 0..nv {
            for sign in [1.0, -1.0] {
                way[j] = sign * MOVE;
                integrate(model, q, &way, &mut moved);
                self.turn_rows(model, workspace, &moved, x);
                for (&(row, multiplier), velocity) in rows.iter().zip(velocity.chunks_exact_mut(nv)) {
                    for &(k, factor) in &self.impulses.terms()[row] {
                        let rate = sign * factor / (2.0 * MOVE);
                        force[k * nv + j] += multiplier * rate;
                        velocity[j] += rate * x[k];
                    }
                }
            }
            way[j] = 0.0;
        }
        self.turn_rows(model, workspace, q, x);
        velocity
    }

    /// The forces of the last step along such rows, which act in the smooth part: the numbers of the rows,
    /// and the forces.
    pub(super) fn carried_rows(&self) -> Vec<(usize, f64)> {
        let own = self.kept.impulses.carried().iter().copied().enumerate();
        let own = own.filter(|(row, _)| self.impulses.moving(*row).is_some());
        let equal = self.kept.equalities.iter().flat_map(EqualityMemory::carried);
        let first = self.impulses.first_equality();
        let equal = equal.enumerate().map(|(i, force)| (first + i, *force));
        own.chain(equal).filter(|(_, force)| *force != 0.0).collect()
    }
}
